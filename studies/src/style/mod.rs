//! Style transfers measured: does the style come, does the content stay.
//!
//! In: two takes, and which measures name the style. Out: an [`Outcome`]: how much of the gap to the donor every style measure
//! has closed at each amount, and what the base has kept.
//!
//! The six pairs of SCF06 on the nearest clips are in [`pairs`], with their measures.

pub mod measures;
pub mod pairs;

use std::collections::BTreeMap;
use std::sync::Arc;

use motion::metrics::jerk_rms;
use takes::Take;
use takes::styles::style::{StyleSet, Transfer};
use takes::styles::{Find, StylesError, styled};

use measures::{Content, Measure};

/// Amounts at which style measures are taken.
pub const AMOUNTS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Share of the gap to the donor that is asked for at amount 1.
pub const ASKED: f64 = 0.5;

/// A style measure over amounts.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// Which.
    pub measure: Measure,
    /// Of the base and the donor.
    pub ends: [f64; 2],
    /// At each of [`AMOUNTS`].
    pub values: Vec<f64>,
}

impl Moved {
    /// Share of the gap that is closed at amount 1; zero where base and donor do not differ.
    pub fn share(&self) -> f64 {
        let gap = self.ends[1] - self.ends[0];
        if gap == 0.0 { 0.0 } else { (self.values[AMOUNTS.len() - 1] - self.ends[0]) / gap }
    }

    /// Whether it goes one way as the amount grows.
    pub fn is_monotone(&self) -> bool {
        let way = (self.ends[1] - self.ends[0]).signum();
        self.values.windows(2).all(|w| (w[1] - w[0]) * way > 0.0)
    }

    /// Whether it goes as far as asked, and one way.
    pub fn comes(&self) -> bool {
        self.share() >= ASKED && self.is_monotone()
    }
}

/// What a transfer did.
pub struct Outcome {
    /// The base at amount 1.
    pub take: Take,
    /// The components.
    pub set: Arc<StyleSet>,
    /// Numbers of the components that were transferred, from 1.
    pub components: Vec<usize>,
    /// The style.
    pub moved: Vec<Moved>,
    /// Content of the base, and at amount 1.
    pub content: [Content; 2],
    /// Correlation of both thighs' angles with the base's, the lower of the two.
    pub thighs: f64,
    /// Jerk at amount 1 over that of the base.
    pub jerk: f64,
    /// Largest change of a bone's length, m.
    pub bones_m: f64,
    /// What was said.
    pub log: String,
}

impl Outcome {
    /// Whether the content stays: step length, cadence and path within 15 %, thighs correlated by 0.9, slip at most 2 mm more,
    /// jerk at most 1.2 times, bones exact. What does not, by name.
    pub fn lost(&self) -> Vec<String> {
        let [before, after] = &self.content;
        let ratio = |name: &str, a: f64, b: f64| {
            ((b / a - 1.0).abs() > 0.15).then(|| format!("{name} {:+.0} %", 100.0 * (b / a - 1.0)))
        };
        let mut lost: Vec<String> = [
            ratio("step length", before.step_m, after.step_m),
            ratio("cadence", before.cadence_hz, after.cadence_hz),
            ratio("path", before.path_m, after.path_m),
        ]
        .into_iter()
        .flatten()
        .collect();
        if self.thighs < 0.9 {
            lost.push(format!("thighs correlate by {:.2}", self.thighs));
        }
        if after.slip_mm > before.slip_mm + 2.0 {
            lost.push(format!("slip {:.1} mm after {:.1} mm", after.slip_mm, before.slip_mm));
        }
        if self.jerk > 1.2 {
            lost.push(format!("jerk {:.2} times", self.jerk));
        }
        if self.bones_m > 1e-9 {
            lost.push(format!("bones by {:.1e} m", self.bones_m));
        }
        lost
    }
}

/// Puts the style of one take into another, and measures. `components`: numbers from 1 of those that are transferred; none: those that
/// tell the takes apart.
///
/// # Errors
/// As [`styled`]; numbers of components that there are not.
pub fn measure(
    base: &Take,
    donor: &Take,
    of: &[Measure],
    find: &Find,
    components: &[usize],
) -> Result<Outcome, StylesError> {
    let set = Arc::new(find.set(base, donor, false)?);
    let put = match components {
        [] => set.clear(),
        numbers => set.numbered(numbers)?,
    };
    let none = BTreeMap::new();
    let takes = AMOUNTS
        .iter()
        .map(|a| styled(base, &set, &Transfer::of(&set, 1, *a).only(&put, *a), &none))
        .collect::<Result<Vec<_>, _>>()?;
    let moved = of
        .iter()
        .map(|m| Moved {
            measure: *m,
            ends: [m.of(base), m.of(donor)],
            values: takes.iter().map(|take| m.of(take)).collect(),
        })
        .collect();
    let last = takes.last().expect("amounts").clone();
    let thighs = measures::thigh_angles(&base.asked.clip)
        .iter()
        .zip(measures::thigh_angles(&last.asked.clip))
        .map(|(a, b)| measures::correlation(a, &b))
        .fold(1.0, f64::min);
    Ok(Outcome {
        components: put.iter().map(|c| c + 1).collect(),
        moved,
        content: [Content::of(base, base), Content::of(&last, base)],
        thighs,
        jerk: jerk_rms(&last.asked.clip) / jerk_rms(&base.asked.clip),
        bones_m: measures::bones(&base.asked.clip, &last.asked.clip),
        log: last.log.to_string(),
        take: last,
        set,
    })
}

/// A row of the table of transfers, and its heading.
pub const HEADING: &str = "| base ← style of | components | style measures: base → amount 1 (donor); share of the gap | thighs | step, cadence, path | slip mm | jerk | not kept |\n|---|---|---|---|---|---|---|---|\n";

impl Outcome {
    /// As a row under [`HEADING`].
    pub fn row(&self, base: &str, donor: &str) -> String {
        let style: Vec<String> = self
            .moved
            .iter()
            .map(|m| {
                let way = if m.comes() {
                    ""
                } else if m.is_monotone() {
                    ", too little"
                } else {
                    ", not one way"
                };
                let (first, last) = (m.ends[0], m.values[AMOUNTS.len() - 1]);
                format!(
                    "{} {first:.1} → {last:.1} ({:.1}); {:.0} %{way}",
                    m.measure.word(),
                    m.ends[1],
                    100.0 * m.share()
                )
            })
            .collect();
        let [a, b] = &self.content;
        let percent = |x: f64, y: f64| format!("{:+.0} %", 100.0 * (y / x - 1.0));
        let numbers: Vec<String> = self.components.iter().map(ToString::to_string).collect();
        let lost = self.lost();
        format!(
            "| {base} ← {donor} | {} of {} | {} | {:.2} | {}, {}, {} | {:.1} → {:.1} | {:.2} | {} |\n",
            numbers.join(", "),
            self.set.components(),
            style.join("<br>"),
            self.thighs,
            percent(a.step_m, b.step_m),
            percent(a.cadence_hz, b.cadence_hz),
            percent(a.path_m, b.path_m),
            a.slip_mm,
            b.slip_mm,
            self.jerk,
            if lost.is_empty() { "–".into() } else { lost.join(", ") }
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between a base and a donor that are alike there is no gap to close.
    #[test]
    fn no_share_of_no_gap_is_closed() {
        let moved = |ends| Moved { measure: Measure::TrunkPitch, ends, values: vec![1.0; AMOUNTS.len()] };
        assert_eq!(moved([1.0, 1.0]).share(), 0.0);
        assert_eq!(moved([0.0, 2.0]).share(), 0.5);
    }
}
