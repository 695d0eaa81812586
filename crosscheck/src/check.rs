//! One row of the table: a quantity, our number, MuJoCo's, how far apart, how far allowed.

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
        Self::of(quantity, unit, (ours, mujoco), abs_error, abs_error / scale, threshold, Measure::Relative)
    }

    /// A check whose absolute error counts.
    pub fn absolute(quantity: &str, unit: &str, ours: f64, mujoco: f64, threshold: f64) -> Self {
        let abs_error = (ours - mujoco).abs();
        let scale = ours.abs().max(mujoco.abs()).max(f64::MIN_POSITIVE);
        Self::of(quantity, unit, (ours, mujoco), abs_error, abs_error / scale, threshold, Measure::Absolute)
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
#[derive(Clone, Debug)]
pub struct Worst {
    error: f64,
    ours: f64,
    theirs: f64,
    scale: f64,
    at: String,
}

impl Worst {
    /// Nothing seen.
    pub fn new() -> Self {
        Self { error: -1.0, ours: 0.0, theirs: 0.0, scale: 1.0, at: String::new() }
    }

    /// Takes in vectors of one state, relative to the largest magnitude of `theirs` (at least `floor`).
    pub fn see(&mut self, ours: &[f64], theirs: &[f64], floor: f64, at: impl Fn(usize) -> String) {
        let scale = theirs.iter().fold(floor, |m, x| m.max(x.abs()));
        for (k, (a, b)) in ours.iter().zip(theirs).enumerate() {
            let error = (a - b).abs() / scale;
            if error > self.error || error.is_nan() {
                *self = Self { error, ours: *a, theirs: *b, scale, at: at(k) };
            }
        }
    }

    /// The check of it.
    pub fn check(self, quantity: &str, unit: &str, threshold: f64) -> Check {
        Check::relative(quantity, unit, self.ours, self.theirs, self.scale, threshold).at(self.at)
    }
}

impl Default for Worst {
    fn default() -> Self {
        Self::new()
    }
}
