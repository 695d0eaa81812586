//! Ankle limit: a foot's own centre of pressure stays inside its sole.

use motion::skeleton::{quat_at, vec_at};
use motion::support::{Support, Vec2, ground};

use super::Balance;
use crate::reactive::ControlStep;
use crate::support::{Foot, clamp_inside};
use crate::{Drive, Rest};

impl Balance {
    /// Limits the ankle's torque so that the foot's own centre of pressure stays inside its sole.
    ///
    /// For a foot of little mass under a vertical force F, τ = −r × F ŷ: r_z = τ_x/F, r_x = −τ_z/F, with
    /// r from the ankle to the centre of pressure.
    pub(super) fn limit_ankle(&self, step: &ControlStep<'_>, foot: &Foot, force: f64, drive: &mut Drive) {
        let b = &step.model.bodies[foot.body];
        let (Rest::Ball { .. }, true) = (drive.rest, force > 1.0) else { return };
        let now = quat_at(step.q, b.q_at);
        let omega = vec_at(step.v, b.v_at);
        let torque = drive.pull(&now) * drive.stiffness - omega * drive.damping;
        let zero = self.now.bodies[foot.body].zero;
        let mut world = zero * torque;
        let ankle = ground(&self.now.bodies[foot.body].world.translation.vector);
        let pressure = ankle + Vec2::new(-world.z / force, world.x / force);
        let corners = foot.corners_in_world(step.model, &self.now);
        let inside = clamp_inside(&Support::of(corners.iter()), pressure, self.settings.margin_m);
        if inside == pressure {
            return;
        }
        let r = inside - ankle;
        world.x = r.y * force;
        world.z = -r.x * force;
        let torque = zero.transpose() * world + omega * drive.damping;
        drive.rest = Rest::Ball { target: now, shift: torque / drive.stiffness };
    }
}
