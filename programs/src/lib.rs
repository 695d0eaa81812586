//! Programs: edits and reactive properties that a user writes in a text file and runs without recompiling.
//!
//! In: the text of a program in the language [rhai](https://rhai.rs), and the parameters that a scene gives it. Out: a track
//! edit, a clip edit or a reactive property like those that are built in. `docs/PROGRAMS.md` is the guide for those who write one.
//!
//! | module | holds |
//! |---|---|
//! | [`program`] | a program read, its parameters |
//! | [`language`] | the language: what a program may call |
//! | [`limits`] | what bounds time and memory of a program |
//! | [`engine`] | the language with the values of all kinds of program |
//! | [`noise`] | seeded noise |
//! | [`values`] | joint values in degrees and metres, lists of numbers |
//! | [`elements`], [`frames`], [`body`] | what a program sees of a script, of a clip, of the simulated body |
//! | [`track_edit`], [`clip_edit`], [`reaction`] | a program as an edit of tracks, of clips, as a reactive property |
//! | `shared` | what a program works on, shared with the values it was handed |
//! | [`error`] | what can be wrong, with its place |
//!
//! A program is given values of its own and nothing else: no file, no clock, no random number without a seed, no module, no
//! text that becomes code. Its steps, the depth of its calls and the size of its values are bounded. What it computes is the
//! same to the bit everywhere and on any number of threads: functions beyond arithmetic come from `libm`, maps are ordered.

pub mod body;
pub mod clip_edit;
pub mod elements;
pub mod engine;
pub mod error;
pub mod frames;
pub mod language;
pub mod limits;
pub mod noise;
pub mod program;
pub mod reaction;
mod shared;
pub mod track_edit;
pub mod values;

pub use error::ProgramError;
pub use program::{Entry, Program};
pub use reaction::{Reacted, Reaction};
