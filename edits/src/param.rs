//! Parameters of edits: constants, curves over time or repetition, lists over poses.
//!
//! A curve is piecewise linear through its knots `(x, value)` and holds its end values outside; `x`
//! is the start time of an element in seconds, or the number of the repetition, counted from 0. So a
//! dance is built up to a crescendo with one edit. A list gives one value for each pose selected, in order
//! of time, repetitions counted once.

use motion::{Element, Label};

use crate::EditError;

/// A parameter of an edit. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameter {
    /// One value everywhere.
    Constant(f64),
    /// Knots `(time in s, value)`, read where the element starts.
    OverTime(Vec<(f64, f64)>),
    /// Knots `(repetition, value)`, read at the repetition of the element; 0 for what is not repeated.
    OverRepetition(Vec<(f64, f64)>),
    /// One value for each pose selected.
    PerPose(Vec<f64>),
}

impl From<f64> for Parameter {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

/// Where a parameter is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// Time, s.
    pub time_s: f64,
    /// Number of the repetition.
    pub repetition: usize,
    /// Ordinal of the pose in the selection.
    pub pose: usize,
}

impl Parameter {
    /// Value at an instant; piecewise linear, ends hold.
    pub fn at(&self, instant: &Instant) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::OverTime(knots) => interpolate(knots, instant.time_s),
            Self::OverRepetition(knots) => interpolate(knots, instant.repetition as f64),
            Self::PerPose(values) => values.get(instant.pose).copied().unwrap_or(f64::NAN),
        }
    }

    /// Refuses what counts poses or repetitions, which a fitted clip does not have.
    ///
    /// # Errors
    /// [`EditError::NoPoses`].
    pub fn of_time(&self, edit: &'static str, what: &'static str) -> Result<(), EditError> {
        match self {
            Self::Constant(_) | Self::OverTime(_) => Ok(()),
            Self::PerPose(_) | Self::OverRepetition(_) => Err(EditError::NoPoses { edit, what }),
        }
    }

    /// Checks the shape, and every value with `good`.
    ///
    /// # Errors
    /// Bad knots, a list that does not have `poses` values, a value that is not good.
    pub fn check(
        &self,
        edit: &'static str,
        what: &'static str,
        poses: usize,
        allowed: &'static str,
        good: impl Fn(f64) -> bool,
    ) -> Result<(), EditError> {
        let value = |value: f64, at: String| {
            if value.is_finite() && good(value) {
                return Ok(());
            }
            Err(EditError::Parameter { edit, what, value, at, allowed })
        };
        let along = |knots: &[(f64, f64)], unit: &str| {
            if knots.is_empty() {
                return Err(EditError::Knots(0));
            }
            for (i, &(x, y)) in knots.iter().enumerate() {
                if !x.is_finite() || (i > 0 && knots[i - 1].0 >= x) {
                    return Err(EditError::Knots(i));
                }
                value(y, format!(" at {unit} {x}"))?;
            }
            Ok(())
        };
        match self {
            Self::Constant(v) => value(*v, String::new()),
            Self::OverTime(knots) => along(knots, "time"),
            Self::OverRepetition(knots) => along(knots, "repetition"),
            Self::PerPose(values) if values.len() != poses => {
                Err(EditError::PerPose { edit, given: values.len(), needed: poses })
            }
            Self::PerPose(values) => {
                values.iter().enumerate().try_for_each(|(i, v)| value(*v, format!(" for pose {i}")))
            }
        }
    }
}

fn interpolate(knots: &[(f64, f64)], x: f64) -> f64 {
    let after = knots.partition_point(|k| k.0 <= x);
    match (after.checked_sub(1).map(|i| knots[i]), knots.get(after)) {
        (Some((_, y)), None) => y,
        (None, Some(&(_, y))) => y,
        (Some((x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * ((x - x0) / (x1 - x0)),
        (None, None) => f64::NAN,
    }
}

/// The order of the poses of a selection, in which [`Parameter::PerPose`] counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseOrder(Vec<Label>);

impl PoseOrder {
    /// Orders the poses of `elements` by the time they first start; repetitions count once.
    pub fn new<'a>(elements: impl IntoIterator<Item = &'a Element>) -> Self {
        let mut all: Vec<&Element> = elements.into_iter().collect();
        all.sort_by(|a, b| a.start_s.total_cmp(&b.start_s).then_with(|| a.label.cmp(&b.label)));
        let mut order: Vec<Label> = Vec::new();
        for e in all {
            if !order.iter().any(|l| same_place(l, &e.label)) {
                order.push(e.label.clone());
            }
        }
        Self(order)
    }

    /// Number of poses.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is no pose.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Where to read a parameter for an element that starts at `time_s`.
    pub fn instant(&self, label: &Label, time_s: f64) -> Instant {
        let pose = self.0.iter().position(|l| same_place(l, label)).unwrap_or(usize::MAX);
        Instant { time_s, repetition: label.round(), pose }
    }
}

fn same_place(a: &Label, b: &Label) -> bool {
    a.action == b.action && (a.cycle, a.pose) == (b.cycle, b.pose)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time_s: f64, repetition: usize) -> Instant {
        Instant { time_s, repetition, pose: 0 }
    }

    #[test]
    fn curves_run_through_their_knots_and_hold_their_ends() {
        let p = Parameter::OverTime(vec![(1.0, 2.0), (3.0, 6.0)]);
        for (t, y) in [(0.0, 2.0), (1.0, 2.0), (1.5, 3.0), (3.0, 6.0), (9.0, 6.0)] {
            assert_eq!(p.at(&at(t, 0)), y);
        }
        let p = Parameter::OverRepetition(vec![(0.0, 1.0), (4.0, 3.0)]);
        assert_eq!(p.at(&at(99.0, 1)), 1.5);
    }

    #[test]
    fn bad_parameters_are_named() {
        let words =
            |p: Parameter| p.check("amplitude", "factor", 2, "above 0", |x| x > 0.0).unwrap_err().to_string();
        assert_eq!(words(Parameter::Constant(-1.0)), "amplitude: factor is -1; allowed: above 0");
        assert_eq!(
            words(Parameter::OverTime(vec![(0.0, 1.0), (2.0, 0.0)])),
            "amplitude: factor is 0 at time 2; allowed: above 0"
        );
        assert!(words(Parameter::OverTime(vec![])).contains("knot 0"));
        assert!(words(Parameter::OverRepetition(vec![(1.0, 1.0), (1.0, 2.0)])).contains("knot 1"));
        assert!(words(Parameter::PerPose(vec![1.0])).contains("1 values for 2 poses"));
        assert!(words(Parameter::Constant(f64::NAN)).contains("NaN"));
    }
}
