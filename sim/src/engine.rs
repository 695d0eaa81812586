//! Engine: what the dynamic pass asks of an articulated-body engine.
//!
//! In: drives, stops, a root path, outside wrenches. Out: the state after a step and the contact forces of that step.
//! Controllers, pushes, the recorder and the pass know an engine as `Box<dyn Engine>` only, so that another engine runs
//! the same pass, controllers in the loop, on its own state. Which engines there are is the affair of
//! [`crate::Engines`]; an implementation is a module ([`crate::rapier`]) or a crate of its own.
//!
//! World frame, Y up, SI. Poses `q` and velocities `v` are in the layout of [`motion::skeleton`].

use std::sync::Arc;

use bodies::{Character, Prop};
use controllers::Drive;
use controllers::stops::restoring_torque;
use dynamics::{Against, Model, Momentum, State, Wrench};
use motion::{Floor, Vec3};
use thiserror::Error;

use crate::Ledger;

/// What an engine is built for.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineSettings {
    /// Control steps per second, Hz.
    pub rate_hz: f64,
    /// Engine substeps per control step.
    pub substeps: usize,
    /// Gravity, m/s².
    pub gravity: Vec3,
    /// Ground plane, if any.
    pub ground: Option<Floor>,
    /// Whether the root's motion is given instead of simulated.
    pub pinned: bool,
    /// How contacts yield.
    pub contact: ContactLaw,
    /// Boxes and ramps fixed in the world.
    pub props: Arc<[Prop]>,
    /// Whether links touch each other: the pairs of [`Character::self_pairs`], with the friction coefficient
    /// [`motion::floor::FRICTION`].
    pub self_collision: bool,
}

impl EngineSettings {
    /// A body that nothing holds, under the gravity of the earth: contacts as stiff as they get, no props, links that do not touch each other.
    pub fn free(rate_hz: f64, substeps: usize, ground: Option<Floor>) -> Self {
        Self {
            rate_hz,
            substeps,
            gravity: Vec3::new(0.0, -9.81, 0.0),
            ground,
            pinned: false,
            contact: ContactLaw::Stiff,
            props: Default::default(),
            self_collision: false,
        }
    }
}

/// How contacts yield.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ContactLaw {
    /// As stiff as the engine's solver allows, inelastic: what characters stand on.
    #[default]
    Stiff,
    /// A spring and a damper at each point: stiffness m ω² and damping 2 ζ m ω with the apparent mass m of the
    /// point, for comparisons at a known compliance. Holds while ω dt ≪ 1 and pushes only.
    Spring {
        /// ω/2π, Hz.
        natural_frequency_hz: f64,
        /// ζ.
        damping_ratio: f64,
    },
    /// A spring and a damper at each point, the same for every body: a load m g on n points sinks by m g/(n k). Pushes only.
    /// Only the core has it.
    Compliant {
        /// k, N/m.
        stiffness_n_m: f64,
        /// c, N·s/m.
        damping_n_s_m: f64,
    },
}

/// Why an engine cannot be built or stepped.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EngineError {
    /// A free root whose zero frame is turned or shifted.
    #[error("the root `{0}` must have its zero frame at the world's origin")]
    RootFrame(String),
    /// The engine refused a joint.
    #[error("the engine refused the joint of `{0}`")]
    Joint(String),
    /// An engine that cannot be started or stopped working, in its own words.
    #[error("{0}")]
    Failed(String),
    /// State that is not finite or moves faster than any character.
    #[error("the simulation diverged at step {step} ({time_s:.3} s), first seen at `{body}`")]
    Diverged {
        /// Control step.
        step: usize,
        /// Time, s.
        time_s: f64,
        /// Link at which it showed.
        body: String,
    },
}

/// Force at one contact point, mean over the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactForce {
    /// Link that is touched.
    pub link: usize,
    /// What it touches. Where that is another link, there are two contacts at one point: equal and opposite forces.
    pub against: Against,
    /// Point of contact, world, m.
    pub point: Vec3,
    /// Force on the link, world, N.
    pub force: Vec3,
    /// Depth of penetration, m (negative when apart).
    pub depth: f64,
}

/// Above this rate (rad/s or m/s) no character moves.
const RUNAWAY: f64 = 1e3;

/// An articulated body that can be driven and stepped.
///
/// Object-safe, and able to move to another thread, so that a run can be stepped by whoever holds it.
pub trait Engine: Send {
    /// Its name, as reports and the command line spell it.
    fn name(&self) -> &str;

    /// The body, compiled.
    fn model(&self) -> &Model;

    /// Pose after the last step, `nq`.
    fn q(&self) -> &[f64];

    /// Velocity after the last step, `nv`.
    fn v(&self) -> &[f64];

    /// Sets the stiffness of the stops at the ends of the joints' ranges, N·m/rad, one per moving body.
    ///
    /// Without a call there are no stops.
    fn set_stops(&mut self, stiffness: &[f64]);

    /// Stiffness of the stops, N·m/rad, one per moving body.
    fn stops(&self) -> &[f64];

    /// Replaces masses, centres of mass and inertias by those of `character`: the same body, carrying more or
    /// less. Pose and velocity stay, so that momentum changes by that of the mass added or removed.
    ///
    /// # Errors
    /// Of the engine.
    fn set_masses(&mut self, character: &Character) -> Result<(), EngineError>;

    /// Sets the actuators for the next step: one drive per moving body, in the model's order. The entry of
    /// a free root is ignored. Without a call no joint is driven.
    fn set_drives(&mut self, drives: &[Drive]);

    /// Moves a pinned root so that it reaches `q_next` (a pose; only the root's entries are read) at the end
    /// of the next step, inertial forces on all it carries included. `state` is of the present pose.
    fn move_root(&mut self, state: &State, q_next: &[f64]);

    /// Turns ground that may turn ([`Floor::turns`]) so that it faces `up` (unit length, world) at the end of the
    /// next step, at a constant rate through it. Without a call it rests.
    fn turn_ground(&mut self, up: &Vec3);

    /// Adds an outside wrench for the next step.
    fn add_wrench(&mut self, w: &Wrench);

    /// Advances by one control step and clears the outside wrenches.
    ///
    /// # Errors
    /// [`EngineError::Diverged`] when the state is not finite or too fast; [`EngineError::Failed`] when the engine fails.
    fn step(&mut self) -> Result<(), EngineError>;

    /// Appends the contacts of the last step to `out`, in an order that depends on the state alone.
    fn contacts(&self, out: &mut Vec<ContactForce>);

    /// Pose and velocity of all that it simulates: [`Engine::q`] and [`Engine::v`], followed by those of parts that
    /// [`Engine::model`] does not have ([`crate::soles`]).
    fn whole(&self) -> (&[f64], &[f64]) {
        (self.q(), self.v())
    }

    /// Momentum of all that it simulates; `state` is of the present pose and velocity of [`Engine::model`].
    fn momentum(&self, state: &State) -> Momentum {
        state.momentum(self.model())
    }

    /// Kinetic and potential energy of all that it simulates, J; `state` is of the present pose and velocity of [`Engine::model`].
    fn energy(&self, state: &State) -> (f64, f64) {
        state.energy(self.model())
    }

    /// What it did beyond the equations of motion, counted since it was built; `None` of an engine that does not count.
    fn ledger(&self) -> Option<&Ledger> {
        None
    }

    /// Name of the first body whose state is not finite, or that moves as no character does (1000 rad/s or m/s): the run has
    /// diverged.
    fn runaway(&self) -> Option<&str> {
        let (model, q, v) = (self.model(), self.q(), self.v());
        let body = model.bodies.iter().find(|b| {
            let q = &q[b.q_at..b.q_at + b.joint.nq()];
            let v = &v[b.v_at..b.v_at + b.joint.nv()];
            q.iter().any(|x| !x.is_finite()) || v.iter().any(|x| x.is_nan() || x.abs() >= RUNAWAY)
        })?;
        Some(&model.skeleton.links()[body.link].name)
    }

    /// Stiffness of the stop of a body's joint (N·m/rad) and its torque per stiffness along the zero frame
    /// (rad; in `.x` for hinges), in the present pose; `None` inside the range.
    fn stop(&self, body: usize) -> Option<(f64, Vec3)> {
        let model = self.model();
        let b = &model.bodies[body];
        let limits = model.skeleton.links()[b.link].limits.as_ref();
        let k = self.stops()[body];
        if k == 0.0 {
            return None;
        }
        restoring_torque(&b.joint, limits, self.q(), b.q_at).map(|back| (k, back))
    }

    /// Torque of the stop of a body's joint in the present pose, along its zero frame (in `.x` for hinges),
    /// N·m.
    fn stop_torque(&self, body: usize) -> Vec3 {
        self.stop(body).map_or(Vec3::zeros(), |(k, back)| back * k)
    }
}
