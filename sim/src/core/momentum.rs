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

/// The body as one: mass, centre of mass, momentum, inertia.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whole {
    /// Centre of mass, world, m.
    pub com: Vec3,
    /// Linear momentum, N·s.
    pub linear: Vec3,
    /// Angular momentum about the centre of mass, N·m·s.
    pub angular: Vec3,
    /// Inertia about the centre of mass, world axes, kg·m².
    pub inertia: Matrix3<f64>,
}

impl Whole {
    /// Of the poses and velocities of `state`.
    pub fn of(model: &Model, state: &State) -> Self {
        let com = state.com(model);
        let (mut linear, mut angular, mut inertia) = (Vec3::zeros(), Vec3::zeros(), Matrix3::zeros());
        let mut spread = Matrix3::zeros();
        for (i, (b, s)) in model.bodies.iter().zip(&state.bodies).enumerate() {
            let p = state.com_velocity(i) * b.mass;
            let arm = s.com - com;
            linear += p;
            angular += s.inertia * s.omega + arm.cross(&p);
            inertia += s.inertia;
            spread += arm * (arm.transpose() * b.mass);
        }
        inertia += Matrix3::from_diagonal_element(spread.trace()) - spread;
        Self { com, linear, angular, inertia }
    }

    /// Change of velocity when an impulse, given about the centre of mass, moves the body as one: of the centre of mass (m/s) and
    /// angular (rad/s).
    pub fn motion(&self, mass: f64, impulse: &Impulse) -> (Vec3, Vec3) {
        // a body without inertia about some axis has no angular momentum about it either
        let spin = self.inertia.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * impulse.angular);
        (impulse.linear / mass, spin)
    }

    /// Angular momentum about a fixed point, N·m·s.
    pub fn about(&self, point: &Vec3) -> Vec3 {
        self.angular + (self.com - point).cross(&self.linear)
    }
}
