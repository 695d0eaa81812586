//! The dynamic pass: a character with muscles, simulated by rapier.
//!
//! In: a character, a controller, a goal. Out: a [`dynamics::Trace`]. The only crate that names
//! rapier, and only behind [`World`]: state in, drives and wrenches in, state and contact forces out,
//! so that another articulated-body core can stand beside it.
//!
//! | module | holds |
//! |---|---|
//! | [`world`] | the articulated body and the ground in rapier |
//! | [`engine`] | what the pass asks of an engine |
//! | [`ground`] | the ground, and how it turns |
//! | [`contacts`] | contact forces |
//! | [`pass`] | a whole run, recorded |

pub mod contacts;
pub mod engine;
pub mod ground;
mod load;
pub mod pass;
pub mod world;

pub use engine::Engine;
pub use ground::{Ground, Tilt};
pub use pass::{Outcome, Pass, PassError, Push, Run};
pub use world::{ContactLaw, World, WorldError, WorldSettings};
