//! Inverse dynamics: the recursive Newton–Euler algorithm with outside wrenches.
//!
//! In: a [`Model`], its [`State`] at (q, v), an acceleration, wrenches from outside. Out: generalised
//! forces `τ = M(q) v̇ + c(q, v) − Σ Jᵀ w`. For a free root the first six entries are the wrench the
//! root would need from nowhere: zero when the outside wrenches explain the motion.
//!
//! Featherstone 2008, §5.3, Table 5.1, in world axes: (5.9) accelerations outward, (5.10) forces
//! inward. Gravity enters as an upward acceleration of the base.

use motion::skeleton::vec_at;
use motion::{Joint, Vec3};

use crate::model::{Model, State, joint_motion};

/// A force and a moment that act on a link from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench {
    /// The link.
    pub link: usize,
    /// Where the force acts, world, m.
    pub point: Vec3,
    /// Force, world, N.
    pub force: Vec3,
    /// Moment on top of that of the force, world, N·m.
    pub moment: Vec3,
}

impl Wrench {
    /// Moment about a point of the world, N·m.
    pub fn moment_about(&self, point: &Vec3) -> Vec3 {
        self.moment + (self.point - point).cross(&self.force)
    }
}

/// Sum of wrenches about a point of the world: force (N) and moment (N·m), world axes.
pub fn total_wrench(wrenches: &[Wrench], about: &Vec3) -> (Vec3, Vec3) {
    wrenches.iter().fold((Vec3::zeros(), Vec3::zeros()), |(f, m), w| (f + w.force, m + w.moment_about(about)))
}

impl State {
    /// Generalised forces (`nv`, N or N·m) for the acceleration `vd` (`nv`) under outside wrenches.
    ///
    /// [`State::update`] must have been called for the pose and velocity. `vd` is along the axes of
    /// the joints' zero frames, like `v`; the linear part of a free root is the acceleration of its
    /// origin. O(bodies); does not allocate.
    pub fn inverse_dynamics(
        &mut self,
        model: &Model,
        v: &[f64],
        vd: &[f64],
        wrenches: &[Wrench],
        tau: &mut [f64],
    ) {
        for (i, b) in model.bodies.iter().enumerate() {
            let s = &self.bodies[i];
            let (omega_p, alpha_p, accel_p, origin_p) = match b.parent {
                Some(p) => (
                    self.bodies[p].omega,
                    self.alpha[p],
                    self.accel[p],
                    self.bodies[p].world.translation.vector,
                ),
                None => (Vec3::zeros(), Vec3::zeros(), -model.gravity, Vec3::zeros()),
            };
            let (v_lin, v_ang) = joint_motion(&b.joint, v, b.v_at);
            let (a_lin, a_ang) = joint_motion(&b.joint, vd, b.v_at);
            let arm = s.world.translation.vector - origin_p;
            let spin = s.zero * v_ang;
            let alpha = alpha_p + s.zero * a_ang + omega_p.cross(&spin);
            let accel = accel_p
                + alpha_p.cross(&arm)
                + omega_p.cross(&omega_p.cross(&arm))
                + omega_p.cross(&(s.zero * v_lin)) * 2.0
                + s.zero * a_lin;
            let to_com = s.com - s.world.translation.vector;
            let accel_com = accel + alpha.cross(&to_com) + s.omega.cross(&s.omega.cross(&to_com));
            let force = accel_com * b.mass;
            let moment = s.inertia * alpha + s.omega.cross(&(s.inertia * s.omega));
            self.alpha[i] = alpha;
            self.accel[i] = accel;
            self.force[i] = force;
            self.moment[i] = moment + to_com.cross(&force); // about the body's origin
        }
        for w in wrenches {
            let body = model.body_of[w.link].0;
            let origin = self.bodies[body].world.translation.vector;
            self.force[body] -= w.force;
            self.moment[body] -= w.moment + (w.point - origin).cross(&w.force);
        }
        for (i, b) in model.bodies.iter().enumerate().rev() {
            let (force, moment) = (self.force[i], self.moment[i]);
            let s = &self.bodies[i];
            let at = b.v_at;
            match b.joint {
                Joint::Free => {
                    tau[at..at + 3].copy_from_slice((s.zero.transpose() * force).as_slice());
                    tau[at + 3..at + 6].copy_from_slice((s.zero.transpose() * moment).as_slice());
                }
                Joint::Spherical => {
                    tau[at..at + 3].copy_from_slice((s.zero.transpose() * moment).as_slice());
                }
                Joint::Revolute(axis) => tau[at] = (s.zero * axis).dot(&moment),
                Joint::Prismatic(axis) => tau[at] = (s.zero * axis).dot(&force),
                Joint::Fixed => {}
            }
            if let Some(p) = b.parent {
                let arm = s.world.translation.vector - self.bodies[p].world.translation.vector;
                self.force[p] += force;
                self.moment[p] += moment + arm.cross(&force);
            }
        }
    }

    /// Generalised force of one wrench, `Jᵀ w`, added to `tau` (`nv`).
    pub fn add_wrench(&self, model: &Model, w: &Wrench, tau: &mut [f64]) {
        let mut up = Some(model.body_of[w.link].0);
        while let Some(i) = up {
            let b = &model.bodies[i];
            let s = &self.bodies[i];
            let moment = w.moment + (w.point - s.world.translation.vector).cross(&w.force);
            crate::model::for_each_axis(b, &s.zero, |dof, linear, angular| {
                tau[dof] += linear.dot(&w.force) + angular.dot(&moment);
            });
            up = b.parent;
        }
    }
}

/// A joint's own generalised force: a ball's moment along its zero frame; for hinges and slides the
/// torque or force along the axis, in `.x`; zero for free and welded joints.
pub fn joint_force(joint: &Joint, tau: &[f64], at: usize) -> Vec3 {
    match joint {
        Joint::Spherical => vec_at(tau, at),
        Joint::Revolute(_) | Joint::Prismatic(_) => Vec3::x() * tau[at],
        Joint::Free | Joint::Fixed => Vec3::zeros(),
    }
}
