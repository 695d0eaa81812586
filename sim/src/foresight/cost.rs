//! Cost of a state that a rollout came to: how far it is from what is asked, in units of what is tolerable.
//!
//! In: a core after a step, what is asked in that row. Out: a number without unit, the sum of squares of differences over their scales. The
//! scales are those of a human whose centre of mass is 1 m over its feet; lengths go with that height h, velocities with √h, momenta with
//! m h √h, so that a small body costs what a large one does in the same pose.
//!
//! *Feet go where the body falls.* The capture point c + ċ/ω₀, ω₀ = √(g/h), is the part of the motion that runs away. A foot is measured not from
//! the place asked for, but from there moved by as much as the capture point has strayed: who is pushed to the left steps to the left. With
//! feet held to their places a walk falls to the side within two seconds, at any number of rollouts that is affordable.
//!
//! *Feet that stand by the plan are on the ground*, at the height asked for: legs that the motion bends at a landing reach for a ground that comes
//! early or late. *Impacts* are forces beyond those that the motion asks for at that moment.

use dynamics::Model;
use motion::rotation::log;
use motion::skeleton::quat_at;
use motion::{Joint, Vec3};

use super::ahead::Rows;
use super::channels::Channel;
use super::spline::Knot;
use crate::core::Core;
use crate::{ContactForce, Engine};

/// Scales of the terms: what costs 1. See the module header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Centre of mass, m.
    pub com_m: f64,
    /// Its velocity, m/s.
    pub velocity_m_s: f64,
    /// Capture point along the ground, m.
    pub capture_m: f64,
    /// Angular momentum about the centre of mass, N·m·s for 70 kg.
    pub spin_nms: f64,
    /// Turn of the root, rad.
    pub root_rad: f64,
    /// RMS over the joints of how far they are from their pose, rad.
    pub pose_rad: f64,
    /// Places of feet, m.
    pub feet_m: f64,
    /// Height of a foot while it stands by the plan, m.
    pub stand_m: f64,
    /// Vertical force beyond an impact's beginning, parts of the weight.
    pub impact: f64,
    /// Vertical force at which an impact begins, over the largest that is asked for around that time.
    pub soft: f64,
    /// Offsets, in their deviations.
    pub offset: f64,
    /// Change of offsets per window, in their deviations.
    pub change: f64,
}

impl Default for Scales {
    fn default() -> Self {
        Self {
            com_m: 0.05,
            velocity_m_s: 0.25,
            capture_m: 0.05,
            spin_nms: 6.0,
            root_rad: 0.08,
            pose_rad: 0.1,
            feet_m: 0.07,
            stand_m: 0.015,
            impact: 0.5,
            soft: 1.15,
            offset: 7.0,
            change: 2.5,
        }
    }
}

/// Samples are drawn at most so many times as wide as usual.
const WIDEST: f64 = 2.5;

/// Weights of the terms of a body: one over the square of each scale.
#[derive(Clone, Debug)]
pub(super) struct Cost {
    com: f64,
    velocity: f64,
    capture: f64,
    spin: f64,
    root: f64,
    pose: f64,
    feet: f64,
    stand: f64,
    impact: f64,
    soft: f64,
    offset: f64,
    change: f64,
    /// ω₀, 1/s.
    omega: f64,
    /// m g, N.
    weight: f64,
    /// Bodies with joints.
    joints: Vec<usize>,
    /// Bodies that may stand.
    supports: Vec<usize>,
}

/// Mass for which [`Scales::spin_nms`] is said, kg.
const MASS: f64 = 70.0;

/// What a rollout gathers over the steps of a window.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gathered {
    impact: f64,
    steps: usize,
    /// Vertical force of the last step, N.
    load: f64,
}

/// A square of a distance over its scale, which beyond [`REACH`] scales grows with the distance itself (Huber). Who is thrown off the path comes
/// back step by step: a square would outweigh the capture point, and pull the body over the foot that is to catch it.
fn within_reach(square: f64) -> f64 {
    if square <= REACH * REACH { square } else { REACH * (2.0 * square.sqrt() - REACH) }
}

/// Distance, in its scale, beyond which the centre of mass costs in proportion.
const REACH: f64 = 1.0;

impl Cost {
    /// Of a body whose centre of mass is `height` m over what stands.
    pub(super) fn new(scales: &Scales, model: &Model, height: f64, supports: &[usize]) -> Self {
        let of = |scale: f64| 1.0 / (scale * scale);
        let speed = height.sqrt();
        Self {
            com: of(scales.com_m * height),
            velocity: of(scales.velocity_m_s * speed),
            capture: of(scales.capture_m * height),
            spin: of(scales.spin_nms * model.mass / MASS * height * speed),
            root: of(scales.root_rad),
            pose: of(scales.pose_rad),
            feet: of(scales.feet_m * height),
            stand: of(scales.stand_m * height),
            impact: of(scales.impact),
            soft: scales.soft,
            offset: of(scales.offset),
            change: of(scales.change),
            omega: (model.gravity.norm() / height).sqrt(),
            weight: model.mass * model.gravity.norm(),
            joints: (1..model.bodies.len()).filter(|&b| model.bodies[b].joint.nv() > 0).collect(),
            supports: supports.to_vec(),
        }
    }

    /// Adds a step to what a window gathered; `crest`: the largest vertical force asked for around it, in weights; `contacts` is scratch.
    pub(super) fn gather(
        &self,
        core: &Core,
        crest: f64,
        contacts: &mut Vec<ContactForce>,
        to: &mut Gathered,
    ) {
        contacts.clear();
        core.contacts(contacts);
        let load: f64 = contacts.iter().map(|c| c.force.y.max(0.0)).sum();
        // a step is shorter than the 20 ms over which an impact is felt
        let mean = if to.steps == 0 { load } else { 0.5 * (load + to.load) };
        to.load = load;
        to.impact += (mean / self.weight - self.soft * crest).max(0.0).powi(2);
        to.steps += 1;
    }

    /// How far the capture point has strayed along the ground, m, where the centre of mass is `stray` from what is asked and moves at `rate`
    /// against it.
    fn capture(&self, stray: &Vec3, rate: &Vec3) -> Vec3 {
        let capture = stray + rate / self.omega;
        Vec3::new(capture.x, 0.0, capture.z)
    }

    /// How much wider than usual samples are drawn from the state in `row`: as many times as the capture point has strayed by what costs 1.
    /// Feet are to land where it went; a hip turns a leg there by an angle that grows with the way, whatever its tension is.
    pub(super) fn width(&self, core: &Core, rows: &Rows, row: usize) -> f64 {
        let asked = rows.asked(row);
        let m = core.state().momentum(&core.model);
        let capture = self.capture(&(m.com - asked.com), &(m.linear / core.model.mass - asked.velocity));
        (capture.norm() * self.capture.sqrt()).clamp(1.0, WIDEST)
    }

    /// Cost of the state in `row`.
    pub(super) fn of(&self, core: &Core, rows: &Rows, row: usize) -> f64 {
        let (asked, model, q) = (rows.asked(row), &core.model, core.q());
        let goal = rows.pose(row);
        let m = core.state().momentum(model);
        let stray = m.com - asked.com;
        let rate = m.linear / model.mass - asked.velocity;
        let mut cost = within_reach(stray.norm_squared() * self.com) + rate.norm_squared() * self.velocity;
        let capture = self.capture(&stray, &rate);
        cost += capture.norm_squared() * self.capture;
        cost += (m.angular - asked.spin).norm_squared() * self.spin;
        let root = model.bodies[0].q_at + 3;
        cost += log(&(quat_at(q, root) * rows.root(row).inverse())).norm_squared() * self.root;
        let mut pose = 0.0;
        for &joint in &self.joints {
            let b = &model.bodies[joint];
            pose += match b.joint {
                Joint::Spherical => {
                    log(&(quat_at(q, b.q_at) * quat_at(goal, b.q_at).inverse())).norm_squared()
                }
                _ => (q[b.q_at] - goal[b.q_at]).powi(2),
            };
        }
        cost += pose / self.joints.len().max(1) as f64 * self.pose;
        for (k, (&foot, at)) in self.supports.iter().zip(&asked.supports).enumerate() {
            let off = core.state().bodies[foot].com - at;
            cost += (off - capture).norm_squared() * self.feet;
            if rows.stands(k, row) {
                cost += off.y * off.y * self.stand;
            }
        }
        cost
    }

    /// Cost of what a window gathered, and of the way from knot to knot.
    pub(super) fn of_way(&self, gathered: &Gathered, channels: &[Channel], from: &Knot, to: &Knot) -> f64 {
        let mut cost = gathered.impact / gathered.steps.max(1) as f64 * self.impact;
        for (k, c) in channels.iter().enumerate() {
            let per = 1.0 / (c.deviation * c.deviation);
            let change = to.at[k] - from.at[k];
            cost += to.at[k] * to.at[k] * per * self.offset + change * change * per * self.change;
        }
        cost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Continuous with its slope where the square ends; zero of nothing.
    #[test]
    fn a_distance_out_of_reach_costs_in_proportion() {
        assert_eq!((within_reach(0.0), within_reach(0.5)), (0.0, 0.5));
        let of = |distance: f64| within_reach(distance * distance);
        let h = 1e-6;
        let (before, after) = ((of(REACH) - of(REACH - h)) / h, (of(REACH + h) - of(REACH)) / h);
        assert!((before - after).abs() < 1e-5 && (after - 2.0 * REACH).abs() < 1e-5, "{before} {after}");
        assert!((of(6.0) - of(5.0) - 2.0 * REACH).abs() < 1e-12);
    }
}
