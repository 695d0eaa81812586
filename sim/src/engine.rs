//! Engine: what the dynamic pass asks of an articulated-body engine.
//!
//! In: drives, stops, a root path, outside wrenches. Out: the state after a step and the contact forces of
//! that step. [`World`](crate::World) is rapier's; a second engine behind the same trait runs the same pass,
//! controllers in the loop, on its own state.

use controllers::Drive;
use controllers::stops::way_back;
use dynamics::{Character, ContactSample, Model, State, Wrench};
use motion::Vec3;

use crate::WorldError;

/// An articulated body that can be driven and stepped.
pub trait Engine {
    /// Its name, as reports give it.
    const NAME: &'static str;

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
    /// less. Pose and velocity stay, so that momentum changes by what comes or goes.
    ///
    /// # Errors
    /// Of the engine.
    fn set_masses(&mut self, character: &Character) -> Result<(), WorldError>;

    /// Sets the actuators for the next step: one drive per moving body, in the model's order. The entry of
    /// a free root is ignored.
    fn set_drives(&mut self, drives: &[Drive]);

    /// Moves a pinned root so that it reaches `q_next` (a pose; only the root's entries are read) at the end
    /// of the next step, inertial forces on all it carries included. `state` is of the present pose.
    fn move_root(&mut self, state: &State, q_next: &[f64]);

    /// Turns ground that may turn ([`crate::Ground::turns`]) so that it faces `up` (unit length, world) at the end of the
    /// next step, at a constant rate through it. Without a call it rests.
    fn turn_ground(&mut self, up: &Vec3);

    /// Adds an outside wrench for the next step.
    fn add_wrench(&mut self, w: &Wrench);

    /// Advances by one control step and clears the outside wrenches.
    ///
    /// # Errors
    /// [`WorldError::Diverged`] when the numbers run away; [`WorldError::Engine`] when the engine fails.
    fn step(&mut self) -> Result<(), WorldError>;

    /// Appends the contacts of the last step to `out`, labelled with the trace row `row`; forces are means
    /// over the step.
    fn contacts(&self, row: usize, out: &mut Vec<ContactSample>);

    /// Stiffness of the stop of a body's joint (N·m/rad) and the way back into the range along its zero frame
    /// (rad; in `.x` for hinges), in the present pose; `None` inside the range.
    fn stop(&self, body: usize) -> Option<(f64, Vec3)> {
        let model = self.model();
        let b = &model.bodies[body];
        let limits = model.skeleton.links()[b.link].limits.as_ref();
        let k = self.stops()[body];
        if k == 0.0 {
            return None;
        }
        way_back(&b.joint, limits, self.q(), b.q_at).map(|back| (k, back))
    }

    /// Torque of the stop of a body's joint in the present pose, along its zero frame (in `.x` for hinges),
    /// N·m.
    fn stop_torque(&self, body: usize) -> Vec3 {
        self.stop(body).map_or(Vec3::zeros(), |(k, back)| back * k)
    }
}
