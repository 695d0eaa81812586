//! Inverse dynamics: the recursive Newton–Euler algorithm with outside wrenches.
//!
//! In: a [`Model`], its [`State`] at (q, v), an acceleration, wrenches from outside. Out: generalised
//! forces `τ = M(q) v̇ + C(q, v) v + g(q) − Σ Jᵀ w` (`nv`), or a part of that sum. For a free root the
//! first six entries are the wrench the root would need from nowhere: zero when the outside wrenches
//! explain the motion.
//!
//! `q`, `v`, `v̇`, `τ` have the layout of [`motion::skeleton`]: along the axes of each joint's zero frame,
//! N and N·m; a wrench is along world axes. `v̇` is the rate of the components of `v`: for a free root
//! the acceleration of its origin, not Featherstone's spatial one.
//!
//! Featherstone, Rigid Body Dynamics Algorithms, 2008, §5.3, Table 5.1, written in 3-vectors along world
//! axes about the bodies' own origins: (5.7) velocities, in [`State::update`]; (5.8) accelerations
//! outward; (5.9) the force each body needs; (5.10) forces inward, less the outside wrenches; (5.11)
//! `τ = Sᵀ f`. Gravity enters as an upward acceleration of the base. Nothing here allocates.

use motion::skeleton::vec_at;
use motion::{Joint, Vec3};

use crate::model::{Flow, Model, State};

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
        self.accelerate(model, v, Some(vd), -model.gravity);
        for w in wrenches {
            let body = model.body_of[w.link].0;
            let flow = &mut self.flow[body];
            flow.force -= w.force;
            flow.moment -= w.moment_about(&self.bodies[body].origin());
        }
        self.gather(model, tau);
    }

    /// Forces that keep the velocity constant (`nv`): `c(q, v) = C(q, v) v + g(q)`, Featherstone's C.
    ///
    /// Inverse dynamics of no acceleration and no wrench: Coriolis, centrifugal and gravity terms.
    pub fn bias(&mut self, model: &Model, v: &[f64], tau: &mut [f64]) {
        self.accelerate(model, v, None, -model.gravity);
        self.gather(model, tau);
    }

    /// Coriolis and centrifugal part of [`State::bias`] alone, `C(q, v) v` (`nv`).
    pub fn coriolis(&mut self, model: &Model, v: &[f64], tau: &mut [f64]) {
        self.accelerate(model, v, None, Vec3::zeros());
        self.gather(model, tau);
    }

    /// Forces that hold the pose at rest, `g(q)` (`nv`): the slope of the gravity potential.
    pub fn gravity_load(&mut self, model: &Model, tau: &mut [f64]) {
        for (i, b) in model.bodies.iter().enumerate() {
            let force = model.gravity * -b.mass;
            self.flow[i].force = force;
            self.flow[i].moment = self.bodies[i].to_com.cross(&force);
        }
        self.gather(model, tau);
    }

    /// Accelerations outward from a base that accelerates at `base`, and the force and moment about its
    /// origin that each body alone needs: (5.8), (5.9).
    pub(crate) fn accelerate(&mut self, model: &Model, v: &[f64], vd: Option<&[f64]>, base: Vec3) {
        for (i, b) in model.bodies.iter().enumerate() {
            let s = &self.bodies[i];
            let (v_lin, v_ang) = s.joint_motion(b, v);
            let (mut alpha, mut accel) = match b.parent {
                Some(p) => {
                    let (omega, up) = (&self.bodies[p].omega, &self.flow[p]);
                    let carried = omega.cross(&s.arm) + v_lin * 2.0;
                    (
                        up.alpha + omega.cross(&v_ang),
                        up.accel + up.alpha.cross(&s.arm) + omega.cross(&carried),
                    )
                }
                None => (Vec3::zeros(), base),
            };
            if let Some(vd) = vd {
                let (a_lin, a_ang) = s.joint_motion(b, vd);
                alpha += a_ang;
                accel += a_lin;
            }
            let spin = s.omega.cross(&s.to_com);
            let force = (accel + alpha.cross(&s.to_com) + s.omega.cross(&spin)) * b.mass;
            let moment = s.inertia * alpha + s.omega.cross(&(s.inertia * s.omega)) + s.to_com.cross(&force);
            self.flow[i] = Flow { alpha, accel, force, moment };
        }
    }

    /// Forces inward: each joint's share of what its body and all it carries need, (5.10), (5.11).
    fn gather(&mut self, model: &Model, tau: &mut [f64]) {
        for (i, b) in model.bodies.iter().enumerate().rev() {
            let s = &self.bodies[i];
            let Flow { force, moment, .. } = self.flow[i];
            s.project(b, &force, &moment, tau);
            if let Some(p) = b.parent {
                let up = &mut self.flow[p];
                up.force += force;
                up.moment += moment + s.arm.cross(&force);
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
