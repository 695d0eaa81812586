//! Words of conditions: gravity, ground, what holds the root, pushes, masses carried, reactive properties, numbers of the
//! dynamic pass.

use std::collections::BTreeMap;
use std::fmt;

use controllers::{GainBlend, Strategy};
use dynamics::RootName;
use dynamics::conditions::GRAVITY;
use motion::Curve;
use motion::floor::FRICTION;
use serde::Deserialize;
use serde::de::{self, Deserializer, SeqAccess, VariantAccess, Visitor};

use super::edits::ArgumentRon;
use super::word::{self, Named, NamedWith, Variants};
use crate::conditions::{Clock, GroundName, PropName, SoleName, ToesName};

/// Gravity and ground.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "world", default)]
pub struct WorldRon {
    /// Gravity, m/s².
    pub gravity_m_s2: (f64, f64, f64),
    /// The ground.
    pub ground: NamedWith<GroundRon>,
    /// Boxes and ramps fixed in the world.
    pub props: Vec<NamedWith<PropRon>>,
    /// Whether links touch each other.
    pub self_collision: bool,
}

impl Default for WorldRon {
    fn default() -> Self {
        Self {
            gravity_m_s2: (GRAVITY.x, GRAVITY.y, GRAVITY.z),
            ground: NamedWith(GroundRon::Plane(PlaneRon {
                friction: FRICTION,
                height_m: None,
                tilt_deg: 0.0,
                towards_deg: 0.0,
                tilts: Vec::new(),
            })),
            props: Vec::new(),
            self_collision: false,
        }
    }
}

/// Something fixed in the world.
#[derive(Clone, Debug)]
pub enum PropRon {
    /// A box that stands upright.
    Box(BoxRon),
    /// A plank that rises.
    Ramp(RampRon),
}

/// A box that stands upright.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Box")]
pub struct BoxRon {
    /// Its name in contacts and verdicts; by default `box` and its number.
    pub name: Option<String>,
    /// Middle of its lower face, m.
    pub at_m: (f64, f64, f64),
    /// Edges along x, y (up) and z, m.
    pub size_m: (f64, f64, f64),
    /// Turn about the vertical, degrees.
    #[serde(default)]
    pub turn_deg: f64,
    /// Coulomb friction coefficient.
    #[serde(default = "friction")]
    pub friction: f64,
}

/// A plank that rises.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Ramp")]
pub struct RampRon {
    /// Its name in contacts and verdicts; by default `ramp` and its number.
    pub name: Option<String>,
    /// Middle of the lower edge of its upper face, m.
    pub at_m: (f64, f64, f64),
    /// Length along the slope, m.
    pub length_m: f64,
    /// Width, m.
    pub width_m: f64,
    /// Thickness of the plank, m.
    #[serde(default = "plank")]
    pub height_m: f64,
    /// How steep it is, degrees.
    pub rise_deg: f64,
    /// Where it rises to: 0 forward, 90 the character's left, degrees.
    #[serde(default)]
    pub towards_deg: f64,
    /// Coulomb friction coefficient.
    #[serde(default = "friction")]
    pub friction: f64,
}

fn friction() -> f64 {
    FRICTION
}

fn plank() -> f64 {
    bodies::prop::PLANK_M
}

impl Variants for PropRon {
    type Name = PropName;

    fn variant<'de, A: VariantAccess<'de>>(name: PropName, data: A) -> Result<Self, A::Error> {
        match name {
            PropName::Box => word::fields(data).map(Self::Box),
            PropName::Ramp => word::fields(data).map(Self::Ramp),
        }
    }
}

/// The ground.
#[derive(Clone, Debug)]
pub enum GroundRon {
    /// None: the body hangs in the air.
    None,
    /// A plane.
    Plane(PlaneRon),
}

/// A plane that the body stands on.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Plane")]
pub struct PlaneRon {
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Height under the world's origin, m; by default 0, under a clip where its feet are.
    pub height_m: Option<f64>,
    /// How steep it is, degrees.
    #[serde(default)]
    pub tilt_deg: f64,
    /// Where it falls to: 0 forward, 90 the character's left, degrees.
    #[serde(default)]
    pub towards_deg: f64,
    /// How it turns during the run, in order of time.
    #[serde(default)]
    pub tilts: Vec<TiltRon>,
}

impl Variants for GroundRon {
    type Name = GroundName;

    fn variant<'de, A: VariantAccess<'de>>(name: GroundName, data: A) -> Result<Self, A::Error> {
        match name {
            GroundName::None => data.unit_variant().map(|()| Self::None),
            GroundName::Plane => word::fields(data).map(Self::Plane),
        }
    }
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
    pub curve: NamedWith<Curve>,
    /// Whose time it keeps.
    #[serde(default)]
    pub clock: Named<Clock>,
}

fn ease_in_out() -> NamedWith<Curve> {
    NamedWith(Curve::EaseInOut)
}

/// What holds the root.
#[derive(Clone, Copy, Debug, Default)]
pub enum RootRon {
    /// Muscles and contacts only.
    #[default]
    Free,
    /// A wrench towards the kinematic path, within a budget.
    Assisted(AssistRon),
    /// The root follows the kinematic path.
    Pinned,
    /// Assisted with a budget that grows with a number: 0 free, 1 as much help as could carry the body.
    Fidelity(f64),
}

/// The budget of an assisted root.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Assisted")]
pub struct AssistRon {
    /// Largest force, N.
    pub force_n: f64,
    /// Largest moment, N·m.
    pub moment_nm: f64,
}

impl Variants for RootRon {
    type Name = RootName;

    fn variant<'de, A: VariantAccess<'de>>(name: RootName, data: A) -> Result<Self, A::Error> {
        match name {
            RootName::Free => data.unit_variant().map(|()| Self::Free),
            RootName::Pinned => data.unit_variant().map(|()| Self::Pinned),
            RootName::Assisted => word::fields(data).map(Self::Assisted),
            RootName::Fidelity => data.newtype_variant().map(Self::Fidelity),
        }
    }
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
        /// Share of the spine's range by which the trunk goes along, 0 to 1; by default half, none where `joints` are given.
        trunk: Option<f64>,
        /// Whose time it keeps.
        #[serde(default)]
        clock: Named<Clock>,
    },
    /// A program of the user.
    Program {
        /// Its file.
        file: String,
        /// What it is given, by name.
        #[serde(default)]
        params: BTreeMap<String, ArgumentRon>,
    },
}

fn gaze_blend() -> f64 {
    0.5
}

fn gaze_eyes() -> String {
    "eyes".into()
}

/// Numbers of the dynamic pass.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "physics", default)]
pub struct PhysicsRon {
    /// Control steps per second; by default 240, for a clip whole steps per frame near 240.
    pub rate_hz: Option<f64>,
    /// Engine substeps; by default two, or more where a joint is stiff.
    pub substeps: Option<usize>,
    /// Factor on every tension.
    pub tension: f64,
    /// What transitions interpolate.
    pub blend: Named<GainBlend>,
    /// What the soles are; by default pads under a body that steps by looking ahead, else rigid.
    pub soles: Option<NamedWith<SolesRon>>,
    /// What the toes do; by default they are welded.
    pub toes: Option<NamedWith<ToesRon>>,
}

impl Default for PhysicsRon {
    fn default() -> Self {
        Self { rate_hz: None, substeps: None, tension: 1.0, blend: Named::default(), soles: None, toes: None }
    }
}

/// What the soles are.
#[derive(Clone, Copy, Debug)]
pub enum SolesRon {
    /// As hard as the engine's contacts.
    Rigid,
    /// Pads under heel and ball.
    Pads(PadsRon),
}

impl Variants for SolesRon {
    type Name = SoleName;

    fn variant<'de, A: VariantAccess<'de>>(name: SoleName, data: A) -> Result<Self, A::Error> {
        match name {
            SoleName::Rigid => data.unit_variant().map(|()| Self::Rigid),
            SoleName::Pads => word::fields(data).map(Self::Pads),
        }
    }
}

/// The pads of a foot; by default those of bare adult feet.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "Pads", default)]
pub struct PadsRon {
    /// Under the heel.
    pub heel: PadRon,
    /// Under the ball.
    pub ball: PadRon,
}

/// A spring and a damper; what is left out is that of the default.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "pad", default)]
pub struct PadRon {
    /// Stiffness, N/m.
    pub stiffness_n_m: Option<f64>,
    /// Damping, N·s/m.
    pub damping_n_s_m: Option<f64>,
    /// How far it gives way before its tissue is compact, m.
    pub travel_m: Option<f64>,
    /// Stiffness beyond that, N/m.
    pub compact_n_m: Option<f64>,
}

/// What the toes do.
#[derive(Clone, Copy, Debug)]
pub enum ToesRon {
    /// They are parts of their foot.
    Welded,
    /// They bend about a hinge.
    Bend(BendRon),
}

impl Variants for ToesRon {
    type Name = ToesName;

    fn variant<'de, A: VariantAccess<'de>>(name: ToesName, data: A) -> Result<Self, A::Error> {
        match name {
            ToesName::Welded => data.unit_variant().map(|()| Self::Welded),
            ToesName::Bend => word::fields(data).map(Self::Bend),
        }
    }
}

/// The hinge of toes; what is left out is that of the default.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "Bend", default)]
pub struct BendRon {
    /// Stiffness, N·m/rad.
    pub stiffness_nm_rad: Option<f64>,
    /// Damping, N·m·s/rad.
    pub damping_nm_s_rad: Option<f64>,
}

/// The balance of a standing body.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "balance", default)]
pub struct BalanceRon {
    /// Strategies switched off.
    pub without: Vec<Named<Strategy>>,
    /// Stiffness of both ankles together over m g h; by default what the tension gives.
    pub ankle_stiffness: Option<f64>,
    /// Arms may swing against pushes.
    pub arms: bool,
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
    /// Whose time it keeps.
    #[serde(default)]
    pub clock: Named<Clock>,
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
    /// Whose time it keeps.
    #[serde(default)]
    pub clock: Named<Clock>,
}

fn crate_size() -> (f64, f64, f64) {
    (0.2, 0.2, 0.2)
}

fn yes() -> bool {
    true
}
