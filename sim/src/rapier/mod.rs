//! rapier: one articulated body over a ground plane as a multibody of rapier3d. The only place
//! that names rapier3d.
//!
//! In: a character, a state, one [`controllers::Drive`] per joint, outside wrenches. Out: the state after the step and
//! the forces at every contact, through [`Engine`]: the rest of the workspace sees `q`, `v` and newtons.
//!
//! | file | holds |
//! |---|---|
//! | `build` | bodies, colliders, joints and the ground of a character |
//! | `state` | `q`, `v` to and from rapier's coordinates |
//! | `step` | drives, root path, wrenches, the step: [`Engine`] |
//! | `contacts` | contact forces of the last step |
//!
//! How rapier is used, and why (all measured):
//! - Springs of the multibody joints are integrated implicitly. Their rest is re-based every step to
//!   `coords + torque/K`, because the coordinates of a ball joint are the running integral of ω.
//! - Default joint damping (0.1 N·m·s/rad, root included) is set to zero.
//! - The root's frame sits at its centre of mass: elsewhere the engine integrates the wrong point.
//! - Coulomb friction, no contact clustering or recycling: forces are read point by point.
//! - A pinned root is a kinematic joint whose velocity is set; the inertial force of its
//!   acceleration, which the engine leaves out, is added to every body.
//! - Ground that turns is a kinematic body; its velocity at every contact is the solver's. What touches it is as stiff as
//!   on fixed ground.

mod build;
mod contacts;
mod state;
mod step;

use dynamics::Model;
use motion::{Quat, Transform, Vec3};
use rapier3d::prelude as rp;

use crate::{Engine, EngineEntry, EngineSettings};

/// The name by which it is chosen.
pub const NAME: &str = "rapier";

/// The entry of rapier in the table of [`crate::Engines`].
pub fn engine() -> EngineEntry {
    let description = "articulated bodies with implicit joint springs, the default";
    EngineEntry::new(NAME, description, |character, settings, q, v| {
        Ok(Box::new(Rapier::new(character, settings, q, v)?) as Box<dyn Engine>)
    })
}

/// An articulated body in rapier. See the module header.
pub struct Rapier {
    physics: rp::PhysicsWorld,
    /// The body, compiled.
    pub model: Model,
    /// What it was built for; the ground as it lies now.
    pub settings: EngineSettings,
    /// One per moving body.
    handles: Vec<rp::RigidBodyHandle>,
    /// One per prop.
    props: Vec<rp::ColliderHandle>,
    /// Which links touch each other.
    touching: build::Touching,
    /// The ground, if it may turn.
    turning: Option<rp::RigidBodyHandle>,
    any_joint: Option<rp::MultibodyJointHandle>,
    mb_link: Vec<usize>,
    /// Centre of mass of the root body in its own frame; zero unless the root is free.
    root_shift: Vec3,
    /// Stiffness of the stop of each body's joint, N·m/rad; zero without one.
    stops: Vec<f64>,
    /// Stiffness and way back of the stops that act in the next step.
    stopping: Vec<(f64, Vec3)>,
    q: Vec<f64>,
    v: Vec<f64>,
    /// Control steps taken.
    steps: usize,
}

fn to_glam(v: Vec3) -> rp::Vector {
    rp::Vector::new(v.x, v.y, v.z)
}

fn from_glam(v: rp::Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

fn from_rot(r: rp::Rotation) -> Quat {
    Quat::new_normalize(nalgebra::Quaternion::new(r.w, r.x, r.y, r.z))
}

fn pose(t: &Transform) -> rp::Pose {
    let r = t.rotation;
    rp::Pose::from_parts(to_glam(t.translation.vector), rp::Rotation::from_xyzw(r.i, r.j, r.k, r.w))
}
