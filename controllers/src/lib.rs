//! Control without an engine and without a clock: (state, goal) → gains and torques.
//!
//! | module | holds |
//! |---|---|
//! | [`drive`] | what a muscle pair asks of its joint in one step |

pub mod drive;

pub use drive::{Drive, Rest};
