//! Bodies with mass: characters, inverse dynamics, mass matrices, momentum, traces.
//!
//! In: a [`Character`], poses, velocities, accelerations, outside wrenches. Out: joint torques,
//! inertia, momentum. No engine and no control: what a body needs, not how it gets it.
//!
//! | module | holds |
//! |---|---|
//! | [`character`] | mass, inertia, shapes and contact points on a skeleton |
//! | [`trace`] | what a dynamic run recorded |
//! | [`trace_npz`] | a trace as numpy arrays |

pub mod character;
pub mod trace;
pub mod trace_npz;

pub use character::{Body, Character, CharacterError, JointClass};
pub use trace::{ContactSample, RootMode, Trace};
