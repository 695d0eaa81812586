//! Control without an engine and without a clock: (state, goal) → gains and torques.
//!
//! | module | holds |
//! |---|---|
//! | [`antagonist`] | pairs of springs: gains, least tension, set points |
//! | [`tension`] | from dimensionless tension to stiffness and damping |
//! | [`drive`] | what a muscle pair asks of its joint in one step |

pub mod antagonist;
pub mod drive;
pub mod tension;

pub use antagonist::{Antagonist, HoldError, SetPoints};
pub use drive::{Drive, Rest, rest_of};
pub use tension::{Need, StanceLeg, TensionScale};
