//! Words of a script: actions, cycles, poses, single elements, steps and jumps.

use std::collections::BTreeMap;

use motion::curve::CurveName;
use motion::{Curve, Timing};
use serde::Deserialize;
use serde::de::VariantAccess;

use super::word::{self, Named, NamedWith, Variants};
use crate::Angle;

fn one() -> i64 {
    1
}

/// Properties that flow down the hierarchy.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "properties")]
pub struct PropertiesRon {
    /// Transition curve.
    pub curve: Option<NamedWith<Curve>>,
    /// Tension, 1 = relaxed and natural.
    pub tension: Option<f64>,
    /// Transition time, s.
    pub duration_s: Option<f64>,
    /// Hold time, s.
    pub hold_s: Option<f64>,
    /// Timing.
    pub timing: Option<Named<Timing>>,
}

impl Variants for Curve {
    type Name = CurveName;

    fn variant<'de, A: VariantAccess<'de>>(name: CurveName, data: A) -> Result<Self, A::Error> {
        match Self::named(name) {
            Some(curve) => data.unit_variant().map(|()| curve),
            None => word::numbers(data, 4).map(|(x1, y1, x2, y2)| Self::Bezier(x1, y1, x2, y2)),
        }
    }
}

/// An action.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Action")]
pub struct ActionRon {
    /// Unique name.
    pub name: String,
    /// When it starts, s.
    #[serde(default)]
    pub start_s: f64,
    /// Inherited by its cycles.
    pub curve: Option<NamedWith<Curve>>,
    /// Inherited by its cycles.
    pub tension: Option<f64>,
    /// Inherited by its cycles, s.
    pub duration_s: Option<f64>,
    /// Inherited by its cycles, s.
    pub hold_s: Option<f64>,
    /// Inherited by its cycles.
    pub timing: Option<Named<Timing>>,
    /// Cycles, one after another.
    pub cycles: Vec<CycleRon>,
}

/// A cycle of poses.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Cycle")]
pub struct CycleRon {
    /// How often it runs.
    #[serde(default = "one")]
    pub repetitions: i64,
    /// Inherited by its poses.
    pub curve: Option<NamedWith<Curve>>,
    /// Inherited by its poses.
    pub tension: Option<f64>,
    /// Inherited by its poses, s.
    pub duration_s: Option<f64>,
    /// Inherited by its poses, s.
    pub hold_s: Option<f64>,
    /// Inherited by its poses.
    pub timing: Option<Named<Timing>>,
    /// Poses, one after another.
    pub poses: Vec<PoseRon>,
}

/// A pose: transitions that run side by side.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Pose")]
pub struct PoseRon {
    /// Inherited by its elements.
    pub curve: Option<NamedWith<Curve>>,
    /// Inherited by its elements.
    pub tension: Option<f64>,
    /// Inherited by its elements, s.
    pub duration_s: Option<f64>,
    /// Inherited by its elements, s.
    pub hold_s: Option<f64>,
    /// Inherited by its elements.
    pub timing: Option<Named<Timing>>,
    /// End values of joints: degrees for hinges, `(x, y, z)` degrees for balls.
    #[serde(default)]
    pub set_deg: BTreeMap<String, Angle>,
    /// End values of slides and of the root's position *relative to rest*, m: `pelvis_x`.
    #[serde(default)]
    pub set_m: BTreeMap<String, f64>,
    /// Joints that go back to the rest pose.
    #[serde(default)]
    pub rest: Vec<String>,
    /// Properties of single elements of this pose, by joint.
    #[serde(default)]
    pub elements: BTreeMap<String, PropertiesRon>,
}

/// Elements inserted directly, not through an action.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Insert")]
pub struct InsertRon {
    /// Unique name, as an action's.
    pub name: String,
    /// When they start, s.
    pub start_s: f64,
    /// Transition curve.
    pub curve: Option<NamedWith<Curve>>,
    /// Tension.
    pub tension: Option<f64>,
    /// Transition time, s.
    pub duration_s: Option<f64>,
    /// Hold time, s.
    pub hold_s: Option<f64>,
    /// Timing.
    pub timing: Option<Named<Timing>>,
    /// As in a pose.
    #[serde(default)]
    pub set_deg: BTreeMap<String, Angle>,
    /// As in a pose.
    #[serde(default)]
    pub set_m: BTreeMap<String, f64>,
}

/// A step or a jump.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "footwork")]
pub enum FootworkRon {
    /// One planted limb goes to another place.
    Step {
        /// The limb.
        limb: String,
        /// When it leaves the ground, s.
        start_s: f64,
        /// Time in the air, s.
        #[serde(default = "step_time")]
        duration_s: f64,
        /// Where to, left and front, relative to rest, m.
        #[serde(default)]
        to_m: (f64, f64),
        /// Heading there relative to rest, degrees, positive to the left.
        #[serde(default)]
        turn_deg: f64,
        /// Height of the step, m.
        #[serde(default = "step_lift")]
        lift_m: f64,
    },
    /// All planted limbs and the root fly.
    Jump {
        /// When they leave the ground, s.
        start_s: f64,
        /// Time in the air, s; the height follows, `g T²/8`.
        duration_s: f64,
        /// How far the toes point down in mid-air, degrees.
        #[serde(default)]
        point_deg: f64,
        /// How far the feet are drawn up in mid-air, m.
        #[serde(default)]
        tuck_m: f64,
    },
}

fn step_time() -> f64 {
    0.45
}

fn step_lift() -> f64 {
    0.06
}
