//! Standing: the parts of a clip a body can perform on its own feet.
//!
//! In: the [`Stage`] of a clip. Out: its stance (where it stands, where it steps), and per standing span a stage of
//! its own with planted feet, on which the balance property works.
//!
//! Captured feet creep, roll and hover by centimetres, and the sole guessed for them is tilted by a few degrees: a
//! body set on them starts on an edge and falls. So over a standing span each sole is planted flat, at the
//! mean of its places and headings; the root keeps its path, moved by the mean of what the soles were moved; the
//! legs are solved by IK. The motion is smoothed as inverse dynamics smooths it (`dynamics::analysis`), and where
//! it still asks for a centre of pressure beyond the soles the root is moved until it does not
//! (`controllers::admissible`). Nothing else of the motion changes.

use std::ops::Range;
use std::sync::Mutex;

use controllers::admissible::admit;
use controllers::support::Foot;
use dynamics::analysis::{AnalysisOptions, strength};
use dynamics::{Character, Model, RootMode, State};
use motion::ik::IkError;
use motion::plant::{Plant, plant};
use motion::stance::{self, Settings, Sole, Span, Stance};
use motion::{Clip, Kinematics, Vec3};
use rayon::prelude::*;
use sim::{Ground, Outcome, PassError};

use crate::Stage;

/// Friction of the ground under a clip.
pub(crate) const FRICTION: f64 = 0.8;
/// The centre of pressure asked for stays this far inside the soles, m.
const MARGIN: f64 = 0.02;

/// Soles of a character's legs, with the name of each leg.
pub fn soles(character: &Character) -> Vec<(String, Sole)> {
    let model = Model::new(character, Vec3::zeros());
    let of = |f: Foot| (f.limb.name.clone(), Sole { link: f.limb.end, corners: f.corners });
    Foot::of(character, &model).into_iter().map(of).collect()
}

/// Where a character's feet stand in a clip of it, and where they step.
pub fn stance(character: &Character, clip: &Clip) -> Stance {
    let soles: Vec<Sole> = soles(character).into_iter().map(|(_, s)| s).collect();
    stance::stance(clip, &soles, &Settings::default())
}

/// Part of a clip, its first frame at time zero.
fn part(clip: &Clip, frames: Range<usize>) -> Clip {
    let nq = clip.skeleton.nq();
    Clip::new(clip.skeleton.clone(), clip.rate_hz, clip.data()[frames.start * nq..frames.end * nq].to_vec())
}

/// A standing span, performed.
pub struct Performed {
    /// Which of the stance's spans.
    pub span: usize,
    /// Its stage.
    pub stage: Stage,
    /// What came of it.
    pub outcome: Outcome,
}

/// Why the standing spans of a clip cannot be performed.
#[derive(Debug, thiserror::Error)]
pub enum StandingError {
    /// Legs that two-bone IK cannot solve.
    #[error(transparent)]
    Legs(#[from] IkError),
    /// The pass.
    #[error(transparent)]
    Pass(#[from] PassError),
}

impl Stage {
    /// Whether this is a clip that stands on the ground free or assisted, but only in parts: they are performed each by
    /// itself, see [`Stage::perform_standing`].
    pub fn stands_in_parts(&self) -> bool {
        let stands = |s: &Stance| s.standing().next().is_some();
        self.physics.root == RootMode::Free
            && self.plants.is_empty()
            && self.stance.as_ref().is_some_and(stands)
    }

    /// Performs every standing span of a clip by itself, in parallel. Spans come in order; the same on any number of
    /// threads.
    ///
    /// # Errors
    /// Legs that cannot be solved, passes that cannot start.
    pub fn perform_standing(&self, progress: &(dyn Fn(f64) + Sync)) -> Result<Vec<Performed>, StandingError> {
        let Some(stance) = &self.stance else { return Ok(Vec::new()) };
        let standing: Vec<(usize, &Span)> =
            stance.spans.iter().enumerate().filter(|(_, s)| s.stands).collect();
        let frames: usize = standing.iter().map(|(_, s)| s.frames.len()).sum();
        let done = Mutex::new(vec![0.0; standing.len()]);
        let one = |(i, (span, of)): (usize, &(usize, &Span))| {
            let stage = self.stand(of, stance.ground_m)?;
            let outcome = stage.perform(&mut |x| {
                if let Ok(mut done) = done.lock() {
                    done[i] = x * of.frames.len() as f64 / frames as f64;
                    progress(done.iter().sum());
                }
            })?;
            Ok(Performed { span: *span, stage, outcome })
        };
        standing.par_iter().enumerate().map(one).collect()
    }

    /// The same stage of some frames of its clip only. A scene is left whole: its script has no frames.
    ///
    /// # Panics
    /// If the frames are not of the clip, or fewer than two.
    pub fn cut(&self, frames: Range<usize>) -> Self {
        let Some(source) = &self.clip else { return self.clone() };
        assert!(frames.len() > 1 && frames.end <= self.kinematic.frames(), "{frames:?}");
        let mut source = source.clone();
        source.clip = part(&source.clip, frames.clone());
        let mut stage = Self {
            kinematic: part(&self.kinematic, frames.clone()),
            unedited: part(&self.unedited, frames),
            clip: Some(source),
            ..self.clone()
        };
        stage.stance = Some(stance(&stage.character, &stage.kinematic));
        stage
    }

    /// The stage of a standing span: cut, feet planted flat on the ground. See the module header.
    ///
    /// # Errors
    /// Legs that two-bone IK cannot solve.
    pub fn stand(&self, span: &Span, ground_m: f64) -> Result<Self, IkError> {
        let mut stage = self.cut(span.frames.clone());
        let skeleton = stage.character.skeleton.clone();
        let whole = 0..stage.kinematic.frames();
        let limbs = skeleton.limbs();
        let (mut plants, mut moved) = (Vec::new(), Vec3::zeros());
        let soles = soles(&stage.character);
        for (_, sole) in &soles {
            let limb = limbs.iter().find(|l| l.end == sole.link).expect("soles are of limbs");
            let world_from_end = stance::place(&stage.kinematic, sole, whole.clone(), ground_m);
            let mean: Vec3 = whole
                .clone()
                .map(|f| sole.center(&Kinematics::new(&skeleton, stage.kinematic.pose(f))))
                .sum();
            let k = Kinematics::new(&skeleton, stage.kinematic.pose(0));
            let from_end = world_from_end * k.world[sole.link].inverse();
            let placed = from_end.transform_point(&sole.center(&k).into()).coords;
            moved += (placed - mean / whole.len() as f64) / soles.len() as f64;
            plants.push(Plant { limb: limb.clone(), world_from_end });
        }
        for f in whole {
            let q = stage.kinematic.pose_mut(f);
            let root = skeleton.position(q, 0) + moved;
            skeleton.set_position(q, 0, &root);
            plant(&skeleton, q, &plants)?;
        }
        let model = Model::new(&stage.character, stage.physics.gravity);
        let strength =
            strength(&model, &mut State::new(&model), &stage.kinematic, &AnalysisOptions::default());
        stage.kinematic = motion::smooth::smooth_at(&stage.kinematic, strength).clip;
        let feet = Foot::of(&stage.character, &model);
        admit(&model, &mut stage.kinematic, &feet, &plants, ground_m, MARGIN)?;
        stage.physics.ground = Some(Ground::level(ground_m, FRICTION));
        stage.plants = plants;
        stage.stance = Some(Stance {
            spans: vec![Span { frames: 0..stage.kinematic.frames(), stands: true, stepping: Vec::new() }],
            ground_m,
        });
        Ok(stage)
    }
}
