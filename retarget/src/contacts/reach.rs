//! The pose that puts contact points where they have to be and keeps the rest.
//!
//! In: a pose and a goal for each point. Out: the pose that minimises
//!
//! ```text
//! Σ W_d δ_d² + κ Σ |p_c(q) − g_c|² + κ_l Σ |excess over limits|²,   q = q₀ ⊕ δ
//! ```
//!
//! by Gauss–Newton from q₀. One smooth problem with the same weights in every frame: where the goals move
//! smoothly, so does the pose. κ is so large that a goal that can be reached is missed by micrometres. Joints
//! between the root and a contact point give way most easily; the root and all that it carries move where
//! those cannot.
//!
//! The goals of one link fit it, but the legs need not reach them, and live they need not fit. So a point in a phase outweighs
//! one in flight a thousandfold, and beside its phases the weight goes over from one to the other. A point without any phase
//! has no goal. Every point is pushed out of the ground below −[`DEPTH_M`].

use std::sync::Arc;

use motion::{Joint, Kinematics, Skeleton, Vec3};

use super::paths::Span;
use crate::Puppet;
use crate::axes::Axes;
use crate::cholesky;
use crate::limits::way_back;

/// Weight of a goal in a phase against a radian of a leg, 1/m².
const GOAL: f64 = 1e7;
/// Weight of a goal in flight.
const FLIGHT: f64 = 1e4;
/// Weight of the depth below −[`DEPTH_M`].
const FLOOR: f64 = 1e6;
/// Depth from which points are pushed out of the ground, m.
pub const DEPTH_M: f64 = 0.002;
/// Weight of a radian beyond a limit.
const LIMIT: f64 = 1e5;
/// Weight of a radian of a joint that carries no contact point.
const OTHER: f64 = 100.0;
/// Weight of a radian of the root.
const ROOT_TURN: f64 = 20.0;
/// Weight of a leg's length of the root's way.
const ROOT_WAY: f64 = 10.0;
/// Steps before the ground is looked at: by then the goals are nearly reached.
const SETTLE: usize = 2;
/// How much more a held root weighs.
const HELD_ROOT: f64 = 10.0;
/// Most steps.
const STEPS: usize = 30;
/// Steps taken in full.
const HURRY: usize = 10;
/// A step below this, rad or m, is the last.
const STILL: f64 = 1e-8;

/// One point to be put somewhere.
#[derive(Clone, Debug)]
struct Held {
    contact: usize,
    link: usize,
    at: Vec3,
    /// Whether it has any phase; otherwise only the floor holds it.
    everywhere: bool,
    /// Whether the ground pushes it.
    pushed: bool,
}

/// The solver of one puppet, and its memory. See the module header.
#[derive(Clone, Debug)]
pub struct Reach {
    skeleton: Arc<Skeleton>,
    points: Vec<Held>,
    weights: Vec<f64>,
    k: Kinematics,
    axes: Axes,
    normal: Vec<f64>,
    step: Vec<f64>,
    away: Vec<f64>,
}

impl Reach {
    /// A solver for the points of a puppet, of which those with phases are held.
    pub fn new(puppet: &Puppet, spans: &[Vec<Span>]) -> Self {
        let skeleton = &puppet.character.skeleton;
        let axes = Axes::new(skeleton);
        let n = skeleton.nv();
        let points: Vec<Held> = puppet
            .contacts
            .iter()
            .enumerate()
            .map(|(contact, c)| {
                let site = &skeleton.sites()[c.site];
                Held {
                    contact,
                    link: site.link,
                    at: site.at,
                    everywhere: !spans[contact].is_empty(),
                    pushed: false,
                }
            })
            .collect();
        let rest = Kinematics::new(skeleton, &puppet.character.rest);
        let size =
            points.iter().map(|p| (rest.point(p.link, &p.at) - rest.origin(0)).norm()).fold(0.05, f64::max);
        let mut weights = vec![OTHER; n];
        for p in points.iter().filter(|p| p.everywhere) {
            axes.chain[p.link].iter().for_each(|&d| weights[d] = 1.0);
        }
        for (d, w) in weights.iter_mut().enumerate().take(6) {
            *w = if d < 3 { ROOT_WAY / (size * size) } else { ROOT_TURN };
        }
        for (i, link) in skeleton.links().iter().enumerate().skip(1) {
            if let Joint::Prismatic(_) = link.joint {
                weights[skeleton.v_at(i)] /= size * size;
            }
        }
        Self {
            k: rest,
            axes,
            points,
            weights,
            normal: vec![0.0; n * n],
            step: vec![0.0; n],
            away: vec![0.0; n],
            skeleton: skeleton.clone(),
        }
    }

    /// From now on the root stays where `from` has it, as long as the legs can reach.
    pub fn hold_root(&mut self) {
        self.weights[..6].iter_mut().for_each(|w| *w *= HELD_ROOT);
    }

    /// Writes the pose near `from` whose points are at their goals into `q`.
    ///
    /// * `goal`: of each contact point, and how firmly it is held there: 1 in a phase, 0 in flight
    pub fn solve(&mut self, from: &[f64], goal: &dyn Fn(usize) -> (Vec3, f64), q: &mut [f64]) {
        q.copy_from_slice(from);
        let n = self.weights.len();
        self.points.iter_mut().for_each(|p| p.pushed = false);
        for step in 0..STEPS {
            self.k.update(&self.skeleton, q);
            self.axes.update(&self.skeleton, &self.k);
            self.skeleton.difference(from, q, 1.0, &mut self.away);
            self.normal.fill(0.0);
            for d in 0..n {
                self.normal[d * n + d] = self.weights[d];
                self.step[d] = -self.weights[d] * self.away[d];
            }
            for i in 0..self.points.len() {
                let p = &self.points[i];
                let at = self.k.point(p.link, &p.at);
                let (place, firm) = goal(p.contact);
                if p.everywhere {
                    self.pull(i, &at, &(place - at), FLIGHT * (GOAL / FLIGHT).powf(firm));
                }
                // once pushed, always pushed: let go on the way it would swing between the two
                self.points[i].pushed |= step >= SETTLE && at.y < -DEPTH_M && firm < 1.0;
                if self.points[i].pushed {
                    self.lift(i, &at, -DEPTH_M - at.y);
                }
            }
            self.limits(q);
            if !cholesky::solve(&mut self.normal, n, &mut self.step) {
                break;
            }
            let largest = self.step.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            // half a radian at most: farther the linearisation means nothing; and less where limits keep throwing it about
            let share = (0.5 / largest.max(1e-12)).min(if step < HURRY { 1.0 } else { 0.5 });
            self.skeleton.integrate(q, &self.step, share);
            if largest < STILL && step > SETTLE {
                break;
            }
        }
    }

    /// Adds the term of one point.
    fn pull(&mut self, point: usize, at: &Vec3, missing: &Vec3, weight: f64) {
        let n = self.weights.len();
        let chain = &self.axes.chain[self.points[point].link];
        for (a, &i) in chain.iter().enumerate() {
            let c = self.axes.all[i].column(at) * weight;
            self.step[i] += c.dot(missing);
            for &j in &chain[..=a] {
                self.normal[i * n + j] += c.dot(&self.axes.all[j].column(at));
            }
        }
    }

    /// Adds the term of one point's height alone.
    fn lift(&mut self, point: usize, at: &Vec3, missing: f64) {
        let n = self.weights.len();
        let chain = &self.axes.chain[self.points[point].link];
        for (a, &i) in chain.iter().enumerate() {
            let c = self.axes.all[i].column(at).y * FLOOR;
            self.step[i] += c * missing;
            for &j in &chain[..=a] {
                self.normal[i * n + j] += c * self.axes.all[j].column(at).y;
            }
        }
    }

    /// Adds the terms of joints beyond their limits.
    fn limits(&mut self, q: &[f64]) {
        let n = self.weights.len();
        for (link, l) in self.skeleton.links().iter().enumerate() {
            let Some(e) = way_back(&self.skeleton, q, link) else { continue };
            let v = self.skeleton.v_at(link);
            for a in 0..l.joint.nv() {
                self.step[v + a] += LIMIT * e[a];
                for b in 0..=a {
                    self.normal[(v + a) * n + v + b] += LIMIT * e[a] * e[b] / e.norm_squared();
                }
            }
        }
    }
}
