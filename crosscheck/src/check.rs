//! One row of the table: a quantity, our number, MuJoCo's, how far apart, how far allowed.
//!
//! A check is of something: where there is nothing to compare there is no check, and the table says so. Two zeros agree.

use serde::Serialize;

/// What is compared with the threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    /// `rel_error`.
    Relative,
    /// `abs_error`.
    Absolute,
}

/// `part` over `whole`; no part of anything is 0, a part of nothing is infinite.
pub fn ratio(part: f64, whole: f64) -> f64 {
    if part == 0.0 && !whole.is_nan() { 0.0 } else { part / whole }
}

/// A compared quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// What: a short name.
    pub quantity: String,
    /// Our number; of many, where the error is largest.
    pub ours: f64,
    /// MuJoCo's number at the same place.
    pub mujoco: f64,
    /// |ours − mujoco|, or what `quantity` says.
    pub abs_error: f64,
    /// `abs_error` over the scale of the quantity: its largest magnitude in the state, a body weight, …
    pub rel_error: f64,
    /// The largest error allowed.
    pub threshold: f64,
    /// Which of the errors is compared with it.
    pub measure: Measure,
    /// Unit of `ours`, `mujoco` and `abs_error`.
    pub unit: String,
    /// Where the error is largest: a body, a joint, a state, a time.
    pub at: String,
    /// Whether the error is within the threshold.
    pub pass: bool,
    /// Why there is a gap, where one is known.
    pub reason: Option<String>,
}

impl Check {
    /// A check whose relative error counts; `scale` is what 1 is.
    pub fn relative(quantity: &str, unit: &str, ours: f64, mujoco: f64, scale: f64, threshold: f64) -> Self {
        let abs_error = (ours - mujoco).abs();
        let error = ratio(abs_error, scale);
        Self::of(quantity, unit, (ours, mujoco), abs_error, error, threshold, Measure::Relative)
    }

    /// A check whose absolute error counts.
    pub fn absolute(quantity: &str, unit: &str, ours: f64, mujoco: f64, threshold: f64) -> Self {
        let abs_error = (ours - mujoco).abs();
        let error = ratio(abs_error, ours.abs().max(mujoco.abs()));
        Self::of(quantity, unit, (ours, mujoco), abs_error, error, threshold, Measure::Absolute)
    }

    /// Any check; it fails on numbers that are not numbers.
    pub fn of(
        quantity: &str,
        unit: &str,
        (ours, mujoco): (f64, f64),
        abs_error: f64,
        rel_error: f64,
        threshold: f64,
        measure: Measure,
    ) -> Self {
        let error = if measure == Measure::Relative { rel_error } else { abs_error };
        Self {
            quantity: quantity.into(),
            ours,
            mujoco,
            abs_error,
            rel_error,
            threshold,
            measure,
            unit: unit.into(),
            at: String::new(),
            pass: error <= threshold,
            reason: None,
        }
    }

    /// Says where the error is largest.
    pub fn at(mut self, place: impl Into<String>) -> Self {
        self.at = place.into();
        self
    }

    /// Says why there is a gap.
    pub fn because(mut self, reason: impl Into<String>) -> Self {
        self.reason = Some(reason.into());
        self
    }
}

/// The largest relative error of a quantity over many states, and where it was.
#[derive(Clone, Debug, Default)]
pub struct Worst(Option<Seen>);

#[derive(Clone, Debug)]
struct Seen {
    error: f64,
    ours: f64,
    theirs: f64,
    scale: f64,
    at: String,
}

impl Worst {
    /// Takes in vectors of one state, relative to the largest magnitude of `theirs` (at least `floor`: the size of what
    /// the numbers are sums of, so that sums that cancel are not measured by what is left of them).
    pub fn see(&mut self, ours: &[f64], theirs: &[f64], floor: f64, at: impl Fn(usize) -> String) {
        let scale = theirs.iter().fold(floor, |m, x| m.max(x.abs()));
        for (k, (a, b)) in ours.iter().zip(theirs).enumerate() {
            let error = ratio((a - b).abs(), scale);
            let worse = |w: &Seen| error > w.error || error.is_nan();
            if self.0.as_ref().is_none_or(worse) {
                self.0 = Some(Seen { error, ours: *a, theirs: *b, scale, at: at(k) });
            }
        }
    }

    /// The check of it; `None` if nothing was seen.
    pub fn check(self, quantity: &str, unit: &str, threshold: f64) -> Option<Check> {
        let w = self.0?;
        Some(Check::relative(quantity, unit, w.ours, w.theirs, w.scale, threshold).at(w.at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worst(pairs: &[(f64, f64)], floor: f64) -> Option<Check> {
        let mut worst = Worst::default();
        for (k, (a, b)) in pairs.iter().enumerate() {
            worst.see(&[*a], &[*b], floor, |_| format!("state {k}"));
        }
        worst.check("x", "N", 1e-10)
    }

    #[test]
    fn nothing_seen_is_no_check() {
        assert_eq!(worst(&[], 0.0), None);
        let mut empty = Worst::default();
        empty.see(&[], &[], 0.0, |_| String::new());
        assert_eq!(empty.check("x", "N", 1.0), None);
    }

    #[test]
    fn zeros_on_both_sides_agree() {
        let check = worst(&[(0.0, 0.0), (0.0, -0.0)], 0.0).expect("seen");
        assert_eq!((check.pass, check.rel_error, check.at.as_str()), (true, 0.0, "state 0"));
        for check in [Check::relative("x", "", 0.0, 0.0, 0.0, 0.0), Check::absolute("x", "", 0.0, 0.0, 0.0)] {
            assert!(check.pass && check.rel_error == 0.0, "{check:?}");
        }
    }

    #[test]
    fn something_against_nothing_fails() {
        let check = worst(&[(0.0, 0.0), (1e-300, 0.0)], 0.0).expect("seen");
        assert_eq!((check.pass, check.rel_error, check.at.as_str()), (false, f64::INFINITY, "state 1"));
        assert!(!Check::relative("x", "", 1.0, 0.0, 0.0, 0.1).pass);
    }

    #[test]
    fn numbers_that_are_none_fail_and_stay() {
        let check = worst(&[(f64::NAN, 1.0), (1.0, 1.0)], 0.0).expect("seen");
        assert_eq!((check.pass, check.at.as_str()), (false, "state 0"));
        assert!(!Check::relative("x", "", 1.0, f64::NAN, 1.0, 0.1).pass);
        assert!(ratio(0.0, f64::NAN).is_nan());
    }

    #[test]
    fn what_cancels_is_measured_by_what_cancelled() {
        let check = worst(&[(2e-16, 0.0)], 1.0).expect("seen");
        assert!(check.pass && check.rel_error == 2e-16);
    }
}
