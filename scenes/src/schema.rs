//! The words of a scene file, as serde reads them; see `docs/SCENES.md` for the user's guide.
//!
//! In: RON. Out: plain structs with numbers as written (degrees, metres, seconds); [`crate::scene`] turns
//! them into a checked scene. Unknown fields are errors everywhere.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};

use crate::Angle;

/// A whole scene file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Scene")]
pub struct SceneRon {
    /// Character file, relative to the scene file.
    pub character: String,
    /// Frames per second of the clips written.
    #[serde(default = "default_rate")]
    pub rate_hz: f64,
    /// Properties every action inherits.
    #[serde(default)]
    pub properties: PropertiesRon,
    /// Actions.
    #[serde(default)]
    pub script: Vec<ActionRon>,
    /// A human motion put on the character, instead of a script.
    pub motion: Option<MotionRon>,
    /// Single elements beside the actions.
    #[serde(default)]
    pub inserts: Vec<InsertRon>,
    /// Edits, in the order they are applied.
    #[serde(default)]
    pub edits: Vec<EditRon>,
    /// Still time after the last element, s.
    #[serde(default = "default_settle")]
    pub settle_s: f64,
    /// Limbs whose ends stay where they are at rest; by default every leg.
    pub planted: Option<Vec<String>>,
    /// Steps and jumps of the planted limbs.
    #[serde(default)]
    pub footwork: Vec<FootworkRon>,
    /// Gravity and ground.
    #[serde(default)]
    pub world: WorldRon,
    /// What holds the root in the dynamic pass.
    #[serde(default)]
    pub root: RootRon,
    /// Numbers of the dynamic pass.
    #[serde(default)]
    pub physics: PhysicsRon,
    /// The balance of a standing body.
    #[serde(default)]
    pub balance: BalanceRon,
    /// Pushes from outside.
    #[serde(default)]
    pub pushes: Vec<PushRon>,
    /// Masses carried.
    #[serde(default)]
    pub carried: Vec<CarriedRon>,
    /// Reactive properties beside the balance.
    #[serde(default)]
    pub reactive: Vec<ReactiveRon>,
    /// Points of view and captions for the film strips.
    #[serde(default)]
    pub strip: StripRon,
    /// Patch of tension and balance, a file relative to the scene.
    pub patch: Option<String>,
    /// How `contrapposto tune` chooses tension and balance.
    pub tune: Option<TuneRon>,
}

fn default_rate() -> f64 {
    120.0
}
fn default_settle() -> f64 {
    1.5
}
fn one() -> i64 {
    1
}

/// Properties that flow down the hierarchy.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "properties")]
pub struct PropertiesRon {
    /// Transition curve.
    pub curve: Option<CurveRon>,
    /// Tension, 1 = relaxed and natural.
    pub tension: Option<f64>,
    /// Transition time, s.
    pub duration_s: Option<f64>,
    /// Hold time, s.
    pub hold_s: Option<f64>,
}

/// A named transition curve.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename = "curve")]
#[expect(missing_docs, reason = "documented in motion::curve")]
pub enum CurveRon {
    Linear,
    EaseIn,
    EaseOut,
    EaseInOut,
    Overshoot,
    Anticipate,
    Bezier(f64, f64, f64, f64),
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
    pub curve: Option<CurveRon>,
    /// Inherited by its cycles.
    pub tension: Option<f64>,
    /// Inherited by its cycles, s.
    pub duration_s: Option<f64>,
    /// Inherited by its cycles, s.
    pub hold_s: Option<f64>,
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
    pub curve: Option<CurveRon>,
    /// Inherited by its poses.
    pub tension: Option<f64>,
    /// Inherited by its poses, s.
    pub duration_s: Option<f64>,
    /// Inherited by its poses, s.
    pub hold_s: Option<f64>,
    /// Poses, one after another.
    pub poses: Vec<PoseRon>,
}

/// A pose: transitions that run side by side.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Pose")]
pub struct PoseRon {
    /// Inherited by its elements.
    pub curve: Option<CurveRon>,
    /// Inherited by its elements.
    pub tension: Option<f64>,
    /// Inherited by its elements, s.
    pub duration_s: Option<f64>,
    /// Inherited by its elements, s.
    pub hold_s: Option<f64>,
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
    pub curve: Option<CurveRon>,
    /// Tension.
    pub tension: Option<f64>,
    /// Transition time, s.
    pub duration_s: Option<f64>,
    /// Hold time, s.
    pub hold_s: Option<f64>,
    /// As in a pose.
    #[serde(default)]
    pub set_deg: BTreeMap<String, Angle>,
    /// As in a pose.
    #[serde(default)]
    pub set_m: BTreeMap<String, f64>,
}

/// Where a motion comes from that is not a script.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "motion")]
pub enum MotionRon {
    /// A human motion put on the character.
    Retarget {
        /// The performance or clip, relative to the scene file.
        of: String,
        /// The key poses, relative to the scene file; by default those that lie beside the character.
        keyposes: Option<String>,
        /// The model.
        #[serde(default)]
        model: ModelRon,
        /// The last stage.
        #[serde(default)]
        stop_after: StopAfterRon,
        /// How distances of travel scale.
        #[serde(default)]
        size: SizeRon,
        /// What the refinement may move.
        #[serde(default)]
        refine: RefineRon,
        /// Whether parts that can follow by dynamics do.
        #[serde(default = "yes")]
        sway: bool,
        /// Contact phases by hand, relative to the scene file.
        contacts: Option<String>,
    },
}

/// How distances of travel scale.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename = "size")]
#[expect(missing_docs, reason = "documented in retarget::SizeRatio")]
pub enum SizeRon {
    #[default]
    Stride,
    PerAxis,
    Uniform,
    Fixed(f64),
}

/// What the refinement may move.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename = "refine")]
#[expect(missing_docs, reason = "documented in retarget::RefineDofs")]
pub enum RefineRon {
    #[default]
    RootHeight,
    Root,
    RootAndLegs,
    Links(Vec<String>),
}

/// The statistical model of a mapping.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename = "model")]
#[expect(missing_docs, reason = "documented in retarget::MappingModel")]
pub enum ModelRon {
    #[default]
    Gplvm,
    Gp,
    Pca,
    Nn3,
    Nn10,
}

/// A stage of the retargeting.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename = "stage")]
#[expect(missing_docs, reason = "documented in retarget::Stage")]
pub enum StopAfterRon {
    Map,
    Global,
    Contact,
    #[default]
    Refine,
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

/// A parameter of an edit: a number, `[one, for, each, pose]`, `(over_time_s: [(t, x), …])` or
/// `(over_repetition: [(n, x), …])`.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterRon {
    /// One value.
    Constant(f64),
    /// One value for each pose selected.
    PerPose(Vec<f64>),
    /// Knots over time, s.
    OverTime(Vec<(f64, f64)>),
    /// Knots over repetitions, counted from 0.
    OverRepetition(Vec<(f64, f64)>),
}

impl<'de> Deserialize<'de> for ParameterRon {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Read;
        impl<'de> Visitor<'de> for Read {
            type Value = ParameterRon;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, [a, list, over, poses], (over_time_s: [(t, x), …]) or (over_repetition: [(n, x), …])")
            }
            fn visit_f64<E: de::Error>(self, x: f64) -> Result<Self::Value, E> {
                Ok(ParameterRon::Constant(x))
            }
            fn visit_i64<E: de::Error>(self, x: i64) -> Result<Self::Value, E> {
                Ok(ParameterRon::Constant(x as f64))
            }
            fn visit_u64<E: de::Error>(self, x: u64) -> Result<Self::Value, E> {
                Ok(ParameterRon::Constant(x as f64))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut values = Vec::new();
                while let Some(x) = seq.next_element()? {
                    values.push(x);
                }
                Ok(ParameterRon::PerPose(values))
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                const KNOWN: &[&str] = &["over_time_s", "over_repetition"];
                let key: Option<String> = map.next_key()?;
                let found = match key.as_deref() {
                    Some("over_time_s") => ParameterRon::OverTime(map.next_value()?),
                    Some("over_repetition") => ParameterRon::OverRepetition(map.next_value()?),
                    Some(other) => return Err(de::Error::unknown_field(other, KNOWN)),
                    None => return Err(de::Error::invalid_length(0, &self)),
                };
                match map.next_key::<String>()? {
                    None => Ok(found),
                    Some(other) => Err(de::Error::unknown_field(&other, &[])),
                }
            }
        }
        d.deserialize_any(Read)
    }
}

/// Which way a succession runs.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename = "direction")]
pub enum DirectionRon {
    /// From the hips outward.
    #[default]
    Forward,
    /// From the extremities inward.
    Reverse,
}

/// What an amplitude is measured from.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename = "reference")]
pub enum ReferenceRon {
    /// The average of neighbouring poses.
    #[default]
    InterPose,
    /// The rest pose of the character.
    Rest,
}

/// An edit. `on`: labels as text, several by commas; empty is the whole script. `repetition`: only
/// this repetition of the cycle or pose named. `parts`: body parts, joints; empty is the whole body.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "edit")]
#[expect(missing_docs, reason = "fields of every variant as described above; parameters in `edits`")]
pub enum EditRon {
    Succession {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        offset_s: ParameterRon,
        #[serde(default)]
        direction: DirectionRon,
    },
    Amplitude {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        factor: ParameterRon,
        #[serde(default)]
        reference: ReferenceRon,
    },
    ExtentShoulder {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        extent: ParameterRon,
    },
    ExtentReach {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        factor: ParameterRon,
    },
    Tension {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        factor: Option<ParameterRon>,
        absolute: Option<ParameterRon>,
    },
}

/// Gravity and ground.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "world", default)]
pub struct WorldRon {
    /// Gravity, m/s².
    pub gravity_m_s2: (f64, f64, f64),
    /// The ground.
    pub ground: GroundRon,
}

impl Default for WorldRon {
    fn default() -> Self {
        Self {
            gravity_m_s2: (0.0, -9.81, 0.0),
            ground: GroundRon::Plane {
                friction: 0.8,
                height_m: 0.0,
                tilt_deg: 0.0,
                towards_deg: 0.0,
                tilts: Vec::new(),
            },
        }
    }
}

/// The ground.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "ground")]
pub enum GroundRon {
    /// None: the body hangs in the air.
    None,
    /// A plane.
    Plane {
        /// Coulomb friction coefficient.
        friction: f64,
        /// Height under the world's origin, m.
        #[serde(default)]
        height_m: f64,
        /// How steep it is, degrees.
        #[serde(default)]
        tilt_deg: f64,
        /// Where it falls to: 0 forward, 90 the character's left, degrees.
        #[serde(default)]
        towards_deg: f64,
        /// How it turns during the run, in order of time.
        #[serde(default)]
        tilts: Vec<TiltRon>,
    },
}

/// A turn of the ground.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Tilt")]
pub struct TiltRon {
    /// When it begins, s.
    pub start_s: f64,
    /// How long it takes, s.
    pub duration_s: f64,
    /// How steep the ground is afterwards, degrees.
    #[serde(default)]
    pub tilt_deg: f64,
    /// Where it then falls to, degrees.
    #[serde(default)]
    pub towards_deg: f64,
    /// How it gets there.
    #[serde(default = "ease_in_out")]
    pub curve: CurveRon,
}

fn ease_in_out() -> CurveRon {
    CurveRon::EaseInOut
}

/// What holds the root.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "root")]
pub enum RootRon {
    /// Muscles and contacts only.
    #[default]
    Free,
    /// A wrench towards the kinematic path, within a budget.
    Assisted {
        /// Largest force, N.
        force_n: f64,
        /// Largest moment, N·m.
        moment_nm: f64,
    },
    /// The root follows the kinematic path.
    Pinned,
    /// Assisted with a budget that grows with a number: 0 free, 1 as much help as could carry the body.
    Fidelity(f64),
}

/// A reactive property.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "reactive")]
pub enum ReactiveRon {
    /// Eyes on a point.
    Gaze {
        /// The point, world, m.
        at_m: (f64, f64, f64),
        /// When the gaze turns there, s.
        #[serde(default)]
        from_s: f64,
        /// When it turns away, s; by default never.
        to_s: Option<f64>,
        /// How long it takes to turn, s.
        #[serde(default = "gaze_blend")]
        blend_s: f64,
        /// The site it looks from.
        #[serde(default = "gaze_eyes")]
        eyes: String,
        /// Balls that turn it; by default those of the neck.
        joints: Option<Vec<String>>,
    },
}

fn gaze_blend() -> f64 {
    0.5
}
fn gaze_eyes() -> String {
    "eyes".into()
}

/// What transitions interpolate.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename = "blend")]
pub enum BlendRon {
    /// Stiffness and rest angle.
    #[default]
    RestAngle,
    /// The two gains, literally as in NF02.
    Gains,
}

/// Numbers of the dynamic pass.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "physics", default)]
pub struct PhysicsRon {
    /// Control steps per second.
    pub rate_hz: f64,
    /// Engine substeps; by default two, or more where a joint is stiff.
    pub substeps: Option<usize>,
    /// Factor on every tension.
    pub tension: f64,
    /// What transitions interpolate.
    pub blend: BlendRon,
}

impl Default for PhysicsRon {
    fn default() -> Self {
        Self { rate_hz: 240.0, substeps: None, tension: 1.0, blend: BlendRon::RestAngle }
    }
}

/// The balance of a standing body.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "balance", default)]
pub struct BalanceRon {
    /// Strategies switched off.
    pub without: Vec<StrategyRon>,
    /// Stiffness of both ankles together over m g h; by default what the tension gives.
    pub ankle_stiffness: Option<f64>,
    /// Arms may swing against pushes.
    pub arms: bool,
}

/// A strategy of balance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum StrategyRon {
    /// Pressure moves under the feet.
    Ankle,
    /// The trunk leans.
    Hip,
    /// Weight moves between the feet.
    Weight,
}

/// A push.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Push")]
pub struct PushRon {
    /// Link pushed.
    pub link: String,
    /// Point in the link's frame, m.
    #[serde(default)]
    pub at_m: (f64, f64, f64),
    /// Impulse, N·s: world, or how much of it goes where `towards_deg` says.
    pub impulse_ns: ImpulseRon,
    /// Where a horizontal push goes: 0 forward, 90 left, 180 back, 270 right, degrees.
    pub towards_deg: Option<f64>,
    /// When it begins, s.
    pub start_s: f64,
    /// How long it lasts, s.
    #[serde(default = "push_time")]
    pub duration_s: f64,
}

fn push_time() -> f64 {
    0.1
}

/// An impulse: `(x, y, z)`, or a number with a direction beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ImpulseRon {
    /// Its size, N·s.
    Size(f64),
    /// World, N·s.
    Vector([f64; 3]),
}

impl<'de> Deserialize<'de> for ImpulseRon {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Read;
        impl<'de> Visitor<'de> for Read {
            type Value = ImpulseRon;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number of N·s beside towards_deg, or (x, y, z)")
            }
            fn visit_f64<E: de::Error>(self, x: f64) -> Result<Self::Value, E> {
                Ok(ImpulseRon::Size(x))
            }
            fn visit_i64<E: de::Error>(self, x: i64) -> Result<Self::Value, E> {
                Ok(ImpulseRon::Size(x as f64))
            }
            fn visit_u64<E: de::Error>(self, x: u64) -> Result<Self::Value, E> {
                Ok(ImpulseRon::Size(x as f64))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut xyz = [0.0; 3];
                for (i, x) in xyz.iter_mut().enumerate() {
                    *x = seq.next_element()?.ok_or_else(|| de::Error::invalid_length(i, &self))?;
                }
                match seq.next_element::<f64>()? {
                    None => Ok(ImpulseRon::Vector(xyz)),
                    Some(_) => Err(de::Error::invalid_length(4, &self)),
                }
            }
        }
        d.deserialize_any(Read)
    }
}

/// A mass that moves with a link.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Carried")]
pub struct CarriedRon {
    /// Link that carries it.
    pub link: String,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Its centre in the link's frame, m.
    #[serde(default)]
    pub at_m: (f64, f64, f64),
    /// Edges of the box it is, along the link's axes, m; zeros are a point.
    #[serde(default = "crate_size")]
    pub size_m: (f64, f64, f64),
    /// When it is handed over, s.
    #[serde(default)]
    pub from_s: f64,
    /// When it is taken, s; by default never.
    pub to_s: Option<f64>,
    /// Whether the performer knows of it.
    #[serde(default = "yes")]
    pub known: bool,
}

fn crate_size() -> (f64, f64, f64) {
    (0.2, 0.2, 0.2)
}
fn yes() -> bool {
    true
}

/// How film strips are drawn.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "strip", default)]
pub struct StripRon {
    /// Number of figures in a row.
    pub figures: usize,
    /// First moment shown, s.
    pub from_s: f64,
    /// Last moment shown, s; by default the end.
    pub to_s: Option<f64>,
    /// From where it is seen, degrees: 0 the front, 90 the left; by default where the motion shows best.
    pub yaw_deg: Option<f64>,
}

impl Default for StripRon {
    fn default() -> Self {
        Self { figures: 9, from_s: 0.0, to_s: None, yaw_deg: None }
    }
}

/// How a scene is tuned; see `docs/TUNE.md`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "tune", default)]
pub struct TuneRon {
    /// Names of the parameters searched; by default all.
    pub parameters: Option<Vec<String>>,
    /// Weights of the terms.
    pub weights: Option<WeightsRon>,
    /// Fixed pushes, at most eight.
    pub pushes: Option<Vec<FixedPushRon>>,
    /// When a push begins, s.
    pub push_at_s: Option<f64>,
    /// How long after it the body is watched, s.
    pub after_s: Option<f64>,
    /// Control steps per second of the runs costed; by default the scene's.
    pub rate_hz: Option<f64>,
    /// Engine substeps of the runs costed; by default the scene's.
    pub substeps: Option<usize>,
    /// Whether the scene without a fixed push is a run too; by default if it has a script.
    pub own_run: Option<bool>,
}

/// Weights of the terms of a cost.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "weights", default)]
#[expect(missing_docs, reason = "the terms of scenes::tune::cost")]
pub struct WeightsRon {
    pub fall: Option<f64>,
    pub tracking: Option<f64>,
    pub effort: Option<f64>,
    pub overshoot: Option<f64>,
    pub smoothness: Option<f64>,
}

/// A push of a cost.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "push")]
pub struct FixedPushRon {
    /// Where it goes: 0 forward, 90 left, 180 back, 270 right, degrees.
    pub deg: f64,
    /// Its impulse, part of the physical limit in that direction.
    pub of_limit: f64,
}
