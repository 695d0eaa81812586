//! Scripts: motion as an animator writes it, action > cycle > pose > value (NF03 §4.1).
//!
//! In: actions that start when they say, their cycles (with repetitions) and poses one after another,
//! and elements inserted directly. Out: [`Tracks`], checked. A pose may set any subset of the degrees of
//! freedom and runs them in parallel; it lasts as long as the longest of them, duration and hold.
//!
//! Curve, tension, duration and hold may be set at every level; they flow down and the innermost
//! setting wins. What no level sets is [`Properties::DEFAULT`].
//!
//! Several actions may be active at once. On the same degree of freedom the later start supersedes
//! (of equal starts: the later in the script); [`Tracks::overlaps`] lists where.
//!
//! Units: s, rad, m; DOFs by name ([`Dof::find`]). No file format: scenes map theirs onto these.

use std::collections::BTreeSet;
use std::sync::Arc;

use thiserror::Error;

use crate::curve::Curve;
use crate::dof::{Dof, Value};
use crate::names::hint;
use crate::track::{Element, Label, Tracks};
use crate::{Joint, Quat, Skeleton, Timing};

/// Most repetitions of one cycle.
pub const MAX_REPETITIONS: usize = 10_000;
/// Most elements of one script.
pub const MAX_ELEMENTS: usize = 1_000_000;
/// Longest motion, s: a day.
pub const MAX_TIME_S: f64 = 86_400.0;

/// What flows down the hierarchy; `None` inherits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Properties {
    /// Shape of the transition.
    pub curve: Option<Curve>,
    /// Dimensionless tension, > 0; 1 is relaxed and natural.
    pub tension: Option<f64>,
    /// Length of the transition, s.
    pub duration_s: Option<f64>,
    /// How long the end is held, s.
    pub hold_s: Option<f64>,
    /// What muscles know of the motion.
    pub timing: Option<Timing>,
}

impl Properties {
    /// What holds where nothing is set: least-jerk curve, natural tension, half a second, no hold, loose timing.
    pub const DEFAULT: Self = Self {
        curve: Some(Curve::EaseInOut),
        tension: Some(1.0),
        duration_s: Some(0.5),
        hold_s: Some(0.0),
        timing: Some(Timing::Loose),
    };

    /// These settings, and those of `outer` where these are silent.
    pub fn within(&self, outer: &Self) -> Self {
        Self {
            curve: self.curve.or(outer.curve),
            tension: self.tension.or(outer.tension),
            duration_s: self.duration_s.or(outer.duration_s),
            hold_s: self.hold_s.or(outer.hold_s),
            timing: self.timing.or(outer.timing),
        }
    }
}

/// A value a pose sets.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseValue {
    /// Name of the DOF.
    pub dof: String,
    /// Where it goes.
    pub value: Value,
    /// Own properties.
    pub properties: Properties,
}

impl PoseValue {
    /// A hinge angle (rad), slide or root coordinate (m).
    pub fn scalar(dof: impl Into<String>, value: f64) -> Self {
        Self { dof: dof.into(), value: Value::Scalar(value), properties: Properties::default() }
    }

    /// A rotation of a ball joint or free root.
    pub fn rotation(dof: impl Into<String>, value: Quat) -> Self {
        Self { dof: dof.into(), value: Value::Rotation(value), properties: Properties::default() }
    }
}

/// Values reached together. Without values it is a pause of its duration and hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// Properties of the pose.
    pub properties: Properties,
    /// Any subset of the DOFs, each at most once.
    pub values: Vec<PoseValue>,
}

/// Poses one after another, the whole repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// How often it runs, 1 to [`MAX_REPETITIONS`].
    pub repetitions: usize,
    /// Properties of the cycle.
    pub properties: Properties,
    /// In order.
    pub poses: Vec<Pose>,
}

impl Default for Cycle {
    fn default() -> Self {
        Self { repetitions: 1, properties: Properties::default(), poses: Vec::new() }
    }
}

/// A unit of movement: cycles one after another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Action {
    /// Unique name.
    pub name: String,
    /// When it starts, s.
    pub start_s: f64,
    /// Properties of the action.
    pub properties: Properties,
    /// In order.
    pub cycles: Vec<Cycle>,
}

/// An element put straight into a track. Its label reads as an action of this name with one cycle of
/// one pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Insert {
    /// Name; several inserts may share one if they move different DOFs.
    pub name: String,
    /// When it starts, s.
    pub start_s: f64,
    /// DOF, value and properties.
    pub value: PoseValue,
}

/// A motion as it is written. See the module header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    /// Properties of everything below.
    pub properties: Properties,
    /// Actions; their start times are absolute.
    pub actions: Vec<Action>,
    /// Elements put straight into tracks, after the actions.
    pub inserts: Vec<Insert>,
}

/// What is wrong with a script. `place` reads like `Pose 1 of cycle 0 of action "wave"`.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ScriptError {
    /// A base pose of the wrong length.
    #[error("the base pose has {found} numbers, the skeleton needs {needed}")]
    Base {
        /// Length found.
        found: usize,
        /// Length needed.
        needed: usize,
    },
    /// A name that is no DOF.
    #[error("unknown joint `{name}` in {place}{hint}")]
    UnknownDof {
        /// As written.
        name: String,
        /// Where.
        place: String,
        /// The nearest name, or all.
        hint: String,
    },
    /// A welded joint.
    #[error("`{name}` in {place} is welded to its parent and cannot move")]
    Welded {
        /// The link.
        name: String,
        /// Where.
        place: String,
    },
    /// A rotation for a scalar DOF, or the reverse.
    #[error("`{name}` in {place} takes {expected}, found {found}")]
    Kind {
        /// The DOF.
        name: String,
        /// Where.
        place: String,
        /// What it takes.
        expected: &'static str,
        /// What was given.
        found: &'static str,
    },
    /// A number out of its range.
    #[error("{what} is {value} in {place}; allowed: {allowed}")]
    Range {
        /// Which number.
        what: String,
        /// As found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
        /// Where.
        place: String,
    },
    /// A DOF set twice in one pose.
    #[error("`{name}` is set twice in {place}")]
    Twice {
        /// The DOF.
        name: String,
        /// Where.
        place: String,
    },
    /// Two actions of one name, or an insert with an action's name.
    #[error("the action name `{0}` is used twice; names must be unique, or labels would be ambiguous")]
    DuplicateAction(String),
    /// An action without a name.
    #[error("an action needs a name")]
    Unnamed,
    /// More than is reasonable.
    #[error("{what}: {found} in {place}; allowed: 1 to {most}")]
    Count {
        /// What was counted.
        what: &'static str,
        /// As found.
        found: usize,
        /// The most allowed.
        most: usize,
        /// Where.
        place: String,
    },
}

/// Properties with nothing left to inherit.
struct Settled {
    curve: Curve,
    tension: f64,
    duration_s: f64,
    hold_s: f64,
    timing: Timing,
}

impl Properties {
    fn settle(&self, place: &dyn Fn() -> String) -> Result<Settled, ScriptError> {
        let all = self.within(&Self::DEFAULT);
        let settled = Settled {
            curve: all.curve.unwrap_or_default(),
            tension: all.tension.unwrap_or(1.0),
            duration_s: all.duration_s.unwrap_or(0.0),
            hold_s: all.hold_s.unwrap_or(0.0),
            timing: all.timing.unwrap_or_default(),
        };
        let range = |what: &str, value, allowed| {
            Err(ScriptError::Range { what: what.into(), value, allowed, place: place() })
        };
        if !(0.0..=MAX_TIME_S).contains(&settled.duration_s) {
            return range("duration_s", settled.duration_s, "0 to 86400 s");
        }
        if !(0.0..=MAX_TIME_S).contains(&settled.hold_s) {
            return range("hold_s", settled.hold_s, "0 to 86400 s");
        }
        if !(settled.tension > 0.0 && settled.tension.is_finite()) {
            return range("tension", settled.tension, "above 0, finite");
        }
        if let Curve::Bezier(x1, y1, x2, y2) = settled.curve
            && !settled.curve.is_valid()
        {
            let bad = |x: &f64| !(0.0..=1.0).contains(x);
            let value = [x1, x2].into_iter().find(bad).unwrap_or(if y1.is_finite() { y2 } else { y1 });
            return range("a Bezier handle", value, "x from 0 to 1, y finite");
        }
        Ok(settled)
    }
}

/// What `build` knows while it walks down the script.
struct Builder<'a> {
    skeleton: &'a Skeleton,
    dofs: Vec<Dof>,
    tracks: Tracks,
    count: usize,
}

impl Builder<'_> {
    /// Checks the DOF and value of `v` and returns its index in the list of DOFs.
    fn check(&self, v: &PoseValue, place: &dyn Fn() -> String) -> Result<usize, ScriptError> {
        let Some(dof) = Dof::find(self.skeleton, &v.dof) else {
            if self.skeleton.link(&v.dof).is_some_and(|i| self.skeleton.links()[i].joint == Joint::Fixed) {
                return Err(ScriptError::Welded { name: v.dof.clone(), place: place() });
            }
            let names: Vec<String> = self.dofs.iter().map(|d| d.name(self.skeleton)).collect();
            let hint = hint(&v.dof, names.iter().map(String::as_str));
            return Err(ScriptError::UnknownDof { name: v.dof.clone(), place: place(), hint });
        };
        let words = |rotation| if rotation { "a rotation" } else { "one number" };
        let given = matches!(v.value, Value::Rotation(_));
        if dof.is_rotation() != given {
            return Err(ScriptError::Kind {
                name: v.dof.clone(),
                place: place(),
                expected: words(dof.is_rotation()),
                found: words(given),
            });
        }
        if !v.value.is_valid() {
            let (value, allowed) = match v.value {
                Value::Scalar(x) => (x, "a finite number"),
                Value::Rotation(r) => (r.coords.norm(), "a quaternion of length 1"),
            };
            let what = format!("the value of `{}`", v.dof);
            return Err(ScriptError::Range { what, value, allowed, place: place() });
        }
        // `find` only returns DOFs of the list
        Ok(self.dofs.iter().position(|d| *d == dof).unwrap_or_default())
    }

    fn push(
        &mut self,
        label: Label,
        start_s: f64,
        value: Value,
        settled: &Settled,
        place: &dyn Fn() -> String,
    ) -> Result<(), ScriptError> {
        self.count += 1;
        if self.count > MAX_ELEMENTS {
            let (what, found) = ("elements", self.count);
            return Err(ScriptError::Count { what, found, most: MAX_ELEMENTS, place: place() });
        }
        let dof = self.dofs[label.dof];
        let element = Element {
            label,
            start_s,
            duration_s: settled.duration_s,
            hold_s: settled.hold_s,
            end: value,
            curve: settled.curve,
            tension: settled.tension,
            timing: settled.timing,
        };
        if let Some(track) = self.tracks.track_mut(dof) {
            track.insert(element);
        }
        Ok(())
    }

    fn action(&mut self, action: &Action, outer: &Properties) -> Result<(), ScriptError> {
        let name: Arc<str> = action.name.as_str().into();
        check_start(action.start_s, &|| format!("action \"{name}\""))?;
        let of_action = action.properties.within(outer);
        let mut t = action.start_s;
        for (c, cycle) in action.cycles.iter().enumerate() {
            if cycle.repetitions == 0 || cycle.repetitions > MAX_REPETITIONS {
                return Err(ScriptError::Count {
                    what: "repetitions",
                    found: cycle.repetitions,
                    most: MAX_REPETITIONS,
                    place: format!("cycle {c} of action \"{name}\""),
                });
            }
            let of_cycle = cycle.properties.within(&of_action);
            for r in 0..cycle.repetitions {
                let repetition = (cycle.repetitions > 1).then_some(r);
                for (p, pose) in cycle.poses.iter().enumerate() {
                    let place = || format!("pose {p} of cycle {c} of action \"{name}\"");
                    let label = |dof| Label { action: name.clone(), cycle: c, repetition, pose: p, dof };
                    t += self.pose(pose, t, &of_cycle, &label, &place)?;
                }
                if t > MAX_TIME_S {
                    let place = format!("cycle {c} of action \"{name}\"");
                    let what = "the time reached".into();
                    return Err(ScriptError::Range { what, value: t, allowed: "up to 86400 s", place });
                }
            }
        }
        // a closing pause lasts too
        self.tracks.duration_s = self.tracks.duration_s.max(t);
        Ok(())
    }

    /// Adds the elements of a pose that starts at `t`; returns how long it lasts, s.
    fn pose(
        &mut self,
        pose: &Pose,
        t: f64,
        outer: &Properties,
        label: &dyn Fn(usize) -> Label,
        place: &dyn Fn() -> String,
    ) -> Result<f64, ScriptError> {
        let of_pose = pose.properties.within(outer);
        if pose.values.is_empty() {
            let s = of_pose.settle(place)?;
            return Ok(s.duration_s + s.hold_s);
        }
        let (mut seen, mut length) = (BTreeSet::new(), 0.0_f64);
        for value in &pose.values {
            let dof = self.check(value, place)?;
            if !seen.insert(dof) {
                return Err(ScriptError::Twice { name: value.dof.clone(), place: place() });
            }
            let s = value.properties.within(&of_pose).settle(place)?;
            length = length.max(s.duration_s + s.hold_s);
            self.push(label(dof), t, value.value, &s, place)?;
        }
        Ok(length)
    }
}

fn check_start(start_s: f64, place: &dyn Fn() -> String) -> Result<(), ScriptError> {
    if (0.0..=MAX_TIME_S).contains(&start_s) {
        return Ok(());
    }
    let what = "start_s".into();
    Err(ScriptError::Range { what, value: start_s, allowed: "0 to 86400 s", place: place() })
}

impl Script {
    /// The tracks of this script over the pose `base` (length `nq`).
    ///
    /// The motion lasts until the last hold, or the last pause, ends.
    ///
    /// # Errors
    /// See [`ScriptError`]; the first fault found, in reading order.
    pub fn build(&self, skeleton: &Arc<Skeleton>, base: &[f64]) -> Result<Tracks, ScriptError> {
        if base.len() != skeleton.nq() {
            return Err(ScriptError::Base { found: base.len(), needed: skeleton.nq() });
        }
        let dofs = Dof::all(skeleton);
        let tracks = Tracks::new(skeleton.clone(), base.to_vec());
        let mut b = Builder { skeleton: skeleton.as_ref(), dofs, tracks, count: 0 };
        let mut names = BTreeSet::new();
        for action in &self.actions {
            if action.name.is_empty() {
                return Err(ScriptError::Unnamed);
            }
            if !names.insert(action.name.as_str()) {
                return Err(ScriptError::DuplicateAction(action.name.clone()));
            }
            b.action(action, &self.properties)?;
        }
        let mut inserted = BTreeSet::new();
        for insert in &self.inserts {
            let place = || format!("insert \"{}\"", insert.name);
            if insert.name.is_empty() {
                return Err(ScriptError::Unnamed);
            }
            if names.contains(insert.name.as_str()) {
                return Err(ScriptError::DuplicateAction(insert.name.clone()));
            }
            check_start(insert.start_s, &place)?;
            let dof = b.check(&insert.value, &place)?;
            if !inserted.insert((insert.name.as_str(), dof)) {
                return Err(ScriptError::Twice { name: insert.value.dof.clone(), place: place() });
            }
            let s = insert.value.properties.within(&self.properties).settle(&place)?;
            let action = insert.name.as_str().into();
            let label = Label { action, cycle: 0, repetition: None, pose: 0, dof };
            b.push(label, insert.start_s, insert.value.value, &s, &place)?;
        }
        let mut tracks = b.tracks;
        tracks.extend_duration();
        Ok(tracks)
    }
}
