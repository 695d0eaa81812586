//! Contacts kept inside the blend: what stands in the source stands in the edited motion.
//!
//! In: a motion with its [`ContactPlan`], the contact-free blend of an edit, and the quadratic form `A` of that blend
//! ([`Form`]). Out: the motion whose correction C (one row of numbers a frame: of the root and of the joints between it and a contact) minimises
//!
//! ```text
//! E(C) = ½ Σ_d C_dᵀ A C_d + ½ Σ_p C_pᵀ A_p C_p + ½ w Σ_contacts Σ_frames s(t) (|x(C) − x̂|²/ℓ² + (λ/ℓ)² |log(R(C) R̂ᵀ)|²)
//! ```
//!
//! so that the whole is the minimum of the blend's four terms together with the contacts. Numbers d are differences as the blend has
//! them. Numbers p are the root's heading and place, which differences have as steps: `A_p` weighs their first differences by
//! time as the blend weighs those steps (`k |Δp/h|²`), and their second ones as it weighs accelerations of joints
//! (`a |L p|²`; third ones, the blend's own, would widen the band). `ℓ` is the body's size. The root's numbers weigh [`Form::root`] times
//! as much: with 1, as in the blend, an edit of the root alone gives way to the legs, which are many; firmer, the legs follow. Where a leg does
//! not reach its place from the blend's root (from 0.95 of its length on less, from 0.99 on not), the root of that frame weighs as in the blend.
//!
//! *What is asked.* `x̂, R̂` is the point in the source, carried by one rigid motion for the whole contact: a turn about
//! the vertical and a way over the ground, heights kept. So a foot that stands in the source stands, one that rolls from heel to
//! toe goes on rolling, and an edit that changes nothing is kept to the bit; the residue is what the edit adds to
//! the source's own slip. The rigid motion is the mean of what the blend does to the point during the contact. Where
//! no pose reaches it (it is missed by [`FAR_M`] RMS), its way is an unknown too: after a step it moves to where the sum is least. Of a contact that goes
//! on outside the edited span it is what the blend does there. The end of a limb keeps its orientation too (λ = [`LEVER_M`]);
//! links and sites keep their place only.
//!
//! *Coming and going.* `s(t)` is 1 during a contact; before and after it falls over [`BLEND_S`], or half of the gap to the
//! next contact of the point or to the end of the span, by [`FADE`] orders of magnitude: the foot comes down to its place, as in the source. The
//! correction beyond that is what `A` makes of it: a foot on its way through the air is where the blend has it, also below
//! the floor. A correction that has to go within 0.2 s, because the span ends then, costs some jerk. `w` is [`STIFFNESS`] times what `A` says of a slow change ([`SLOW_HZ`]).
//!
//! *Solution*: Gauss–Newton with exact Jacobians of the chain from root to point. Unknowns of a frame are coupled by contacts, and
//! each with itself over time by `A`: [`super::block_band`], O(frames). The share of a step is that at which a parabola through E has its least value: a leg
//! that is pulled straight stiffens, which Gauss–Newton does not know. All in the time
//! of the source; a retimed result takes its contacts along.
//!
//! Units: m, s, rad; corrections in rad and sizes.

use std::ops::Range;

use motion::names::Word;
use motion::rotation::{Quat, Vec3, log, swing_twist};
use motion::{Clip, Contact, ContactPlan, Kinematics, Skeleton, Transform, smoothstep};
use nalgebra::DMatrix;

use super::Rig;
use super::outputs::Allowed;
use super::solve::Form;
use crate::Motion;
use problem::Problem;

mod problem;

/// How firmly contacts are kept, against the blend.
pub const STIFFNESS: f64 = 1e4;
/// Of a change of this frequency, Hz.
pub const SLOW_HZ: f64 = 4.0;
/// Before and after a contact its weight falls over this time, s ...
pub const BLEND_S: f64 = 0.2;
/// ... by so many powers of ten, and then to zero.
pub const FADE: f64 = 5.0;
/// A limb's end that turns by 1 rad counts as much as one that moves by this, m.
pub const LEVER_M: f64 = 0.2;
/// A contact that misses its place by more than this is told of, m.
pub const MISS_M: f64 = 0.002;
/// A place that is missed by more than this after a step, RMS, moves to where it is reached, m.
pub const FAR_M: f64 = 5e-4;
/// Most Gauss–Newton steps.
pub const MOST_STEPS: usize = 12;

/// Whether what stands keeps standing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Contacts {
    /// Points that stand move as the edit has them.
    #[default]
    Free,
    /// They keep standing.
    Keep,
}

impl Word for Contacts {
    const KIND: &'static str = "what becomes of contacts";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Free, "free", "points that stand move as the edit has them"),
        (Self::Keep, "keep", "what stands in the source keeps standing"),
    ];
}

/// A blended edit, before contacts.
#[derive(Clone, Copy, Debug)]
pub struct Blended<'a> {
    /// The rig of the clip.
    pub rig: &'a Rig,
    /// The result: the source with `differences`, as [`super::outputs::add`] gives it.
    pub clip: &'a Clip,
    /// Differences, as they were added.
    pub differences: &'a DMatrix<f64>,
    /// What they may change.
    pub allowed: &'a Allowed,
}

/// How contacts were kept. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// The plan of the result: contacts whose places were known, where they are now.
    pub plan: ContactPlan,
    /// Names of the plan that are no limb, link or site of the skeleton.
    pub unknown: Vec<String>,
    /// Gauss–Newton steps.
    pub steps: usize,
    /// Numbers of a frame's correction.
    pub width: usize,
    /// Whether the last step was small enough.
    pub settled: bool,
    standing: Vec<Standing>,
}

/// How far a contact is from its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Miss {
    /// The point.
    pub point: String,
    /// Start of the contact, s.
    pub from_s: f64,
    /// Root of the mean square distance over its frames, m.
    pub rms_m: f64,
    /// The largest, m.
    pub most_m: f64,
}

/// Where a point is and how its link is turned, world.
type Placed = (Vec3, Quat);

/// One contact, in frames.
#[derive(Clone, Debug, PartialEq)]
struct Standing {
    /// Which contact of the plan.
    contact: usize,
    name: String,
    link: usize,
    at: Vec3,
    turns: bool,
    /// Frames in contact, of the whole clip.
    inside: Range<usize>,
    /// First frame with a weight; the weights, and where the source has the point.
    first: usize,
    weights: Vec<f64>,
    source: Vec<Placed>,
    /// The rigid motion: about the vertical, then over the ground.
    turn: Quat,
    way: Vec3,
    /// Whether it is known from outside the edited span.
    fixed: bool,
}

impl Standing {
    fn frames(&self) -> Range<usize> {
        self.first..self.first + self.weights.len()
    }

    /// Where the point should be in a frame.
    fn goal(&self, f: usize) -> Placed {
        let (x, r) = &self.source[f - self.first];
        (self.turn * x + self.way, self.turn * r)
    }
}

/// Keeps the contacts of a motion (its plan is in the time of its clip) within the span, s. `form` has the frames of the clip.
/// Returns the corrected clip; it is the blended one, to the bit, where there is nothing to keep.
pub fn keep(motion: &Motion, blended: &Blended<'_>, form: &Form, span_s: (f64, f64)) -> (Clip, Kept) {
    let clip = &motion.clip;
    let frames = frames_of(span_s, clip);
    let (standing, unknown) = standing(motion, blended, &frames);
    let mut kept =
        Kept { plan: motion.contacts.clone(), unknown, steps: 0, width: 0, settled: true, standing };
    let mut out = blended.clip.clone();
    if kept.standing.is_empty() || frames.is_empty() {
        return (out, kept);
    }
    let mut problem = Problem::new(clip, blended, form, frames, std::mem::take(&mut kept.standing));
    kept.width = problem.chain.width;
    if kept.width == 0 {
        kept.standing = problem.standing;
        return (out, kept);
    }
    let mut c = vec![0.0; problem.chain.width * problem.frames.len()];
    (kept.steps, kept.settled) = problem.minimise(&mut c);
    for (row, f) in problem.frames.clone().enumerate() {
        problem.chain.pose(f, problem.row(&c, row), out.pose_mut(f));
    }
    kept.standing = problem.standing;
    kept.plan = moved(&motion.contacts, &kept.standing);
    (out, kept)
}

impl Kept {
    /// How far each contact is from its place in `clip`, the result with whatever was done to it since.
    pub fn misses(&self, clip: &Clip) -> Vec<Miss> {
        let s = &clip.skeleton;
        let mut k = Kinematics::new(s, &s.zero_pose());
        let miss = |one: &Standing| {
            let (mut sum, mut most) = (0.0, 0.0_f64);
            for f in one.inside.clone() {
                k.update(s, clip.pose(f));
                let apart = (k.point(one.link, &one.at) - one.goal(f).0).norm_squared();
                (sum, most) = (sum + apart, most.max(apart));
            }
            let rms_m = (sum / one.inside.len() as f64).sqrt();
            let from_s = one.inside.start as f64 / clip.rate_hz;
            Miss { point: one.name.clone(), from_s, rms_m, most_m: most.sqrt() }
        };
        self.standing.iter().map(miss).collect()
    }

    /// What a reader should know.
    pub fn notes(&self, misses: &[Miss]) -> Vec<String> {
        let mut out = Vec::new();
        if !self.unknown.is_empty() {
            let names = self.unknown.join("`, `");
            out.push(format!("contacts of `{names}` are not kept: no limb, link or site of this skeleton"));
        }
        let far = misses.iter().filter(|m| m.most_m > MISS_M);
        if let Some(worst) = far.clone().max_by(|a, b| a.most_m.total_cmp(&b.most_m)) {
            out.push(format!(
                "{} of {} contacts cannot be kept where they stand; furthest off: `{}` from {:.2} s, by {:.1} mm at most, {:.1} mm RMS",
                far.count(),
                misses.len(),
                worst.point,
                worst.from_s,
                1e3 * worst.most_m,
                1e3 * worst.rms_m,
            ));
        }
        if !self.settled {
            out.push(format!("contacts had not settled after {} steps", self.steps));
        }
        out
    }
}

/// Frames at times inside a span, both ends included.
fn frames_of((from_s, to_s): (f64, f64), clip: &Clip) -> Range<usize> {
    let first = (from_s * clip.rate_hz - 1e-6).ceil().max(0.0) as usize;
    let last = (to_s * clip.rate_hz + 1e-6).floor();
    first..((last + 1.0).max(0.0) as usize).min(clip.frames()).max(first)
}

/// The link of a contact's point, where on it, and whether it keeps its orientation.
fn point(s: &Skeleton, name: &str) -> Option<(usize, Vec3, bool)> {
    let limb = s.limb(name).map(|l| (l.end, Vec3::zeros(), true));
    let link = || s.link(name).map(|l| (l, Vec3::zeros(), false));
    limb.or_else(link).or_else(|| s.site(name).map(|p| (p.link, p.at, false)))
}

/// Contacts with a frame inside the edited ones, and the names that are unknown.
fn standing(motion: &Motion, blended: &Blended<'_>, edited: &Range<usize>) -> (Vec<Standing>, Vec<String>) {
    let (clip, plan) = (&motion.clip, &motion.contacts);
    let (mut out, mut unknown): (Vec<Standing>, Vec<String>) = (Vec::new(), Vec::new());
    for (contact, c) in plan.contacts().iter().enumerate() {
        let Some((link, at, turns)) = point(&clip.skeleton, &c.point) else {
            if !unknown.contains(&c.point) {
                unknown.push(c.point.clone());
            }
            continue;
        };
        let inside = frames_of((c.from_s, c.to_s), clip);
        if inside.start >= edited.end || inside.end <= edited.start || inside.is_empty() {
            continue;
        }
        let (first, weights) = weights(plan, c, clip, edited);
        let trace = |of: &Clip, frames: Range<usize>| trace(of, link, &at, frames);
        let source = trace(clip, first..first + weights.len());
        let mut one = Standing {
            contact,
            name: c.point.clone(),
            link,
            at,
            turns,
            fixed: inside.start < edited.start || inside.end > edited.end,
            inside,
            first,
            weights,
            source,
            turn: Quat::identity(),
            way: Vec3::zeros(),
        };
        let frames = one.inside.clone();
        let known = |f: &usize| !one.fixed || !edited.contains(f);
        let blend = trace(blended.clip, frames.clone());
        let pairs: Vec<_> = frames
            .zip(&blend)
            .filter(|(f, _)| known(f))
            .map(|(f, to)| (one.source[f - first], *to))
            .collect();
        (one.turn, one.way) = rigid(&pairs);
        out.push(one);
    }
    (out, unknown)
}

/// Weights of the frames of a contact and around it, and the first of them.
fn weights(plan: &ContactPlan, c: &Contact, clip: &Clip, edited: &Range<usize>) -> (usize, Vec<f64>) {
    let gap = |other: &Contact| {
        if other.from_s > c.to_s { other.from_s - c.to_s } else { c.from_s - other.to_s }
    };
    let near = |before: bool| {
        plan.of(&c.point)
            .filter(|o| if before { o.to_s < c.from_s } else { o.from_s > c.to_s })
            .map(|o| 0.5 * gap(o))
            .fold(BLEND_S, f64::min)
    };
    // at ends of the span that are inside the clip corrections are zero
    let [from_s, to_s] = [edited.start, edited.end - 1].map(|f| f as f64 / clip.rate_hz);
    let to_end = |gap: f64, inside: bool| if inside && gap > 0.0 { 0.5 * gap } else { BLEND_S };
    let rise = near(true).min(to_end(c.from_s - from_s, edited.start > 0));
    let fall = near(false).min(to_end(to_s - c.to_s, edited.end < clip.frames()));
    let frames = frames_of((c.from_s - rise, c.to_s + fall), clip);
    let weight = |f: usize| {
        let t = f as f64 / clip.rate_hz;
        let outside = ((c.from_s - t) / rise).max((t - c.to_s) / fall).max(0.0);
        if outside < 1e-9 { 1.0 } else { 10.0_f64.powf(-FADE * outside) * (1.0 - smoothstep(outside)) }
    };
    (frames.start, frames.map(weight).collect())
}

/// Where a point is in some frames, and how its link is turned.
fn trace(clip: &Clip, link: usize, at: &Vec3, frames: Range<usize>) -> Vec<Placed> {
    let s = &clip.skeleton;
    frames
        .map(|f| {
            let q = clip.pose(f);
            let up = |i: usize| s.links()[i].parent_from_zero * s.joint_transform(q, i);
            let world = s.ancestors(link).fold(Transform::identity(), |world, i| up(i) * world);
            ((world * nalgebra::Point3::from(*at)).coords, world.rotation)
        })
        .collect()
}

/// The mean turn about the vertical and the mean way over the ground from places to places.
fn rigid(pairs: &[(Placed, Placed)]) -> (Quat, Vec3) {
    let n = pairs.len().max(1) as f64;
    let yaw =
        |(from, to): &((Vec3, Quat), (Vec3, Quat))| swing_twist(&(to.1 * from.1.inverse()), &Vec3::y()).1;
    let Some(first) = pairs.first().map(yaw) else { return (Quat::identity(), Vec3::zeros()) };
    let more = pairs.iter().map(|p| log(&(yaw(p) * first.inverse())).y).sum::<f64>() / n;
    let turn = Quat::from_axis_angle(&Vec3::y_axis(), more) * first;
    let mut way = pairs.iter().map(|(from, to)| to.0 - turn * from.0).sum::<Vec3>() / n;
    way.y = 0.0;
    (turn, way)
}

/// The plan with places where the contacts are kept.
fn moved(plan: &ContactPlan, standing: &[Standing]) -> ContactPlan {
    let mut contacts = plan.contacts().to_vec();
    for one in standing {
        let moved = Transform::from_parts(one.way.into(), one.turn);
        let place = &mut contacts[one.contact].world_from_point;
        *place = place.map(|p| moved * p);
    }
    // times and names are those of a plan
    ContactPlan::new(contacts).unwrap_or_else(|_| plan.clone())
}

#[cfg(test)]
mod tests;
