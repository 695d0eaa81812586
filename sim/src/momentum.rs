//! Momentum: what the integration of a step loses is given back, so that gravity, contacts and wrenches explain it.
//!
//! The engine takes the rates at which joints turn each other (J̇ v) from before its solver. Where the solver changes
//! velocities by much, at an impact, the pose then moves with rates nobody paid for: a limp human that hits the
//! floor gains up to three times its weight for a step, whatever the step's length. The error of a step is known,
//! for a free body
//!
//! ```text
//! e = P(q', v') − P(q, v) − dt (m g + Σ contacts + Σ wrenches)
//! ```
//!
//! and is taken from all of the body alike, which turns nothing and bends nothing: v' ← v' − e/m. Standing it is
//! some 10⁻⁵ m/s.
//!
//! In: a [`World`] around a step. Out: its velocity after the step.

use motion::Joint;
use motion::Vec3;

use crate::world::World;

impl World {
    /// Whether nothing but forces moves the body, and joints make up its momentum.
    fn is_free(&self) -> bool {
        matches!(self.model.bodies[0].joint, Joint::Free) && !self.settings.pinned && self.any_joint.is_some()
    }

    /// Linear momentum, N·s.
    fn linear_momentum(&mut self) -> Vec3 {
        self.state.update(&self.model, &self.q, &self.v);
        self.state.momentum(&self.model).linear
    }

    /// Notes the momentum that the next step is to bring about by all but contacts, N·s.
    pub(crate) fn expect_momentum(&mut self) {
        if self.is_free() {
            let dt = 1.0 / self.settings.rate_hz;
            let outside = self.model.gravity * self.model.mass + self.pushed;
            self.expected = self.linear_momentum() + outside * dt;
        }
        self.pushed = Vec3::zeros();
    }

    /// Gives back what the step just taken lost.
    pub(crate) fn give_back_momentum(&mut self) {
        if !self.is_free() {
            return;
        }
        let contacts = self.contact_sum() / self.settings.rate_hz;
        let lost = self.expected + contacts - self.linear_momentum();
        let change = lost / self.model.mass;
        let at = self.model.bodies[0].v_at;
        let Some((mb, _)) = self.any_joint.and_then(|any| self.physics.multibody_joints.get_mut(any)) else {
            return;
        };
        let mut velocity = mb.generalized_velocity_mut();
        for k in 0..3 {
            velocity[k] += change[k];
            self.v[at + k] += change[k];
        }
    }
}
