//! Studies: many runs of one take, and what they say together.
//!
//! In: a take. Out: plain values and their figures.
//!
//! | module | holds |
//! |---|---|
//! | [`push`] | the push-recovery map of a standing body |
//! | [`tune`] | parameters chosen by a search over a cost |
//! | `level_ground` | the ground that pushes and costs need |
//! | [`mod@on_fit`] | track edits on clips, measured |
//! | [`pareto`] | the trade between fidelity and help from outside |
//! | [`propagate`] | edits by example |
//! | [`mod@style`] | style transfers measured: does the style come, does the content stay |
//! | [`retarget`] | how good a set of key poses is; models side by side |

mod level_ground;
pub mod on_fit;
pub mod pareto;
pub mod propagate;
pub mod push;
pub mod retarget;
pub mod style;
pub mod tune;
