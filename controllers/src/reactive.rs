//! Reactive movement properties: what reads the simulated state every step and adjusts drives \[NF03 §4.2\].
//!
//! A property sees a [`ControlStep`]: the state, the motion asked for, the impedances of the joints. It writes the drives
//! of its joints over what the motion asked and earlier properties wrote; what later ones write counts.
//! [`crate::Balance`] is one, [`crate::Gaze`] a small second. Another is a type with [`Reactive`], handed to
//! [`crate::Controller::new`] (in a dynamic pass: `sim::Pass::reactive`).
//!
//! In: the trait. Out: drives. No engine and no clock: time is in the step, memory in the property.

use std::path::PathBuf;

use dynamics::digest::Digest;
use dynamics::{ContactSample, Model, State};
use motion::ik::IkError;
use motion::{Joint, Vec3};
use thiserror::Error;

use crate::antagonist::SetPoints;
use crate::{Drive, Feed, Rest};

/// Stiffness and damping of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impedance {
    /// Stiffness, N·m/rad.
    pub stiffness: f64,
    /// Damping, N·m·s/rad.
    pub damping: f64,
}

/// Inputs of one control step.
#[derive(Clone, Copy)]
pub struct ControlStep<'a> {
    /// The body.
    pub model: &'a Model,
    /// Set points, per body.
    pub set_points: &'a [SetPoints],
    /// Of every body's joint at the tension asked for.
    pub impedances: &'a [Impedance],
    /// Simulated pose (`nq`) at the start of the step.
    pub q: &'a [f64],
    /// Simulated velocity (`nv`) at the start of the step.
    pub v: &'a [f64],
    /// Contacts of the step before.
    pub contacts: &'a [ContactSample],
    /// Pose asked for (`nq`) at the end of the step.
    pub goal_q: &'a [f64],
    /// Velocity asked for (`nv`) at the end of the step.
    pub goal_v: &'a [f64],
    /// Vertical acceleration of the goal's centre of mass, m/s².
    pub lift: f64,
    /// What the goal's own motion needs of the ground; `None` for a goal that stands still or moves slowly.
    pub feed: Option<Feed>,
    /// Time at the end of the step, s.
    pub time_s: f64,
    /// Length of the step, s.
    pub dt: f64,
}

/// Why a reactive property cannot answer.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ReactiveError {
    /// A limb that two-bone IK cannot solve.
    #[error(transparent)]
    Ik(#[from] IkError),
    /// A program of the user.
    #[error("{message}\n  --> {}:{line}:{column}", file.display())]
    Program {
        /// Its file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What was found and what is allowed.
        message: String,
    },
}

/// A reactive movement property. See the module header.
pub trait Reactive: Send {
    /// Adjusts `drives` (per body) for the next step.
    ///
    /// # Errors
    /// Limbs that two-bone IK cannot solve; programs of the user that fail.
    fn react(&mut self, step: &ControlStep<'_>, drives: &mut [Drive]) -> Result<(), ReactiveError>;

    /// Adds to `digest` all that its answers depend on beside the steps: settings and memory.
    fn identify(&self, digest: &mut Digest);

    /// What it did in the run so far, a line each, for reports.
    fn lines(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Time by which a goal is moved on to find the joint rates of its path, s.
pub(crate) const AHEAD: f64 = 1e-4;

/// Rate that leads from one rest to another in [`AHEAD`] seconds, zero frame (in `.x` for hinges and slides).
pub(crate) fn rate_between(from: &Rest, to: &Rest) -> Vec3 {
    match (from, to) {
        (Rest::Scalar(a), Rest::Scalar(b)) => Vec3::x() * ((b - a) / AHEAD),
        (Rest::Ball { target: a, .. }, Rest::Ball { target: b, .. }) => {
            motion::rotation::log(&(b * a.inverse())) / AHEAD
        }
        _ => Vec3::zeros(),
    }
}

/// Acceleration of the body, measured: differences of velocities through a first-order low-pass filter.
///
/// Properties that carry a mass along need the acceleration of its base. Unfiltered, a drive that answers the
/// acceleration of the last step oscillates at the control rate. Zero after the first step.
#[derive(Clone, Debug, Default)]
pub(crate) struct FilteredAcceleration {
    before: Vec<f64>,
    /// Rate of `v` (`nv`).
    pub(crate) vd: Vec<f64>,
}

impl FilteredAcceleration {
    /// Updates with the velocity `v` (`nv`) after a step of `dt`; `within` is the time constant, s.
    pub(crate) fn update(&mut self, v: &[f64], dt: f64, within: f64) {
        if self.before.is_empty() {
            self.vd.resize(v.len(), 0.0);
            self.before.extend_from_slice(v);
        }
        let gain = 1.0 - (-dt / within).exp();
        for ((vd, now), then) in self.vd.iter_mut().zip(v).zip(&mut self.before) {
            *vd += ((now - *then) / dt - *vd) * gain;
            *then = *now;
        }
    }
}

/// Writes `x` as the velocity or acceleration of a hinge, slide or ball into `out` (`nv`).
pub(crate) fn set_rate(joint: &Joint, v_at: usize, x: &Vec3, out: &mut [f64]) {
    match joint {
        Joint::Revolute(_) | Joint::Prismatic(_) => out[v_at] = x.x,
        Joint::Spherical => out[v_at..v_at + 3].copy_from_slice(x.as_slice()),
        Joint::Free | Joint::Fixed => {}
    }
}

/// World rotation `turn` as one of a body's joint, about the axes of its zero frame.
pub(crate) fn in_zero_frame(state: &State, body: usize, turn: &Vec3) -> Vec3 {
    state.bodies[body].zero.transpose() * turn
}
