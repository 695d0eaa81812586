//! What disturbed the performer and how it fell, as `report.json` gives them.
//!
//! In: a [`Take`], a [`Fall`]. Out: parts of a [`crate::Report`]. Every unit is in its field's name.

use dynamics::fall::{Fall, Loss};
use serde::Serialize;

use crate::Take;

/// What disturbs the performer, as the scene says it.
#[derive(Clone, Debug, Serialize)]
pub struct DisturbanceReport {
    /// Steepness of the ground at the start; absent without ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground_tilt_deg: Option<f64>,
    /// Coulomb friction of the ground; absent without ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground_friction: Option<f64>,
    /// Turns of the ground, in order of time.
    pub ground_tilts: Vec<TiltReport>,
    /// Pushes.
    pub pushes: Vec<PushReport>,
    /// Masses carried.
    pub carried: Vec<CarriedReport>,
}

/// A turn of the ground.
#[derive(Clone, Debug, Serialize)]
pub struct TiltReport {
    /// When it begins, s.
    pub start_s: f64,
    /// How long it takes, s.
    pub duration_s: f64,
    /// How steep the ground is afterwards, degrees.
    pub tilt_deg: f64,
    /// Where it then falls to, degrees.
    pub towards_deg: f64,
}

/// A push.
#[derive(Clone, Debug, Serialize)]
pub struct PushReport {
    /// Link pushed.
    pub link: String,
    /// Point in the link's frame, m.
    pub at_m: [f64; 3],
    /// Impulse, world, N·s.
    pub impulse_ns: [f64; 3],
    /// When it begins, s.
    pub start_s: f64,
    /// How long it lasts, s.
    pub duration_s: f64,
}

/// A mass carried.
#[derive(Clone, Debug, Serialize)]
pub struct CarriedReport {
    /// Link that carries it.
    pub link: String,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Its centre in the link's frame, m.
    pub at_m: [f64; 3],
    /// When it is handed over, s.
    pub from_s: f64,
    /// When it is taken, s; null if it is kept.
    pub to_s: Option<f64>,
    /// Whether the performer knows of it.
    pub known: bool,
}

impl DisturbanceReport {
    pub(crate) fn new(take: &Take) -> Self {
        let name = |link: usize| take.body.character.skeleton.links()[link].name.clone();
        let ground = take.conditions.physics.ground;
        Self {
            ground_tilt_deg: ground.map(|g| g.up.y.clamp(-1.0, 1.0).acos().to_degrees()),
            ground_friction: ground.map(|g| g.friction),
            ground_tilts: take
                .conditions
                .tilts
                .iter()
                .map(|t| TiltReport {
                    start_s: t.start_s,
                    duration_s: t.duration_s,
                    tilt_deg: t.tilt.to_degrees(),
                    towards_deg: t.towards.to_degrees(),
                })
                .collect(),
            pushes: take
                .conditions
                .pushes
                .iter()
                .map(|p| PushReport {
                    link: name(p.link),
                    at_m: p.at.into(),
                    impulse_ns: (p.force * p.duration_s).into(),
                    start_s: p.start_s,
                    duration_s: p.duration_s,
                })
                .collect(),
            carried: take
                .conditions
                .carried
                .iter()
                .map(|c| CarriedReport {
                    link: name(c.what.link),
                    mass_kg: c.what.mass,
                    at_m: c.what.at.into(),
                    from_s: c.from_s,
                    to_s: c.to_s.is_finite().then_some(c.to_s),
                    known: c.known,
                })
                .collect(),
        }
    }
}

/// A fall, see [`dynamics::fall`].
#[derive(Clone, Debug, Serialize)]
pub struct FallReport {
    /// When something else than a foot came to carry load, or the body was low, s.
    pub at_s: f64,
    /// The margin lost first, in words; null if none was.
    pub cause: Option<String>,
    /// When, s.
    pub cause_at_s: Option<f64>,
    /// All margins lost for good, in order of loss.
    pub losses: Vec<LossReport>,
    /// What the motion or the world brought that made it fall, in order of time.
    pub triggers: Vec<TriggerReport>,
}

/// What made a body fall, see [`dynamics::trigger`].
#[derive(Clone, Debug, Serialize)]
pub struct TriggerReport {
    /// `pressure outside the soles`, `pushed`, `tilted ground`, `no legs` or `no ground under the feet`.
    pub trigger: &'static str,
    /// When it began, s.
    pub from_s: f64,
    /// In words.
    pub text: String,
}

/// A margin lost.
#[derive(Clone, Debug, Serialize)]
pub struct LossReport {
    /// `capture point`, `centre of mass`, `foot slipped`, `foot lifted`, `joint limit` or `slack muscle`.
    pub margin: &'static str,
    /// When, s.
    pub at_s: f64,
    /// The leg of the foot, or the joint; null for the first two.
    pub part: Option<String>,
    /// In words.
    pub text: String,
}

impl FallReport {
    pub(crate) fn new(fall: &Fall) -> Self {
        let loss = |l: &Loss| LossReport {
            margin: l.margin.name(),
            at_s: l.time_s,
            part: l.part.clone(),
            text: l.to_string(),
        };
        Self {
            at_s: fall.time_s,
            cause: fall.cause().map(|l| l.margin.name().to_owned()),
            cause_at_s: fall.cause().map(|l| l.time_s),
            losses: fall.losses.iter().map(loss).collect(),
            triggers: fall
                .triggers
                .iter()
                .map(|t| TriggerReport { trigger: t.name(), from_s: t.from_s(), text: t.to_string() })
                .collect(),
        }
    }
}

/// Tension of a joint of a stance leg that is not what was asked.
#[derive(Clone, Debug, Serialize)]
pub struct LegTensionReport {
    /// The joint.
    pub joint: String,
    /// Tension asked for.
    pub asked: f64,
    /// Tension used.
    pub used: f64,
    /// Stiffness asked for, N·m/rad.
    pub asked_nm_rad: f64,
    /// Stiffness used, N·m/rad.
    pub used_nm_rad: f64,
}
