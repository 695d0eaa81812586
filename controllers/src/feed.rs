//! Feed-forward of a standing motion: what the motion asked for needs of the ground, step by step.
//!
//! A body that moves is not in balance over its centre of mass but over the point where the ground must push
//! for that motion: inverse dynamics of the goal leaves a wrench at the free root, `F`, `M`; the ground gives it
//! at its centre of pressure, `p = (M_z, −M_x)/F_y` about the point of the ground under the origin.
//!
//! In: a goal. Out: a [`Feed`] per row. World frame, ground plane `(x, z)`.

use dynamics::{Model, State};
use motion::Vec3;
use motion::skeleton::vec_at;
use motion::support::{Vec2, ground};

use crate::Goal;

/// What a row of the goal needs of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feed {
    /// Force of the ground, N.
    pub force: Vec3,
    /// Centre of pressure less centre of mass, m.
    pub lead: Vec2,
    /// Velocity of the centre of mass, m/s.
    pub rate: Vec2,
}

/// The force (N) and centre of pressure on the ground at height `ground_m` that stand for the root wrench in
/// `tau`; `None` where the ground would have to pull. The kinematics of the pose are in `state`.
pub fn pressure(state: &State, tau: &[f64], ground_m: f64) -> Option<(Vec3, Vec2)> {
    let zero = state.bodies[0].zero;
    let force = zero * vec_at(tau, 0);
    if force.y <= 0.0 {
        return None;
    }
    // moment about the point of the ground under the world's origin: M = p × F with p on the ground
    let root = state.bodies[0].world.translation.vector - Vec3::y() * ground_m;
    let moment = zero * vec_at(tau, 3) + root.cross(&force);
    Some((force, Vec2::new(moment.z, -moment.x) / force.y))
}

/// Feeds of all rows of a goal on the ground at height `ground_m`; `None` where a row needs no ground, as in
/// flight.
pub fn feeds(model: &Model, goal: &Goal, ground_m: f64) -> Vec<Option<Feed>> {
    let mut state = State::new(model);
    let mut tau = vec![0.0; model.nv()];
    (0..goal.rows())
        .map(|row| {
            let v = goal.velocity(row);
            state.update(model, goal.pose(row), v);
            state.inverse_dynamics(model, v, goal.acceleration(row), &[], &mut tau);
            let (force, at) = pressure(&state, &tau, ground_m)?;
            let momentum = state.momentum(model);
            let rate = ground(&(momentum.linear / model.mass));
            Some(Feed { force, lead: at - ground(&momentum.com), rate })
        })
        .collect()
}
