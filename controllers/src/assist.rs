//! Root assist: a wrench on the root towards the kinematic path, within a hard budget.
//!
//! In: state and goal of a free root. Out: a force and a moment about the root's origin, world, never
//! beyond the budget; honest because it is recorded and reported.
//!
//! A spring and a damper towards the path, critically damped with the whole body's mass and inertia:
//! `F = k Δx + 2 √(k m) Δv`, k = budget / reach: the help is at its budget [`REACH_M`] (or [`REACH_RAD`]) from the
//! path (turned about the axis of largest inertia), whatever the budget is, so a smaller budget pulls more softly everywhere and not only at its limit.

use dynamics::{Model, State, Wrench};
use motion::Vec3;
use motion::rotation::log;
use motion::skeleton::{quat_at, vec_at};

/// Budget of the assist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Largest force, N.
    pub force_n: f64,
    /// Largest moment, N·m.
    pub moment_nm: f64,
}

/// Distance from the path at which a resting root gets the whole force, m. With 10 % of the body weight the pull
/// has a natural frequency of 1 Hz: fast against posture, slow against contact.
pub const REACH_M: f64 = 0.025;
/// Angle from the path at which a resting root gets the whole moment, rad.
pub const REACH_RAD: f64 = 0.1;

/// Wrench on the root of a model whose kinematics are in `state`.
pub fn wrench(
    model: &Model,
    state: &mut State,
    budget: Budget,
    (q, v): (&[f64], &[f64]),
    (goal_q, goal_v): (&[f64], &[f64]),
) -> Wrench {
    let root = &model.bodies[0];
    let (at, vat) = (root.q_at, root.v_at);
    let inertia = state.composites(model)[0].2;
    let k = budget.force_n / REACH_M;
    let pull = (vec_at(goal_q, at) - vec_at(q, at)) * k
        + (vec_at(goal_v, vat) - vec_at(v, vat)) * (2.0 * (k * model.mass).sqrt());
    let turning = log(&(quat_at(goal_q, at + 3) * quat_at(q, at + 3).inverse()));
    let spin = vec_at(goal_v, vat + 3) - vec_at(v, vat + 3);
    // one frequency about all axes, critically damped: the whole moment about the axis of largest inertia
    let largest = inertia.symmetric_eigenvalues().max().max(1e-9);
    let omega = (budget.moment_nm / (REACH_RAD * largest)).sqrt();
    let turn = inertia * (turning * (omega * omega) + spin * (2.0 * omega));
    Wrench {
        link: root.link,
        point: vec_at(q, at),
        force: limit(pull, budget.force_n),
        moment: limit(turn, budget.moment_nm),
    }
}

fn limit(x: Vec3, length: f64) -> Vec3 {
    let n = x.norm();
    if n > length { x * (length / n) } else { x }
}
