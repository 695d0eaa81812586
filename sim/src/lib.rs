//! The dynamic pass: a character with muscles, simulated by an engine that is chosen by name.
//!
//! In: a character, a controller setup, a goal, an engine. Out: a [`dynamics::Trace`]. The pass and the recorder know
//! engines as [`Engine`] only: drives and wrenches in, state and contact forces out. Another engine is a type with that
//! trait and a line in an [`Engines`] table, in a module beside [`rapier`] or in a crate of its own.
//!
//! | module | holds |
//! |---|---|
//! | [`engine`] | what the pass asks of an engine, its settings and errors |
//! | [`engine_entry`] | an engine that can be built |
//! | [`engines`] | engines by name |
//! | [`mod@core`] | a reduced-coordinate engine of our own, many times faster |
//! | [`rapier`] | the articulated body and the ground in rapier |
//! | [`foresight`] | rollouts in the core that choose offsets of targets |
//! | [`ledger`] | what an engine did beyond the equations of motion |
//! | [`pass`] | a whole run |
//! | [`soles`] | any engine, with soles that yield |
//! | `recorder` | the trace of a run, row by row |
//! | `load` | masses carried, row by row |

pub mod core;
pub mod engine;
pub mod engine_entry;
pub mod engines;
pub mod foresight;
pub mod ledger;
mod load;
pub mod pass;
pub mod rapier;
mod recorder;
pub mod soles;

pub use self::core::Core;
pub use engine::{ContactForce, ContactLaw, Engine, EngineError, EngineSettings};
pub use engine_entry::EngineEntry;
pub use engines::{Engines, UnknownEngine};
pub use ledger::{Impulse, Ledger};
pub use pass::{Outcome, Pass, PassError, Run};
pub use rapier::Rapier;
