//! The dynamic pass: a character with muscles, simulated by rapier.
//!
//! In: a character, a controller, a goal. Out: a [`dynamics::Trace`]. The only crate that names
//! rapier, and only behind [`World`]: state in, drives and wrenches in, state and contact forces out,
//! so that another articulated-body core can stand beside it.
//!
//! | module | holds |
//! |---|---|
//! | [`world`] | the articulated body and the ground in rapier |
//! | [`contacts`] | contact forces |
//! | [`pass`] | a whole run, recorded |

pub mod contacts;
pub mod pass;
pub mod world;

pub use pass::{Outcome, Pass, PassError, Push, Run};
pub use world::{Ground, World, WorldError, WorldSettings};
