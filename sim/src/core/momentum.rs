//! Momentum: what the outside forces make of it, and the correction that a substep needs to agree.
//!
//! In: the body before and after a substep, the impulses that acted. Out: the momentum that is missing, and the change of the root's
//! velocity that supplies it.
//!
//! A step in joint coordinates takes the inertia of the pose it starts from, `M(q₀) (v₁ − v₀)`, and is judged by that of the pose it ends
//! in, `M(q₁) v₁`: the difference is momentum that nothing outside gave, of second order in the step while motion is smooth and of first
//! order at impacts. Here the law is exact instead. With P the linear momentum and L the angular momentum about a fixed point o,
//! `P₁ = P₀ + m g dt + Σ λ` and `L₁ = L₀ + (c₀ − o) × m g dt + Σ (p − o) × λ`: gravity at the centre of mass before the substep, contacts at
//! their points before it. The correction is an outside impulse on the root, counted in the [`Ledger`](crate::Ledger).

use dynamics::{Model, State};
use motion::Vec3;
use nalgebra::Matrix3;

use crate::Impulse;

/// The body as one: centre of mass, momentum, energy.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whole {
    /// Centre of mass, world, m.
    pub com: Vec3,
    /// Linear momentum, N·s.
    pub linear: Vec3,
    /// Angular momentum about the centre of mass, N·m·s.
    pub angular: Vec3,
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Inertia about the centre of mass, world axes, kg·m².
    inertia: Matrix3<f64>,
}

/// How the body moves as one under impulses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rigid {
    mass: f64,
    /// Inverse of the inertia about the centre of mass, world axes, 1/(kg·m²).
    inverse: Matrix3<f64>,
}

impl Rigid {
    /// Change of velocity when an impulse, given about the centre of mass, moves the body as one: of the centre of mass (m/s) and
    /// angular (rad/s).
    pub fn motion(&self, impulse: &Impulse) -> (Vec3, Vec3) {
        (impulse.linear / self.mass, self.inverse * impulse.angular)
    }
}

#[inline(always)]
fn add(a: [f64; 6], b: [f64; 6]) -> [f64; 6] {
    std::array::from_fn(|k| a[k] + b[k])
}

/// xx, yy, zz, xy, xz, yz of `a bᵀ`, symmetric where a is along b.
#[inline(always)]
fn squares(a: &Vec3, b: &Vec3) -> [f64; 6] {
    [a.x * b.x, a.y * b.y, a.z * b.z, a.x * b.y, a.x * b.z, a.y * b.z]
}

impl Whole {
    /// Of the poses and velocities of `state`.
    pub fn of(model: &Model, state: &State) -> Self {
        // about the origin of the root, which is near: little is lost to cancellation
        let about = state.bodies[0].origin();
        let (mut first, mut linear, mut angular) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
        let mut kinetic = 0.0;
        // xx, yy, zz, xy, xz, yz
        let (mut inertia, mut spread) = ([0.0; 6], [0.0; 6]);
        for (b, s) in model.bodies.iter().zip(&state.bodies) {
            let velocity = s.velocity + s.omega.cross(&(s.com - s.origin()));
            let (p, spin) = (velocity * b.mass, s.inertia * s.omega);
            let arm = s.com - about;
            let weighed = arm * b.mass;
            first += weighed;
            linear += p;
            angular += spin + arm.cross(&p);
            kinetic += 0.5 * (velocity.dot(&p) + s.omega.dot(&spin));
            let i = s.inertia.as_slice();
            inertia = add(inertia, [i[0], i[4], i[8], i[1], i[2], i[5]]);
            spread = add(spread, squares(&weighed, &arm));
        }
        let away = first / model.mass;
        let whole = squares(&away, &first);
        let [x, y, z, xy, xz, yz] = std::array::from_fn(|k| spread[k] - whole[k]);
        let [ix, iy, iz, ixy, ixz, iyz] = inertia;
        let (xy, xz, yz) = (ixy - xy, ixz - xz, iyz - yz);
        let inertia = Matrix3::new(ix + y + z, xy, xz, xy, iy + x + z, yz, xz, yz, iz + x + y);
        let angular = angular - away.cross(&linear);
        Self { com: about + away, linear, angular, kinetic, inertia }
    }

    /// How it moves as one under impulses.
    pub fn rigid(&self, mass: f64) -> Rigid {
        // a body without inertia about some axis has no angular momentum about it either
        Rigid { mass, inverse: self.inertia.try_inverse().unwrap_or_default() }
    }

    /// Angular momentum about a fixed point, N·m·s.
    pub fn about(&self, point: &Vec3) -> Vec3 {
        self.angular + (self.com - point).cross(&self.linear)
    }
}
