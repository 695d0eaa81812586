//! Analyses as files: what a clip needs, for spreadsheets, OpenSim and numpy.
//!
//! In: an [`Analysis`](dynamics::Analysis). Out: text or bytes; the same analysis, the same bytes. World axes of DESIGN: Y up,
//! +Z forward, +X to the character's left; OpenSim's +X forward is our +Z, its +Z to the right our −X.
//!
//! | function | format | angles |
//! |---|---|---|
//! | [`csv`] | one row per frame, units in the column names | degrees |
//! | [`torques_mot`] | OpenSim motion file of joint forces, for its plotter | – |
//! | [`ground_forces_mot`] | OpenSim motion file of ground reactions, as external loads | – |
//! | [`write_npz`] | numpy arrays, SI, with a table of units | radians |

mod npz;
mod text;

pub use npz::write_npz;
pub use text::{csv, ground_forces_mot, torques_mot};
