//! Root assist: a wrench on the root towards the kinematic path, within a hard budget.
//!
//! In: state and goal of a free root. Out: a force and a moment about the root's origin, world, never
//! beyond the budget; what it gives is recorded and reported.
//!
//! A spring and a damper towards the path, critically damped with the whole body's mass m and inertia I:
//! `F = m (ω² Δc + 2 ω Δċ)`, `M = ω² I θ + 2 ω ΔL`, with c the centre of mass, θ the turn left to the root's orientation
//! and L the angular momentum about the centre of mass. The dampers act on the whole body's motion, not on the
//! root's: the root alone is light, and a damper fit for the body would shake it.
//!
//! ω is such that the budget is reached [`REACH_M`] (or [`REACH_RAD`]) from the path, whatever the budget is, up to
//! [`FASTEST`]: a smaller budget pulls more softly everywhere and not only at its limit.

use dynamics::{Model, State, Wrench};
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

/// Distance from the path at which a resting body gets the whole force, m. With 10 % of the body weight the pull
/// has a natural frequency of 1 Hz: fast against posture, slow against contact.
pub const REACH_M: f64 = 0.025;
/// Angle from the path at which a resting body gets the whole moment about its axis of largest inertia, rad.
pub const REACH_RAD: f64 = 0.1;
/// Highest natural frequency of the pull, rad/s (2 Hz): above, the trunk's own springs answer.
pub const FASTEST: f64 = 4.0 * std::f64::consts::PI;

/// The assist of a run, with what it needs to know of the goal.
#[derive(Clone, Debug)]
pub struct Assist {
    budget: Budget,
    goal: State,
}

impl Assist {
    /// An assist within `budget`.
    pub fn new(model: &Model, budget: Budget) -> Self {
        Self { budget, goal: State::new(model) }
    }

    /// Wrench on the root of a model whose kinematics are in `state`, at `q`, towards the goal's pose and velocity.
    pub fn wrench(
        &mut self,
        model: &Model,
        state: &mut State,
        q: &[f64],
        (goal_q, goal_v): (&[f64], &[f64]),
    ) -> Wrench {
        let root = &model.bodies[0];
        let at = root.q_at;
        self.goal.update(model, goal_q, goal_v);
        let (to, now) = (self.goal.momentum(model), state.momentum(model));
        let inertia = state.composites(model)[0].2;
        let Budget { force_n, moment_nm } = self.budget;
        let omega = (force_n / (REACH_M * model.mass.max(1e-9))).sqrt().min(FASTEST);
        let pull =
            (to.com - now.com) * (model.mass * omega * omega) + (to.linear - now.linear) * (2.0 * omega);
        let turning = log(&(quat_at(goal_q, at + 3) * quat_at(q, at + 3).inverse()));
        let largest = inertia.symmetric_eigenvalues().max().max(1e-9);
        let omega = (moment_nm / (REACH_RAD * largest)).sqrt().min(FASTEST);
        let turn = inertia * turning * (omega * omega) + (to.angular - now.angular) * (2.0 * omega);
        Wrench {
            link: root.link,
            point: vec_at(q, at),
            force: pull.cap_magnitude(force_n),
            moment: turn.cap_magnitude(moment_nm),
        }
    }
}
