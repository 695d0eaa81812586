//! How a point of a body moves with the joints: its Jacobian, and what its acceleration is without any of theirs.
//!
//! In: a [`Model`], its [`State`] at (q, v). Out: columns of `J` and `J̇ v` of `ẍ = J v̇ + J̇ v`, along world axes, m and rad.
//! `v` and `v̇` have the layout of [`motion::skeleton`]. (For a skeleton without masses: [`motion::ik::axes`].)
//!
//! Featherstone, Rigid Body Dynamics Algorithms, 2008, §5.3: (5.8) without joint accelerations is J̇ v.

use motion::Vec3;

use crate::model::{Model, State, for_each_axis};

impl State {
    /// Columns of the motion subspace of the joint of `body`, world: calls `f(dof, linear, angular)` for each of its degrees of
    /// freedom, at the body's origin.
    ///
    /// Needs [`State::update_pose`] (or `update`); does not allocate.
    pub fn joint_axes(&self, model: &Model, body: usize, f: impl FnMut(usize, Vec3, Vec3)) {
        for_each_axis(&model.bodies[body], &self.bodies[body].zero, f);
    }

    /// Columns of the Jacobian of `point` (world, m) as it moves with `body`: calls `f(dof, linear, angular)` for every
    /// degree of freedom inboard of it; all others are zero.
    ///
    /// Needs [`State::update_pose`] (or `update`); does not allocate.
    pub fn jacobian(&self, model: &Model, body: usize, point: &Vec3, mut f: impl FnMut(usize, Vec3, Vec3)) {
        let mut up = Some(body);
        while let Some(i) = up {
            let (b, s) = (&model.bodies[i], &self.bodies[i]);
            let arm = point - s.origin();
            for_each_axis(b, &s.zero, |dof, linear, angular| f(dof, linear + angular.cross(&arm), angular));
            up = b.parent;
        }
    }

    /// Accelerations of the bodies' origins (m/s²) and angular ones (rad/s²), world, while no joint accelerates:
    /// calls `f(body, linear, angular)`.
    ///
    /// Needs [`State::update`] at `v`; does not allocate.
    pub fn drifts(&mut self, model: &Model, v: &[f64], mut f: impl FnMut(usize, Vec3, Vec3)) {
        self.accelerate(model, v, None, Vec3::zeros());
        for (i, flow) in self.flow.iter().enumerate() {
            f(i, flow.accel, flow.alpha);
        }
    }
}
