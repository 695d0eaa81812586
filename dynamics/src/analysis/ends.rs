//! The ends of a clip: how uncertain the forces are there, and which frames are graded.
//!
//! In: the path of the centre of mass as it was given, the smoother's cut-off. Out: [`Ends`].
//!
//! A clip that was cut out of a motion has no neighbours beyond its first and last frame. The smoother leaves its ends free
//! (zero third differences), which is wrong wherever the motion goes on, and its noise is 2.4 times that of the middle. So the
//! uncertainty is *measured* on the clip itself: it is cut at eight places inside, the pieces are smoothed alike, and
//! their accelerations are compared with those of the whole, in the frame of the cut and [`END_S`] inside.
//! The first and last [`END_S`] are left out of peaks, grades and violations; a clip that is shorter than
//! [`LEAST_GRADED_S`] without them is too short to be graded.

use std::ops::Range;

use motion::Vec3;
use motion::skeleton::vec_at;
use motion::smooth::whittaker::{Whittaker, lambda};

/// What is left out of the grade at each end of a smoothed clip, s.
pub const END_S: f64 = 0.05;
/// Shortest stretch between the ends that is graded, s.
pub const LEAST_GRADED_S: f64 = 0.1;
/// Places at which a clip is cut to measure its ends.
const CUTS: usize = 8;
/// Frames of the smallest piece of such a cut.
const PIECE: usize = 16;

/// The ends of a clip.
#[derive(Clone, Debug, PartialEq)]
pub struct Ends {
    /// Frames that are graded: all of a clip that was not smoothed; never empty.
    pub graded: Range<usize>,
    /// Whether too little is left between the ends for a grade to mean anything; then all frames are in `graded`.
    pub too_short: bool,
    /// RMS error of the required force in the first and last frame, N; `None` where the clip cannot be cut.
    pub first_n: Option<f64>,
    /// The same [`END_S`] inside, N.
    pub inside_n: Option<f64>,
}

impl Ends {
    /// Of a clip of `com` (`frames × 3`, m) of a body of `mass`, smoothed at `cutoff_hz` (infinite: not at all).
    pub fn of(com: &[f64], rate_hz: f64, cutoff_hz: f64, mass: f64) -> Self {
        let frames = com.len() / 3;
        if !cutoff_hz.is_finite() || cutoff_hz >= 0.5 * rate_hz {
            return Self { graded: 0..frames, too_short: false, first_n: None, inside_n: None };
        }
        let end = (END_S * rate_hz).round() as usize;
        let least = (LEAST_GRADED_S * rate_hz).round().max(1.0) as usize;
        let too_short = frames < 2 * end + least;
        let graded = if too_short { 0..frames } else { end..frames - end };
        let errors = cut_errors(com, rate_hz, cutoff_hz, end);
        let rms = |x: &[f64]| {
            let mean = x.iter().map(|e| e * e).sum::<f64>() / x.len() as f64;
            (!x.is_empty()).then(|| mass * mean.sqrt())
        };
        Self { graded, too_short, first_n: rms(&errors[0]), inside_n: rms(&errors[1]) }
    }
}

/// Errors of the acceleration at cuts, in the frame of the cut and `end` frames inside, m/s².
fn cut_errors(com: &[f64], rate_hz: f64, cutoff_hz: f64, end: usize) -> [Vec<f64>; 2] {
    let frames = com.len() / 3;
    let accelerations = |path: &[f64]| {
        let n = path.len() / 3;
        let smooth = Whittaker::new(n, lambda(cutoff_hz, rate_hz)).smooth(path, 3);
        let at = |k: usize| vec_at(&smooth, 3 * k);
        let bend = |k: usize| {
            let k = k.clamp(1, n - 2); // one-sided at the ends, as `Derivatives::central` has it
            (at(k + 1) - at(k) * 2.0 + at(k - 1)) * (rate_hz * rate_hz)
        };
        (0..n).map(bend).collect::<Vec<Vec3>>()
    };
    let mut errors = [Vec::new(), Vec::new()];
    if frames < 2 * PIECE + 2 * end {
        return errors;
    }
    let whole = accelerations(com);
    for cut in 1..=CUTS {
        let at = PIECE + end + cut * (frames - 2 * (PIECE + end)) / (CUTS + 1);
        let (before, after) = (accelerations(&com[..3 * at]), accelerations(&com[3 * at..]));
        for (which, inside) in [0, end].into_iter().enumerate() {
            errors[which].push((before[at - 1 - inside] - whole[at - 1 - inside]).norm());
            errors[which].push((after[inside] - whole[at + inside]).norm());
        }
    }
    errors
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(frames: usize, rate: f64) -> Vec<f64> {
        (0..frames).flat_map(|k| [0.0, 0.02 * (12.0 * k as f64 / rate).sin(), k as f64 / rate]).collect()
    }

    /// The error that a cut makes is largest at the cut; cutting a parabola makes none.
    #[test]
    fn a_cut_is_worst_at_its_end() {
        let ends = Ends::of(&path(300, 100.0), 100.0, 6.0, 70.0);
        let (first, inside) = (ends.first_n.unwrap(), ends.inside_n.unwrap());
        assert!(first > 30.0 && inside < 0.6 * first, "{first} {inside}"); // 202 N is the force itself
        let parabola: Vec<f64> = (0..300).flat_map(|k| [0.0, 4.9e-4 * f64::from(k * k), 0.0]).collect();
        let ends = Ends::of(&parabola, 100.0, 6.0, 70.0);
        assert!(ends.first_n.unwrap() < 1e-4, "{ends:?}");
        assert_eq!(ends.graded, 5..295);
    }

    /// From both sides of the shortest clip that is graded; a clip that was not smoothed is graded whole.
    #[test]
    fn short_clips_are_too_short() {
        let of = |frames: usize| Ends::of(&path(frames, 120.0), 120.0, 6.0, 70.0);
        assert!(of(23).too_short && !of(24).too_short);
        assert_eq!((of(23).graded, of(24).graded), (0..23, 6..18));
        let whole = Ends::of(&path(10, 120.0), 120.0, f64::INFINITY, 70.0);
        assert_eq!((whole.graded, whole.too_short), (0..10, false));
    }
}
