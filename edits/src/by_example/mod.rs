//! Edits by example: a few seconds edited by hand, the same edit on other motion (IAF09).
//!
//! In: [`Pair`]s of a source clip and its edited version, frame by frame. Out: an [`ExampleEdit`], a model of the edit, which [`ByExample`]
//! applies to any clip of the same rig as a clip edit: predictions of configurations and of accelerations by two
//! regressions of `learn`, blended with the source so that it returns where the model is unsure ([`solve`]).
//!
//! What is learned is the difference of the target to its source ([`outputs`]): the paper learns the target itself, which mixes units in the
//! blend and changes motion that was not edited ([`poses`], for comparison). Far from the examples the differences are taken back by how new a frame is
//! ([`model::gate`]): the likelihood alone would stretch a constant edit over everything.
//!
//! | module | holds |
//! |---|---|
//! | [`pair`] | training pairs, checked |
//! | [`performances`] | pairs from two performances of the same content |
//! | [`rig`] | points and joints by name, headings, left and right |
//! | [`features`] | what a frame is recognised by |
//! | [`outputs`] | how a target differs from its source, and back |
//! | [`poses`] | the target itself instead, as the paper has it |
//! | [`options`] | how an edit is learned and applied |
//! | [`rows`] | the examples of pairs, and their axes |
//! | [`model`] | training and prediction |
//! | [`solve`] | the blend of all predictions: one pentadiagonal system |
//! | [`contacts`] | the blend with contacts kept: Gauss–Newton on blocks |
//! | [`block_band`] | its linear equations |
//! | [`edit`] | the clip edit |
//! | [`onto`] | a motion on a body of other proportions |
//! | [`part`] | a changed span first |
//! | [`review`] | examples that contradict each other; frames to key next |
//! | [`error`] | what can be wrong |
//!
//! Units: m, s, rad; lengths of features and outputs in parts of the body's size.
//!
//! IAF09: Ikemoto, Arikan, Forsyth. Generalizing motion edits with Gaussian processes. ACM TOG 28(1), 2009.

pub mod block_band;
mod contact_chain;
pub mod contacts;
pub mod edit;
pub mod error;
pub mod features;
pub mod model;
pub mod onto;
pub mod options;
pub mod outputs;
pub mod pair;
pub mod part;
pub mod performances;
pub mod poses;
pub mod review;
pub mod rig;
pub mod rows;
pub mod solve;

pub use contacts::Contacts;
pub use edit::ByExample;
pub use error::ExampleError;
pub use features::Orientation;
pub use model::{Answer, ExampleEdit, Learning, Taught};
pub use onto::{Onto, leg_m};
pub use options::ExampleOptions;
pub use pair::Pair;
pub use part::{Part, first};
pub use performances::{Correspondence, correspond};
pub use poses::Outputs;
pub use review::{Contradiction, KeyNext, contradictions, key_next};
pub use rig::{Axes, Rig};
pub use rows::ExampleFrame;
pub use solve::Weights;
