//! The clip edit: a learned edit applied to any clip of its rig.
//!
//! In: an [`ExampleEdit`], an amount, a motion and a place. Out: the motion edited. At the ends of a span inside the clip the edit comes and goes
//! over [`BLEND_S`]. Body parts limit it to their joints: time is changed only with the whole body, the way over
//! the ground only where the root's rotation and place may both move.
//!
//! What stands may keep standing ([`contacts`]): [`ByExample::contacts`]. The result may be on a body of other proportions ([`super::onto`]):
//! [`ByExample::onto`]; differences of joints are the same there.
//!
//! Joint limits of the skeleton are kept where the source keeps them; what they held back is noted in the log.

use std::sync::Arc;

use motion::time_map::{End, LEAST_SLOPE, MOST_SLOPE};
use motion::{Clip, Dof, Joint, TimeMap};

use super::contacts::{self, Blended, Contacts, Kept, Miss};
use super::model::Answer;
use super::onto::Onto;
use super::outputs::{self, Allowed};
use super::rig::{Moves, Rig};
use super::{ExampleEdit, ExampleError};
use crate::{ClipEdit, ClipPlace, EditError, EditLog, Edited, Motion};

/// Over which an edit comes and goes at the ends of its span, s.
pub const BLEND_S: f64 = 0.25;

/// Anchors of the map of time are this far apart, s.
const ANCHORS_S: f64 = 1.0 / 30.0;

/// A learned edit on a clip. See the module header.
#[derive(Clone, Debug)]
pub struct ByExample {
    /// The edit.
    pub edit: Arc<ExampleEdit>,
    /// How much of it, 0 (nothing) to 1.5; 1 is what was taught.
    pub amount: f64,
    /// Whether what stands keeps standing.
    pub contacts: Contacts,
    /// The body that the result is on, if that is another than the motion's.
    pub onto: Option<Onto>,
}

/// What an edit did to a clip.
#[derive(Clone, Debug)]
pub struct Applied {
    /// The result, at the times of the source.
    pub untimed: Clip,
    /// The result in its own time.
    pub edited: Edited,
    /// What the model said.
    pub answer: Answer,
    /// Frames in which a joint limit held something back.
    pub limited: usize,
    /// Joints of the edit that the skeleton cannot do as they were taught: welded, or hinges.
    pub lost: Vec<String>,
    /// How the contacts were kept, and how far each then misses its place; `None` where they are free.
    pub kept: Option<(Kept, Vec<Miss>)>,
}

impl ByExample {
    /// The whole edit, contacts as its options say.
    pub fn new(edit: Arc<ExampleEdit>) -> Self {
        let contacts = edit.options.contacts;
        Self { edit, amount: 1.0, contacts, onto: None }
    }

    /// Applies the edit to a place of a motion, and says what it did.
    ///
    /// # Errors
    /// A clip of another rig, an amount out of range, predicted times that are no map.
    pub fn run(&self, motion: &Motion, at: &ClipPlace) -> Result<Applied, ExampleError> {
        if !(0.0..=1.5).contains(&self.amount) {
            let (what, allowed) = ("`amount`", "0 to 1.5");
            return Err(ExampleError::Setting { what, value: self.amount, allowed });
        }
        // what is done is told by the source, and done on the body that is asked for
        let own = Rig::find(&self.edit.rig, &motion.clip.skeleton)?;
        let answer = self.edit.answer_of(&own, motion.seen.as_ref().unwrap_or(&motion.clip))?;
        let placed = self.onto.as_ref().map(|body| body.place(motion)).transpose()?;
        let motion = placed.as_ref().unwrap_or(motion);
        let clip = &motion.clip;
        let rig = if placed.is_some() { Rig::find(&self.edit.rig, &clip.skeleton)? } else { own };
        let mut d = answer.differences.clone();
        for f in 0..d.nrows() {
            d.row_mut(f).scale_mut(self.amount * window(at, clip, f));
        }
        let allowed = allowed(&rig, at);
        let mut untimed = outputs::add(&rig, clip, &d, &allowed, &clip.skeleton, rig.size_m);
        let kept = match self.contacts {
            Contacts::Free => None,
            Contacts::Keep => {
                let blended = Blended { rig: &rig, clip: &untimed, differences: &d, allowed: &allowed };
                let (clip, kept) = contacts::keep(motion, &blended, &answer.form, (at.from_s, at.to_s));
                untimed = clip;
                Some(kept)
            }
        };
        let limited = keep_limits(clip, &mut untimed);
        let times = if allowed.time { times(&rig, &d, clip)? } else { TimeMap::identity() };
        let plan = kept.as_ref().map_or(&motion.contacts, |k| &k.plan);
        let edited = Edited { clip: times.retime(&untimed), contacts: plan.retimed(&times), times };
        let lost = lost(&rig, &allowed);
        let kept = kept.map(|kept| {
            let misses = kept.misses(&untimed);
            (kept, misses)
        });
        Ok(Applied { untimed, edited, answer, limited, lost, kept })
    }
}

impl ClipEdit for ByExample {
    fn name(&self) -> &'static str {
        "by example"
    }

    fn change(&self, motion: &Motion, at: &ClipPlace, log: &mut EditLog) -> Result<Edited, EditError> {
        let done = self.run(motion, at)?;
        let frames = done.answer.kept.len();
        let new = done.answer.kept.iter().filter(|k| **k < 0.5).count();
        if new > 0 {
            log.note(format!(
                "{:.0} % of the frames are unlike the examples: the edit gives way to the source there",
                100.0 * new as f64 / frames as f64
            ));
        }
        if done.limited > 0 {
            log.note(format!("joint limits hold the edit back in {} of {frames} frames", done.limited));
        }
        if !done.lost.is_empty() {
            log.note(format!("joints that cannot do all that was taught: {}", done.lost.join(", ")));
        }
        if let Some((kept, misses)) = &done.kept {
            kept.notes(misses).into_iter().for_each(|note| log.note(note));
        }
        Ok(done.edited)
    }
}

/// Share of the edit at a frame: 1 inside the span, fading at those of its ends that are inside the clip.
fn window(at: &ClipPlace, clip: &Clip, frame: usize) -> f64 {
    let t = frame as f64 / clip.rate_hz;
    let half = 0.5 / clip.rate_hz;
    let blend = BLEND_S.min(0.5 * (at.to_s - at.from_s));
    let ramp = |into: f64| motion::smoothstep(into / blend);
    let rise = if at.from_s > half { ramp(t - at.from_s) } else { 1.0 };
    let fall = if at.to_s < clip.duration_s() - half { ramp(at.to_s - t) } else { 1.0 };
    rise.min(fall)
}

/// What the place allows to change.
fn allowed(rig: &Rig, at: &ClipPlace) -> Allowed {
    let s = rig.skeleton();
    let may = |link: usize| Dof::of_link(s, link).is_some_and(|dof| at.allows(dof));
    let coordinate = |k: usize| at.allows(Dof::Coordinate(0, k));
    Allowed {
        joints: rig.joints().iter().map(|(link, _)| may(*link)).collect(),
        tilt: may(0),
        height: coordinate(1),
        steps: may(0) && coordinate(0) && coordinate(2),
        time: at.parts.is_empty(),
    }
}

/// Joints that may move but cannot do what balls were taught.
fn lost(rig: &Rig, allowed: &Allowed) -> Vec<String> {
    let links = rig.skeleton().links();
    rig.joints()
        .iter()
        .zip(&allowed.joints)
        .filter(|((link, moves), may)| {
            let joint = links[*link].joint;
            **may && (matches!(joint, Joint::Revolute(_)) && *moves == Moves::Ball)
        })
        .map(|((link, _), _)| links[*link].name.clone())
        .collect()
}

/// Keeps joint limits in every frame in which the source keeps them; returns in how many something was held back.
fn keep_limits(source: &Clip, edited: &mut Clip) -> usize {
    let s = edited.skeleton.clone();
    if s.links().iter().all(|l| l.limits.is_none()) {
        return 0;
    }
    let mut held = 0;
    for f in 0..edited.frames() {
        let mut own = source.pose(f).to_vec();
        if edited.pose(f) != &own[..] && !s.clamp_to_limits(&mut own) && s.clamp_to_limits(edited.pose_mut(f))
        {
            held += 1;
        }
    }
    held
}

/// The map of time of the predicted differences.
fn times(rig: &Rig, d: &nalgebra::DMatrix<f64>, clip: &Clip) -> Result<TimeMap, ExampleError> {
    let column = outputs::time_column(rig);
    let bounds = (LEAST_SLOPE * 2.0).ln()..(MOST_SLOPE / 2.0).ln();
    let at = |f: usize| d[(f, column)].clamp(bounds.start, bounds.end);
    if (0..d.nrows()).all(|f| at(f) == 0.0) || d.nrows() < 2 {
        return Ok(TimeMap::identity());
    }
    let step_s = 1.0 / clip.rate_hz;
    let elapsed = outputs::elapsed((0..d.nrows()).map(at), step_s);
    let stride = (ANCHORS_S * clip.rate_hz).round().max(1.0) as usize;
    let last = d.nrows() - 1;
    let mut frames: Vec<usize> = (0..last).step_by(stride).collect();
    if frames.len() > 1 && last - frames[frames.len() - 1] < stride.div_ceil(2) {
        frames.pop();
    }
    frames.push(last);
    let anchors: Vec<(f64, f64)> = frames.iter().map(|&f| (f as f64 * step_s, elapsed[f])).collect();
    Ok(TimeMap::with_ends(&anchors, [End::Free; 2])?)
}
