//! Standing: the parts of a clip a body can perform on its own feet.
//!
//! In: the [`Take`] of a clip. Out: its stance (where it stands, where it steps), and per standing span a take of
//! its own with planted feet, on which the balance property works.
//!
//! Captured feet creep, roll and hover by centimetres, and the sole guessed for them is tilted by a few degrees: a
//! body set on them starts on an edge and falls. So over a standing span each sole is planted flat, at the
//! mean of its places and headings; the root keeps its path, moved by the mean of what the soles were moved; the
//! legs are solved by IK. The motion is smoothed as inverse dynamics smooths it (`dynamics::analysis`), and where
//! it still asks for a centre of pressure beyond the soles the root is moved until it does not
//! (`controllers::admissible`). Nothing else of the motion changes.

use std::ops::Range;

use bodies::Character;
use controllers::admissible::admit;
use controllers::support::Foot;
use dynamics::Model;
use dynamics::analysis::smoothed;
use dynamics::conditions::RootMode;
use motion::floor::FRICTION;
use motion::ik::IkError;
use motion::plant::{Knee, Plant, plant};
use motion::stance::{self, Settings, Stance, StanceSpan};
use motion::{Clip, Contact, ContactPlan, Derivatives, Floor, Kinematics, Sole, Vec3};

use crate::Conditions;
use crate::take::{Asked, Source, Take};

/// The centre of pressure asked for stays this far inside the soles, m.
const MARGIN: f64 = 0.02;

/// Where a character's feet stand in a clip of it, and where they step.
pub fn stance(character: &Character, clip: &Clip) -> Stance {
    let soles: Vec<Sole> = character.leg_soles().into_iter().map(|(_, s)| s).collect();
    stance::stance(clip, &soles, &Settings::default())
}

/// When a character's feet are on the ground in a clip of it, each named by its leg, and the height of the ground, m; `None` for
/// a body without soles. See [`motion::contacts()`].
pub fn contacts(character: &Character, clip: &Clip) -> (ContactPlan, Option<f64>) {
    let soles: Vec<Sole> = character.leg_soles().into_iter().map(|(_, s)| s).collect();
    motion::contacts(clip, &soles)
}

/// The plan of limbs that stand from beginning to end.
fn throughout(plants: &[Plant], end_s: f64) -> ContactPlan {
    let stands = |p: &Plant| Contact {
        point: p.limb.name.clone(),
        from_s: 0.0,
        to_s: end_s,
        world_from_point: Some(p.world_from_end),
    };
    // each limb is planted once
    ContactPlan::new(plants.iter().map(stands).collect()).unwrap_or_default()
}

/// Part of a clip, its first frame at time zero.
fn part(clip: &Clip, frames: Range<usize>) -> Clip {
    let nq = clip.skeleton.nq();
    Clip::new(clip.skeleton.clone(), clip.rate_hz, clip.data()[frames.start * nq..frames.end * nq].to_vec())
}

/// Moves the root where the soles could not carry the motion.
fn carry(
    character: &Character,
    model: &Model,
    clip: &mut Clip,
    plants: &[Plant],
    ground_m: f64,
) -> Result<(), IkError> {
    let feet = Foot::of(character, model);
    let derivatives = Derivatives::central(clip);
    admit(model, clip, &derivatives, &feet, plants, ground_m, MARGIN)?;
    Ok(())
}

impl Take {
    /// Moves the root of a clip that stands as this take's where the soles could not carry it; feet are planted again.
    ///
    /// # Errors
    /// Legs that two-bone IK cannot solve.
    pub(crate) fn carry(&self, clip: &mut Clip) -> Result<(), IkError> {
        let (character, plants) = (&self.body.character, &self.asked.plants);
        let Some(stance) = &self.asked.stance else { return Ok(()) };
        for f in 0..clip.frames() {
            plant(&character.skeleton, clip.pose_mut(f), plants)?;
        }
        let model = Model::new(character, self.conditions.physics.gravity);
        carry(character, &model, clip, plants, stance.ground_m)
    }

    /// Whether this is a clip that stands on the ground free, but only in parts, and has no foresight for the others: they are performed
    /// each by itself.
    pub fn stands_in_parts(&self) -> bool {
        let stands = |s: &Stance| s.standing().next().is_some();
        self.conditions.physics.root == RootMode::Free
            && self.conditions.foresight.is_none()
            && self.asked.plants.is_empty()
            && !self.asked.contacts_given
            && self.asked.stance.as_ref().is_some_and(stands)
    }

    /// The same take of some frames of its clip only. A take that is no clip is left whole.
    ///
    /// # Panics
    /// If the frames are not of the clip, or fewer than two.
    pub fn cut(&self, frames: Range<usize>) -> Self {
        let Source::Clip(source) = &self.source else { return self.clone() };
        let asked = &self.asked;
        assert!(frames.len() > 1 && frames.end <= asked.clip.frames(), "{frames:?}");
        let mut source = source.clone();
        source.clip = part(&source.clip, frames.clone());
        let clip = part(&asked.clip, frames.clone());
        let stance = stance(&self.body.character, &clip);
        let unedited = if frames.end <= self.unedited.frames() {
            part(&self.unedited, frames.clone())
        } else {
            clip.clone()
        };
        let begin_s = frames.start as f64 / clip.rate_hz;
        let mut dense = asked.dense.clone();
        dense.joints.iter_mut().flat_map(|j| &mut j.tension).for_each(|step| step.0 -= begin_s);
        Self {
            source: Source::Clip(source),
            unedited,
            conditions: self.conditions.shifted(-begin_s),
            asked: Asked {
                contacts: contacts(&self.body.character, &clip).0,
                stance: Some(stance),
                clip,
                dense,
                ..asked.clone()
            },
            ..self.clone()
        }
    }

    /// The take of a standing span: cut, feet planted flat on the ground. See the module header.
    ///
    /// # Errors
    /// Legs that two-bone IK cannot solve.
    pub fn stand(&self, span: &StanceSpan, ground_m: f64) -> Result<Self, IkError> {
        let cut = self.cut(span.frames.clone());
        let character = &cut.body.character;
        let skeleton = &character.skeleton;
        let mut clip = cut.asked.clip.clone();
        let whole = 0..clip.frames();
        let (mut plants, mut moved) = (Vec::new(), Vec3::zeros());
        let soles = character.leg_soles();
        for (limb, sole) in &soles {
            let world_from_end = stance::place(&clip, sole, whole.clone(), ground_m);
            let mean: Vec3 =
                whole.clone().map(|f| sole.center(&Kinematics::new(skeleton, clip.pose(f)))).sum();
            let k = Kinematics::new(skeleton, clip.pose(0));
            let from_end = world_from_end * k.world[sole.link].inverse();
            let placed = from_end.transform_point(&sole.center(&k).into()).coords;
            moved += (placed - mean / whole.len() as f64) / soles.len() as f64;
            plants.push(Plant { limb: (*limb).clone(), world_from_end, knee: Knee::Kept });
        }
        for f in whole {
            let q = clip.pose_mut(f);
            let root = skeleton.position(q, 0) + moved;
            skeleton.set_position(q, 0, &root);
            plant(skeleton, q, &plants)?;
        }
        let physics = cut.conditions.physics;
        let model = Model::new(character, physics.gravity);
        let mut clip = smoothed(&model, &clip);
        carry(character, &model, &mut clip, &plants, ground_m)?;
        let stands = StanceSpan { frames: 0..clip.frames(), stands: true, stepping: Vec::new() };
        let friction = physics.ground.map_or(FRICTION, |g| g.friction);
        let ground = Some(Floor::level(ground_m, friction));
        let stance = Stance { spans: vec![stands], ground_m };
        Ok(Self {
            conditions: Conditions {
                physics: scenes::Physics { ground, ..physics },
                ..cut.conditions.clone()
            },
            asked: Asked {
                contacts: throughout(&plants, clip.duration_s()),
                stance: Some(stance),
                plants,
                clip,
                ..cut.asked.clone()
            },
            ..cut.clone()
        })
    }
}
