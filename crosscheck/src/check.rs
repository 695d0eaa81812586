//! One row of the table: a quantity, our number, MuJoCo's, how far apart, how far allowed.
//!
//! Where engines are compared there are three numbers, of the core, of rapier (`ours`) and of MuJoCo, and three pairs: the row passes where
//! no pair is farther apart than allowed, and names those that are.
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
    /// Our number, rapier's where engines are compared; of many, where the error is largest.
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
    /// The core's number at the same place and its errors, where engines are compared.
    pub core: Option<CoreSeen>,
    /// Whether the errors of all pairs are within the threshold.
    pub pass: bool,
    /// Why there is a gap, where one is known.
    pub reason: Option<String>,
}

/// The core in a check. Errors are of the measure that the check compares with its threshold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CoreSeen {
    /// Its number.
    pub value: f64,
    /// How far it is from rapier.
    pub to_rapier: f64,
    /// How far it is from MuJoCo.
    pub to_mujoco: f64,
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
            core: None,
            pass: error <= threshold,
            reason: None,
        }
    }

    /// Adds the core's number; its errors are differences of numbers over `scale`, of which 1 is the unit of an absolute error.
    pub fn with_core(self, value: f64, scale: f64) -> Self {
        let to = |other: f64| ratio((value - other).abs(), scale);
        let (to_rapier, to_mujoco) = (to(self.ours), to(self.mujoco));
        self.with_core_errors(CoreSeen { value, to_rapier, to_mujoco })
    }

    /// Adds the core's number, which like the others is held against what is expected of all, not against theirs; `off` is how far it is
    /// from that.
    pub fn with_core_off(self, value: f64, off: f64) -> Self {
        self.with_core_errors(CoreSeen { value, to_rapier: off, to_mujoco: off })
    }

    /// Adds the core's number with its errors.
    pub fn with_core_errors(mut self, core: CoreSeen) -> Self {
        self.core = Some(core);
        self.pass = self.pairs().iter().all(|(_, error)| *error <= self.threshold);
        self
    }

    /// The error that is compared with the threshold, of rapier (or our equations) and MuJoCo.
    pub fn error(&self) -> f64 {
        if self.measure == Measure::Relative { self.rel_error } else { self.abs_error }
    }

    /// All pairs that are compared, with their errors.
    pub fn pairs(&self) -> Vec<(&'static str, f64)> {
        match &self.core {
            None => vec![("ours, MuJoCo", self.error())],
            Some(c) => vec![
                ("rapier, MuJoCo", self.error()),
                ("core, MuJoCo", c.to_mujoco),
                ("core, rapier", c.to_rapier),
            ],
        }
    }

    /// The pair that is farthest apart, and its error; a number that is none is farther than any.
    pub fn farthest(&self) -> (&'static str, f64) {
        let size = |e: f64| if e.is_nan() { f64::INFINITY } else { e };
        let pairs = self.pairs();
        let mut farthest = pairs[0];
        for pair in &pairs[1..] {
            if size(pair.1) > size(farthest.1) {
                farthest = *pair;
            }
        }
        farthest
    }

    /// The pairs that are farther apart than allowed.
    pub fn differ(&self) -> Vec<&'static str> {
        self.pairs().into_iter().filter(|(_, e)| e.is_nan() || *e > self.threshold).map(|p| p.0).collect()
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
    fn of_three_engines_the_pairs_that_differ_are_named() {
        let check = |core: f64| Check::absolute("x", "N", 1.0, 1.1, 0.2).with_core(core, 1.0);
        assert!(check(1.05).pass && check(1.05).differ().is_empty());
        assert_eq!(check(1.05).farthest().0, "rapier, MuJoCo");
        let off = check(1.25);
        assert_eq!((off.pass, off.differ(), off.farthest().0), (false, vec!["core, rapier"], "core, rapier"));
        let far = check(5.0);
        assert_eq!((far.pass, far.differ()), (false, vec!["core, MuJoCo", "core, rapier"]));
        let none = check(f64::NAN);
        assert_eq!(
            (none.pass, none.differ(), none.farthest().0),
            (false, vec!["core, MuJoCo", "core, rapier"], "core, MuJoCo")
        );
        // a check that fails without the core is not mended by it
        assert!(!Check::absolute("x", "N", 1.0, 2.0, 0.2).with_core(1.5, 1.0).pass);
        assert_eq!(Check::absolute("x", "N", 1.0, 2.0, 0.2).pairs(), [("ours, MuJoCo", 1.0)]);
    }

    #[test]
    fn what_cancels_is_measured_by_what_cancelled() {
        let check = worst(&[(2e-16, 0.0)], 1.0).expect("seen");
        assert!(check.pass && check.rel_error == 2e-16);
    }
}
