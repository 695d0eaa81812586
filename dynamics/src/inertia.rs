//! Inertia of the whole body: centre of mass, momentum and its rate, energy, gravity stiffness.
//!
//! In: a [`Model`] and its [`State`] at (q, v). Out: what the body is and has as a whole, along world
//! axes. Spatial momentum is the pair (linear, angular about a point): Featherstone 2008, §2.13, summed over
//! bodies; about the centre of mass it is the centroidal momentum. The mass matrix is in
//! [`crate::crba`].

use motion::Vec3;
use nalgebra::{DMatrix, Matrix3};

use crate::model::{Model, State, for_each_axis};
use bodies::mass::{fuse, point_inertia};

/// Linear and angular momentum with the point they belong to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Momentum {
    /// Centre of mass, world, m.
    pub com: Vec3,
    /// Linear momentum, N·s.
    pub linear: Vec3,
    /// Angular momentum about the centre of mass, N·m·s.
    pub angular: Vec3,
}

impl Momentum {
    /// Angular momentum about a point of the world, N·m·s: `L_o = L_c + (c − o) × P`.
    pub fn about(&self, point: &Vec3) -> Vec3 {
        self.angular + (self.com - point).cross(&self.linear)
    }
}

/// Rate of change of the momentum: the sum of all outside forces and moments, gravity included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentumRate {
    /// Centre of mass, world, m.
    pub com: Vec3,
    /// Rate of linear momentum, N.
    pub linear: Vec3,
    /// Rate of angular momentum about the centre of mass, N·m.
    pub angular: Vec3,
}

impl MomentumRate {
    /// Rate of angular momentum about a fixed point of the world, N·m.
    pub fn about(&self, point: &Vec3) -> Vec3 {
        self.angular + (self.com - point).cross(&self.linear)
    }
}

impl State {
    /// Mass, centre of mass and inertia (about it, world axes) of each body with all it carries.
    pub fn composites(&mut self, model: &Model) -> &[(f64, Vec3, Matrix3<f64>)] {
        self.update_composites(model);
        &self.composite
    }

    fn update_composites(&mut self, model: &Model) {
        for (i, b) in model.bodies.iter().enumerate() {
            self.composite[i] = (b.mass, self.bodies[i].com, self.bodies[i].inertia);
        }
        for i in (1..model.bodies.len()).rev() {
            if let Some(p) = model.bodies[i].parent {
                self.composite[p] = fuse(self.composite[p], self.composite[i]);
            }
        }
    }

    /// Centre of mass of the whole body, world, m.
    pub fn com(&self, model: &Model) -> Vec3 {
        let sum: Vec3 = model.bodies.iter().zip(&self.bodies).map(|(b, s)| s.com * b.mass).sum();
        sum / model.mass
    }

    /// Momentum of the whole body.
    pub fn momentum(&self, model: &Model) -> Momentum {
        let com = self.com(model);
        let (mut linear, mut angular) = (Vec3::zeros(), Vec3::zeros());
        for (i, b) in model.bodies.iter().enumerate() {
            let s = &self.bodies[i];
            let p = self.com_velocity(i) * b.mass;
            linear += p;
            angular += s.inertia * s.omega + (s.com - com).cross(&p);
        }
        Momentum { com, linear, angular }
    }

    /// Rate of the momentum when the velocity changes at `vd` (`nv`): linear, and centroidal angular.
    ///
    /// Newton's and Euler's equations summed over the bodies; no gravity enters, only kinematics.
    pub fn momentum_rate(&mut self, model: &Model, v: &[f64], vd: &[f64]) -> MomentumRate {
        self.accelerate(model, v, Some(vd), Vec3::zeros());
        let com = self.com(model);
        let (mut linear, mut angular) = (Vec3::zeros(), Vec3::zeros());
        for (s, f) in self.bodies.iter().zip(&self.flow) {
            linear += f.force;
            angular += f.moment + (s.origin() - com).cross(&f.force);
        }
        MomentumRate { com, linear, angular }
    }

    /// Kinetic and potential energy, J; the potential is zero for masses at the world's origin.
    pub fn energy(&self, model: &Model) -> (f64, f64) {
        let (mut kinetic, mut potential) = (0.0, 0.0);
        for (i, b) in model.bodies.iter().enumerate() {
            let s = &self.bodies[i];
            kinetic += 0.5 * b.mass * self.com_velocity(i).norm_squared()
                + 0.5 * s.omega.dot(&(s.inertia * s.omega));
            potential -= b.mass * model.gravity.dot(&s.com);
        }
        (kinetic, potential)
    }

    /// Second derivative of the gravity potential, ∂²V/∂q² (`nv × nv`, N·m/rad), by the joint axes.
    ///
    /// Entry (i, j), j outboard of i: m g·(aᵢ × (aⱼ × (c − pⱼ))) with the mass m and centre c of all
    /// that axis j carries; negative on the diagonal where gravity topples. Axes of one ball joint do
    /// not commute: the symmetric part is taken, which is the Hessian in exponential coordinates.
    pub fn gravity_stiffness(&mut self, model: &Model, h: &mut DMatrix<f64>) {
        h.fill(0.0);
        self.update_composites(model);
        for (j, bj) in model.bodies.iter().enumerate() {
            let (mass, com, _) = self.composite[j];
            let sj = &self.bodies[j];
            let arm = com - sj.world.translation.vector;
            for_each_axis(bj, &sj.zero, |l, linear_j, angular_j| {
                let moved = linear_j + angular_j.cross(&arm);
                let mut up = Some(j);
                while let Some(i) = up {
                    let si = &self.bodies[i];
                    for_each_axis(&model.bodies[i], &si.zero, |k, _, angular_i| {
                        let value = if i == j {
                            // within one joint the linear axes are fixed in its zero frame: its rotation turns the arm, not them
                            let (turned, other) = (angular_j.cross(&arm), angular_i.cross(&arm));
                            let sum = angular_i.cross(&turned) + angular_j.cross(&other);
                            -0.5 * mass * model.gravity.dot(&sum)
                        } else {
                            -mass * model.gravity.dot(&angular_i.cross(&moved))
                        };
                        h[(k, l)] = value;
                        h[(l, k)] = value;
                    });
                    up = model.bodies[i].parent;
                }
            });
        }
    }

    /// Inertia about each rotation axis of everything *inboard* of it: the whole body less what the
    /// axis carries, about the axis (`nv`, kg·m²); zero for sliding axes.
    ///
    /// What a planted foot moves when its ankle turns.
    pub fn inboard_inertia(&mut self, model: &Model, out: &mut [f64]) {
        self.update_composites(model);
        out.fill(0.0);
        for (i, b) in model.bodies.iter().enumerate() {
            let s = &self.bodies[i];
            let origin = s.world.translation.vector;
            let about =
                |(mass, com, inertia): (f64, Vec3, Matrix3<f64>)| inertia + point_inertia(mass, com - origin);
            let rest = about(self.composite[0]) - about(self.composite[i]);
            for_each_axis(b, &s.zero, |k, _, angular| out[k] = angular.dot(&(rest * angular)));
        }
    }
}
