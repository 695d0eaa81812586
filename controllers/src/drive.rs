//! Drives: stiffness, damping and rest of one joint, the folded form of an antagonistic pair.
//!
//! Two springs with set points `lo < hi` and gains `k_lo`, `k_hi` are one spring of stiffness
//! `K = k_lo + k_hi` resting at `(k_lo lo + k_hi hi) / K`: the torque is `K (rest − θ) − k_d θ̇`.
//!
//! A ball is the same in exponential coordinates about its target R*: with δ = log(R R*ᵀ) the springs have
//! the potential ½ K |δ − s|², the shift s = −load/K being what the load adds to the rest. The torque is
//! `−K δ + J(δ)⁻ᵀ K s − k_d ω`, J the left Jacobian. At R* it balances the load and its stiffness is K in
//! every direction; a spring to the rest itself, K log(exp(s) R* Rᵀ), would keep K only along s and
//! K (|s|/2) cot(|s|/2) across it. Torques along the joint's zero frame.

use dynamics::{Model, MovingBody};
use motion::rotation::{log, log_moment, slerp};
use motion::skeleton::{quat_at, vec_at};
use motion::{Joint, Quat, Vec3};

/// Where a joint would rest without load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rest {
    /// Angle of a hinge (rad) or distance of a slide (m).
    Scalar(f64),
    /// A ball.
    Ball {
        /// R*: the rotation it rests at under its load.
        target: Quat,
        /// s: where it would rest without, from R* in exponential coordinates, rad.
        shift: Vec3,
    },
    /// The joint is not actuated: a free root, a weld.
    None,
}

/// Where the joint of a moving body is in the pose `q`.
pub fn rest_of(model: &Model, body: usize, q: &[f64]) -> Rest {
    let b = &model.bodies[body];
    match b.joint {
        Joint::Revolute(_) | Joint::Prismatic(_) => Rest::Scalar(q[b.q_at]),
        Joint::Spherical => Rest::ball(quat_at(q, b.q_at)),
        Joint::Free | Joint::Fixed => Rest::None,
    }
}

impl Rest {
    /// A ball that carries no load.
    pub fn ball(target: Quat) -> Self {
        Self::Ball { target, shift: Vec3::zeros() }
    }

    /// Rest between `self` and `other` at the fraction `s`: linear, or slerp.
    pub fn blend(&self, other: &Rest, s: f64) -> Rest {
        match (self, other) {
            (Rest::Scalar(a), Rest::Scalar(b)) => Rest::Scalar(a + (b - a) * s),
            (Rest::Ball { target: a, shift: from }, Rest::Ball { target: b, shift: to }) => {
                Rest::Ball { target: slerp(a, b, s), shift: from + (to - from) * s }
            }
            _ => *other,
        }
    }
}

/// One joint's spring and damper for one step. See the module header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Stiffness K, N·m/rad (N/m for slides).
    pub stiffness: f64,
    /// Damping k_d, N·m·s/rad (N·s/m for slides).
    pub damping: f64,
    /// Unloaded rest.
    pub rest: Rest,
}

impl Drive {
    /// A joint without muscles.
    pub const NONE: Self = Self { stiffness: 0.0, damping: 0.0, rest: Rest::None };

    /// Drive between `self` and `other` at the fraction `s`: stiffness, damping and rest.
    pub fn blend(&self, other: &Self, s: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * s;
        Self {
            stiffness: mix(self.stiffness, other.stiffness),
            damping: mix(self.damping, other.damping),
            rest: self.rest.blend(&other.rest, s),
        }
    }

    /// How far a ball at `now` is from where its springs pull it, as rotation vector along the zero frame:
    /// their torque over K, rad.
    pub fn pull(&self, now: &Quat) -> Vec3 {
        let Rest::Ball { target, shift } = &self.rest else { return Vec3::zeros() };
        let delta = log(&(now * target.inverse()));
        log_moment(&delta, shift) - delta
    }

    /// Torque of the pair on the joint of body `b` at the pose `q` and velocity `v` of the whole model (N·m; for slides
    /// the force along the axis in `.x`). For hinges the torque about the axis is in `.x`, for balls it is a vector along
    /// the zero frame.
    pub fn torque(&self, b: &MovingBody, q: &[f64], v: &[f64]) -> Vec3 {
        match (b.joint, self.rest) {
            (Joint::Revolute(_) | Joint::Prismatic(_), Rest::Scalar(rest)) => {
                Vec3::x() * (self.stiffness * (rest - q[b.q_at]) - self.damping * v[b.v_at])
            }
            (Joint::Spherical, Rest::Ball { .. }) => {
                self.pull(&quat_at(q, b.q_at)) * self.stiffness - vec_at(v, b.v_at) * self.damping
            }
            _ => Vec3::zeros(),
        }
    }
}
