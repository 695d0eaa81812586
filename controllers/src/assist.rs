//! Root assist: a wrench on the root towards the kinematic path, within a hard budget.
//!
//! In: state and goal of a free root. Out: a force and a moment about the root's origin, world, never
//! beyond the budget. Critically damped towards the path with the whole body's mass; honest because it
//! is recorded and reported.

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

/// Natural frequency of the pull, rad/s: fast against posture (1 s), slow against contact.
const OMEGA: f64 = std::f64::consts::TAU;

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
    let pull = (vec_at(goal_q, at) - vec_at(q, at)) * (OMEGA * OMEGA)
        + (vec_at(goal_v, vat) - vec_at(v, vat)) * (2.0 * OMEGA);
    let turn = log(&(quat_at(goal_q, at + 3) * quat_at(q, at + 3).inverse())) * (OMEGA * OMEGA)
        + (vec_at(goal_v, vat + 3) - vec_at(v, vat + 3)) * (2.0 * OMEGA);
    Wrench {
        link: root.link,
        point: vec_at(q, at),
        force: limit(pull * model.mass, budget.force_n),
        moment: limit(inertia * turn, budget.moment_nm),
    }
}

fn limit(x: Vec3, length: f64) -> Vec3 {
    let n = x.norm();
    if n > length { x * (length / n) } else { x }
}
