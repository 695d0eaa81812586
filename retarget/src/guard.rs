//! What a stage may do to a motion, and what holds it to that.
//!
//! In: the motion before a stage and after it, the stage's [`Bounds`]. Out: a motion within them, and a [`StepReport`] that
//! says how near it came and where the stage was held back.
//!
//! *Bounds.* No joint turns farther from the stage before than a stated angle, the root neither, and its place moves no farther
//! than a stated share of the stature: displacements near their bound saturate smoothly, so that no corner is added, or contacts give way.
//! Speeds and accelerations ([`Pace`]) stay within a stated factor of the fastest that the stage before has within [`NEAR_S`],
//! or of what a body of this size has when it falls: a leg that stood still may start to move. Links are in one another no
//! deeper than they were within [`TOUCH_S`], but for [`TOUCH_M`]; after contact adjustment no deeper than anywhere in the clip, since links
//! are turned apart after it.
//!
//! *Holding back.* Where one of these is exceeded, the stage's displacement fades out around that moment and in again,
//! `q = q₀ ⊕ s(t) (q₁ ⊖ q₀)`, wider from round to round: with s = 0 the motion is the one before, and within all bounds.
//!
//! Units: m, rad, s. Slides count as places, hinges, balls and the root's turn as turns.

use motion::{Clip, Derivatives, Joint, Kinematics, Skeleton};

use crate::Puppet;
use crate::bounds::{Bounds, Step, StepReport, Turned};
use crate::global_transform::stature;
use crate::phase::runs;
use crate::refine::solids::Solids;

/// Time before and after a frame in which the stage before may have been as fast, s.
pub const NEAR_S: f64 = 0.25;
/// Time before and after a frame in which links may have been as deep in one another, s.
pub const TOUCH_S: f64 = 0.1;
/// Depth that links may come deeper into one another, m.
pub const TOUCH_M: f64 = 0.001;
/// Time over which rates are taken, s: a parabola through its frames.
const WINDOW_S: f64 = 1.0 / 30.0;
/// Time around a moment at which a stage is held back at first, and over which it fades, s.
const HELD_S: f64 = 0.03;
const FADE_S: f64 = 0.12;
/// How much wider from round to round.
const WIDER: f64 = 1.6;
/// Rounds until the stage is left out of the clip as a whole.
const ROUNDS: i32 = 12;

/// The fastest turn of a joint or the root, and the fastest way of the root or a slide, in every frame: speeds (rad/s, m/s)
/// and accelerations (rad/s², m/s²).
#[derive(Clone, Debug, PartialEq)]
pub struct Pace {
    /// Of turns.
    pub turn: [Vec<f64>; 2],
    /// Of ways.
    pub way: [Vec<f64>; 2],
}

impl Pace {
    /// Of a clip.
    pub fn of(clip: &Clip) -> Self {
        let (d, nv) = (Derivatives::new(clip, WINDOW_S), clip.skeleton.nv());
        let fastest = |rates: &[f64], turns: bool| -> Vec<f64> {
            let of_frame = |v: &[f64]| {
                let of_dofs = |(at, count): (usize, usize)| length(&v[at..at + count]);
                dofs(&clip.skeleton, turns).map(of_dofs).fold(0.0, f64::max)
            };
            rates.chunks_exact(nv.max(1)).map(of_frame).collect()
        };
        Self {
            turn: [fastest(&d.v, true), fastest(&d.vd, true)],
            way: [fastest(&d.v, false), fastest(&d.vd, false)],
        }
    }
}

/// Length of a vector.
pub(crate) fn length(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// First degree of freedom and number of those of each joint, that turn or that move along.
fn dofs(s: &Skeleton, turns: bool) -> impl Iterator<Item = (usize, usize)> + '_ {
    s.links().iter().enumerate().filter_map(move |(l, link)| {
        let at = s.v_at(l);
        match (link.joint, turns) {
            (Joint::Free, false) | (Joint::Spherical, true) => Some((at, 3)),
            (Joint::Free, true) => Some((at + 3, 3)),
            (Joint::Revolute(_), true) | (Joint::Prismatic(_), false) => Some((at, 1)),
            _ => None,
        }
    })
}

/// A motion that another is compared with.
#[derive(Clone, Debug)]
pub struct Before {
    pace: Pace,
    depth: Vec<f64>,
}

impl Before {
    /// Deepest that links are in one another, m.
    pub fn deepest_m(&self) -> f64 {
        self.depth.iter().copied().fold(0.0, f64::max)
    }
}

/// What stages of one puppet are held to. See the module header.
#[derive(Clone, Debug)]
pub struct Guard<'a> {
    puppet: &'a Puppet,
    solids: Solids,
    stature_m: f64,
    /// Speed and acceleration below which the stage before counts as still: of turns, of ways.
    still: [[f64; 2]; 2],
}

impl<'a> Guard<'a> {
    /// * `accepted`: poses (`nq` each) whose touches are meant
    pub fn new(puppet: &'a Puppet, accepted: &[Vec<f64>], gravity_m_s2: f64) -> Self {
        let stature_m = stature(&puppet.character).max(1e-3);
        let (g, l) = (gravity_m_s2, stature_m);
        // half the rate of a pendulum as long as the body, a seventh of the speed of its fall: 2.2 rad/s, 39 rad/s², 0.33 m/s and
        // half of gravity at half a metre
        let still = [[0.5 * (g / l).sqrt(), 2.0 * g / l], [0.15 * (g * l).sqrt(), 0.5 * g]];
        Self { puppet, solids: Solids::new(puppet, &[], accepted), stature_m, still }
    }

    /// Height of the body at rest, m.
    pub fn stature_m(&self) -> f64 {
        self.stature_m
    }

    /// A motion to compare with.
    pub fn before(&self, clip: &Clip) -> Before {
        Before { pace: Pace::of(clip), depth: self.depths(clip) }
    }

    /// How deep links are in one another in every frame, m.
    pub fn depths(&self, clip: &Clip) -> Vec<f64> {
        let mut k = Kinematics::new(&clip.skeleton, &clip.skeleton.zero_pose());
        let mut found = Vec::new();
        let deepest = |i: usize| {
            k.update(&clip.skeleton, clip.pose(i));
            found.clear();
            self.solids.penetrations(&k, &mut found);
            found.iter().filter(|t| t.second.is_some()).map(|t| t.depth_m).fold(0.0, f64::max)
        };
        (0..clip.frames()).map(deepest).collect()
    }

    /// Farthest speed and acceleration over those that are allowed to be reached, and in which frames one, or a depth, is beyond.
    pub fn exceeded(&self, before: &Before, after: &Clip, bounds: &Bounds) -> ([f64; 2], Vec<bool>) {
        let pace = Pace::of(after);
        let mut wrong = vec![false; after.frames()];
        let mut most = [0.0f64; 2];
        let near = (NEAR_S * after.rate_hz).round() as usize;
        let factors = [bounds.speed, bounds.acceleration];
        let kinds = [(&pace.turn, &before.pace.turn), (&pace.way, &before.pace.way)];
        for ((own, theirs), still) in kinds.into_iter().zip(self.still) {
            for order in 0..2 {
                let reached = around(&theirs[order], near);
                for (i, (x, fast)) in own[order].iter().zip(reached).enumerate() {
                    let factor = x / fast.max(still[order]);
                    most[order] = most[order].max(factor);
                    wrong[i] |= factor > factors[order];
                }
            }
        }
        let near =
            if bounds.deep_elsewhere { after.frames() } else { (TOUCH_S * after.rate_hz).round() as usize };
        let allowed = around(&before.depth, near);
        for (i, (depth, allowed)) in self.depths(after).iter().zip(allowed).enumerate() {
            wrong[i] |= *depth > allowed + TOUCH_M;
        }
        (most, wrong)
    }

    /// The motion after a stage, held to its bounds; the share of the stage that is left in every frame; what is said of it.
    pub fn hold(&self, step: Step, (before, was): (&Clip, &Before), after: Clip, bounds: &Bounds) -> Held {
        let goal = if bounds.saturate { self.saturated(before, after, bounds) } else { after };
        let mut share = vec![1.0; goal.frames()];
        let mut ever = vec![false; goal.frames()];
        let mut out = goal.clone();
        for round in 0..=ROUNDS {
            let (factors, mut wrong) = self.exceeded(was, &out, bounds);
            if !bounds.saturate {
                let beyond = self.beyond(before, &out, bounds);
                wrong.iter_mut().zip(beyond).for_each(|(wrong, beyond)| *wrong |= beyond);
            }
            if !wrong.contains(&true) {
                let report = self.report(step, (before, was), &out, (factors, &share), bounds);
                return Held { clip: out, share, report };
            }
            if round == ROUNDS {
                break;
            }
            let wider = WIDER.powi(round);
            ever.iter_mut().zip(wrong).for_each(|(ever, wrong)| *ever |= wrong);
            share = faded(&ever, [HELD_S * wider, FADE_S * wider].map(|s| s * goal.rate_hz));
            out = blended(before, &goal, &share);
        }
        share.fill(0.0);
        let (factors, _) = self.exceeded(was, before, bounds);
        let report = self.report(step, (before, was), before, (factors, &share), bounds);
        Held { clip: before.clone(), share, report }
    }

    /// In which frames a displacement is beyond its bound.
    pub fn beyond(&self, before: &Clip, after: &Clip, bounds: &Bounds) -> Vec<bool> {
        let s = &after.skeleton;
        let limits = self.limits(s, bounds);
        let mut way = vec![0.0; s.nv()];
        let is = |i: usize| {
            s.difference(before.pose(i), after.pose(i), 1.0, &mut way);
            limits.iter().any(|&(at, count, bound)| length(&way[at..at + count]) > bound)
        };
        (0..after.frames()).map(is).collect()
    }

    /// Every displacement within its bound.
    fn saturated(&self, before: &Clip, mut after: Clip, bounds: &Bounds) -> Clip {
        let s = after.skeleton.clone();
        let limits = self.limits(&s, bounds);
        let mut way = vec![0.0; s.nv()];
        for i in 0..after.frames() {
            s.difference(before.pose(i), after.pose(i), 1.0, &mut way);
            let mut changed = false;
            for &(at, count, bound) in &limits {
                let x = length(&way[at..at + count]);
                // what is far below its bound stays as it is, to the bit
                if x > FREE * bound {
                    let y = if bound > 0.0 { bound * saturate(x / bound) } else { 0.0 };
                    way[at..at + count].iter_mut().for_each(|w| *w *= y / x);
                    changed = true;
                }
            }
            if changed {
                let from = before.pose(i).to_vec();
                after.pose_mut(i).copy_from_slice(&from);
                s.integrate(after.pose_mut(i), &way, 1.0);
            }
        }
        after
    }

    /// First degree of freedom, number, bound of each joint's displacement.
    fn limits(&self, s: &Skeleton, bounds: &Bounds) -> Vec<(usize, usize, f64)> {
        let sways = |at: usize| self.puppet.sways.iter().flat_map(|w| &w.links).any(|&l| s.v_at(l) == at);
        let turns = dofs(s, true).map(|(at, count)| {
            let bound = match at {
                3 => bounds.root_rad,
                at if sways(at) => bounds.swaying_rad,
                _ => bounds.joint_rad,
            };
            (at, count, bound)
        });
        let ways = dofs(s, false).map(|(at, count)| (at, count, bounds.root_share * self.stature_m));
        turns.chain(ways).collect()
    }

    fn report(
        &self,
        step: Step,
        (before, was): (&Clip, &Before),
        after: &Clip,
        (factors, share): ([f64; 2], &[f64]),
        bounds: &Bounds,
    ) -> StepReport {
        let s = &after.skeleton;
        let mut out = StepReport {
            step,
            bounds: *bounds,
            root_bound_m: bounds.root_share * self.stature_m,
            joint: None,
            nearest_bound: 0.0,
            root_m: 0.0,
            root_rad: 0.0,
            speed: factors[0],
            acceleration: factors[1],
            penetration_m: [was.deepest_m(), self.depths(after).into_iter().fold(0.0, f64::max)],
            held_back_s: spans_below_one(share, after.rate_hz),
        };
        let limits = self.limits(s, bounds);
        let mut way = vec![0.0; s.nv()];
        for i in 0..after.frames() {
            s.difference(before.pose(i), after.pose(i), 1.0, &mut way);
            for &(at, count, bound) in &limits {
                let x = length(&way[at..at + count]);
                if bound > 0.0 {
                    out.nearest_bound = out.nearest_bound.max(x / bound);
                }
                match at {
                    0 => out.root_m = out.root_m.max(x),
                    3 => out.root_rad = out.root_rad.max(x),
                    _ if out.joint.as_ref().is_none_or(|j| x > j.rad) && x > 1e-6 => {
                        let link =
                            (0..s.links().len()).find(|&l| s.v_at(l) == at && s.links()[l].joint.nv() > 0);
                        let link = link.map_or_else(String::new, |l| s.links()[l].name.clone());
                        out.joint = Some(Turned { link, rad: x, at_s: i as f64 / after.rate_hz });
                    }
                    _ => {}
                }
            }
        }
        out
    }
}

/// What [`Guard::hold`] gives.
#[derive(Clone, Debug)]
pub struct Held {
    /// The motion, within the bounds.
    pub clip: Clip,
    /// Share of the stage in every frame.
    pub share: Vec<f64>,
    /// What is said of it.
    pub report: StepReport,
}

/// Share of a bound below which a displacement stays as it is.
const FREE: f64 = 0.8;

/// [`FREE`] and less as it is, then smoothly towards 1.
fn saturate(x: f64) -> f64 {
    if x <= FREE { x } else { FREE + (1.0 - FREE) * ((x - FREE) / (1.0 - FREE)).tanh() }
}

/// The largest of a curve within so many frames of each.
pub(crate) fn around(x: &[f64], near: usize) -> Vec<f64> {
    let mut out = Vec::with_capacity(x.len());
    let mut queue = std::collections::VecDeque::new();
    let mut next = 0;
    for i in 0..x.len() {
        while next < x.len() && next <= i + near {
            while queue.back().is_some_and(|&j: &usize| x[j] <= x[next]) {
                queue.pop_back();
            }
            queue.push_back(next);
            next += 1;
        }
        while queue.front().is_some_and(|&j| j + near < i) {
            queue.pop_front();
        }
        out.push(queue.front().map_or(0.0, |&j| x[j]));
    }
    out
}

/// A share that is 0 around the frames that are wrong, fades beside them, and is 1 elsewhere.
///
/// * `reach`: frames held, frames of the fade
pub(crate) fn faded(wrong: &[bool], [held, fading]: [f64; 2]) -> Vec<f64> {
    let frames = wrong.len();
    // two holds whose fades would meet are one, so that no corner is left between
    let mut off = vec![false; frames];
    let (mut last, reach) = (None::<usize>, held.ceil() as usize);
    for i in (0..frames).filter(|&i| wrong[i]) {
        let from = match last {
            Some(j) if (i - j) as f64 <= 2.0 * (held + fading) => j,
            _ => i.saturating_sub(reach),
        };
        off[from..(i + reach + 1).min(frames)].fill(true);
        last = Some(i);
    }
    let mut distance = vec![f64::INFINITY; frames];
    for forth in [true, false] {
        let mut at = f64::INFINITY;
        for k in 0..frames {
            let i = if forth { k } else { frames - 1 - k };
            at = if off[i] { 0.0 } else { at + 1.0 };
            distance[i] = at.min(distance[i]);
        }
    }
    let ease = |x: f64| x * x * x * (10.0 + x * (6.0 * x - 15.0));
    distance.into_iter().map(|d| ease((d / fading.max(1.0)).min(1.0))).collect()
}

/// `q₀ ⊕ s (q₁ ⊖ q₀)` in every frame.
pub(crate) fn blended(before: &Clip, after: &Clip, share: &[f64]) -> Clip {
    let s = &after.skeleton;
    let (mut out, mut way) = (after.clone(), vec![0.0; s.nv()]);
    for (i, &share) in share.iter().enumerate().filter(|(_, share)| **share < 1.0) {
        s.difference(before.pose(i), after.pose(i), 1.0, &mut way);
        way.iter_mut().for_each(|w| *w *= share);
        out.pose_mut(i).copy_from_slice(before.pose(i));
        s.integrate(out.pose_mut(i), &way, 1.0);
    }
    out
}

/// Spans of time in which a share is below 1, s.
fn spans_below_one(share: &[f64], rate_hz: f64) -> Vec<[f64; 2]> {
    let below = runs(0..share.len(), |i| share[i] < 1.0);
    below.into_iter().map(|s| [s.first as f64 / rate_hz, s.last as f64 / rate_hz]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_around_and_the_fade() {
        let x = [0.0, 3.0, 1.0, 0.0, 0.0, 2.0];
        assert_eq!(around(&x, 1), [3.0, 3.0, 3.0, 1.0, 2.0, 2.0]);
        assert_eq!(around(&x, 9), [3.0; 6]);
        let wrong: Vec<bool> = (0..40).map(|i| i == 20).collect();
        let share = faded(&wrong, [2.0, 5.0]);
        assert_eq!(&share[18..23], [0.0; 5]);
        assert!(
            share[17] > 0.0 && share[17] < share[16] && share[13] == 1.0 && share[28] == 1.0,
            "{share:?}"
        );
        // bounds are never left, and small ways stay what they are
        assert_eq!(saturate(0.1), 0.1);
        assert!((0..1000).all(|i| saturate(0.01 * f64::from(i)) <= 1.0));
    }
}
