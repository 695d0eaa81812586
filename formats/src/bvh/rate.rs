//! The frame rate that a printed frame time stands for.
//!
//! In: a [`Bvh`] and what the caller says. Out: a [`FrameRate`].
//!
//! A frame time whose reciprocal is a plain number (at most three decimals) is meant as it stands: 0.008 s is
//! 125 Hz, 0.2 s 5 Hz. Else it is the well-known rate nearest to it, if printing with as few digits explains the
//! difference and the rate changes by no more than 2.5 %: 0.0083333 s is 120 Hz, 0.017 s 60 Hz, but 0.03 s is
//! no 30 Hz.

use std::fmt;

use super::Bvh;
use super::guess::{Chosen, short};

/// Rates that cameras, capture systems and films use, Hz.
const RATES: [f64; 29] = [
    10.0,
    12.0,
    12.5,
    15.0,
    20.0,
    23.976,
    24000.0 / 1001.0,
    24.0,
    25.0,
    30000.0 / 1001.0,
    30.0,
    48.0,
    50.0,
    60000.0 / 1001.0,
    60.0,
    72.0,
    75.0,
    80.0,
    90.0,
    100.0,
    120000.0 / 1001.0,
    120.0,
    144.0,
    180.0,
    200.0,
    240.0,
    250.0,
    480.0,
    1000.0,
];

/// Most that a rate changes when a frame time is read as a well-known one.
const MOST_CHANGE: f64 = 0.025;

/// The frame rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRate {
    /// The rate taken, Hz.
    pub rate_hz: f64,
    /// What the file says, s.
    pub frame_time_s: f64,
    /// Where it comes from; `Guessed` also where the file says just this rate.
    pub chosen: Chosen,
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (rate, written) = (self.rate_hz, 1.0 / self.frame_time_s);
        write!(f, "rate: {} Hz (", short(rate))?;
        if self.chosen == Chosen::Stated {
            return write!(f, "stated; the frame time is {} s, {} Hz)", self.frame_time_s, short(written));
        }
        write!(f, "frame time {} s", self.frame_time_s)?;
        if (rate / written - 1.0).abs() > 1e-9 {
            write!(f, ", {written:.4} Hz, within the rounding of its digits")?;
        }
        write!(f, ")")
    }
}

/// The rate of a file; `stated` wins.
pub(super) fn rate(bvh: &Bvh, stated: Option<f64>) -> FrameRate {
    let chosen = if stated.is_some() { Chosen::Stated } else { Chosen::Guessed };
    let rate_hz = stated.unwrap_or_else(|| read(bvh.frame_time_s, bvh.frame_time_digit_s));
    FrameRate { rate_hz, frame_time_s: bvh.frame_time_s, chosen }
}

/// The rate that a frame time and the weight of its last digit (s) stand for. See the module header.
fn read(time: f64, digit: f64) -> f64 {
    let written = 1.0 / time;
    let plain = |decimals: f64| {
        let near = (written * decimals).round() / decimals;
        Some(near).filter(|near| (near / written - 1.0).abs() < 1e-12)
    };
    if let Some(rate) = plain(1e3) {
        return rate;
    }
    let off = |rate: &f64| (1.0 / rate - time).abs();
    // Of rates that print alike the whole one is the usual one: 0.017 s is 60 Hz, not 59.94.
    let key = |rate: &f64| (rate.fract() != 0.0, off(rate));
    let within = |digits: f64| {
        let fits = |rate: &&f64| {
            off(rate) <= digits * digit * (1.0 + 1e-9) + 1e-12 * time
                && (*rate / written - 1.0).abs() <= MOST_CHANGE
        };
        let better = |a: &&f64, b: &&f64| key(a).0.cmp(&key(b).0).then(key(a).1.total_cmp(&key(b).1));
        RATES.iter().filter(fits).min_by(better)
    };
    // Rounded, else cut: some programs cut.
    let known = within(0.5).or_else(|| within(1.0));
    // A rate of few decimals survives the way through its reciprocal.
    known.copied().or_else(|| plain(1e6)).unwrap_or(written)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> f64 {
        let text = format!(
            "HIERARCHY ROOT hip {{ OFFSET 0 0 0 CHANNELS 1 Xrotation }} MOTION Frames: 1 Frame Time: {text} 10"
        );
        rate(&Bvh::parse(text.as_bytes()).unwrap(), None).rate_hz
    }

    /// Plain reciprocals are meant as they stand, cut and rounded ones are the rates they stand for.
    #[test]
    fn a_frame_time_is_the_rate_it_was_written_for() {
        for (text, hz) in [
            ("1", 1.0),
            ("2", 0.5),
            ("0.2", 5.0),
            ("0.1", 10.0),
            ("0.25", 4.0),
            ("0.04", 25.0),
            ("0.02", 50.0),
            ("0.01", 100.0),
            ("0.008", 125.0),
            ("0.016", 62.5),
            ("0.0083", 120.0),
            ("0.00833", 120.0),
            ("0.008333", 120.0),
            ("0.0083333", 120.0),
            ("0.0166", 60.0),
            ("0.017", 60.0),
            ("0.0167", 60.0),
            ("0.033", 30.0),
            ("0.0333", 30.0),
            ("0.033333", 30.0),
            ("0.0333667", 30000.0 / 1001.0),
            ("0.0334", 30000.0 / 1001.0),
            ("0.0417", 24.0),
            ("0.041708", 24000.0 / 1001.0),
            ("0.042", 24.0),
            ("0.0069", 144.0),
            ("0.004", 250.0),
            ("0.0041667", 240.0),
            ("0.001", 1000.0),
        ] {
            assert_eq!(of(text), hz, "{text}");
        }
    }

    /// From both sides of what rounding explains: one digit, and 2.5 % of the rate.
    #[test]
    fn a_known_rate_is_taken_only_where_rounding_explains_it() {
        assert_eq!(of("0.0082"), 1.0 / 0.0082); // 1/120 is more than a digit away
        assert_eq!(of("0.0084"), 120.0); // within one: rounded up
        assert!((of("0.03") - 33.333).abs() < 1e-3); // within one, but 11 % from 30 Hz
        assert!((of("0.07") - 14.2857).abs() < 1e-3); // 4.8 % from 15 Hz
    }

    /// Every rate that we write comes back, to the bit.
    #[test]
    fn a_rate_written_comes_back() {
        for tenth in 1..=20_000 {
            let hz = f64::from(tenth) / 10.0;
            assert_eq!(of(&format!("{}", 1.0 / hz)), hz);
        }
    }

    /// What the caller says holds, and the words say so.
    #[test]
    fn a_stated_rate_holds() {
        let text =
            b"HIERARCHY ROOT hip { OFFSET 0 0 0 CHANNELS 1 Xrotation } MOTION Frames: 1 Frame Time: 0.008 1";
        let rate = rate(&Bvh::parse(text).unwrap(), Some(60.0));
        assert_eq!(rate.rate_hz, 60.0);
        assert_eq!(rate.to_string(), "rate: 60 Hz (stated; the frame time is 0.008 s, 125 Hz)");
    }
}
