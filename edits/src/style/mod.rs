//! Style components: the sneak of a sneak, in a walk \[SCF06\].
//!
//! In: two clips. Out: a [`StyleSet`] of independent components, each a motion to look at, and the edit [`Style`] that puts some
//! of them into any clip.
//!
//! ```text
//! two clips ─→ figure, postures ─→ numbers ─→ FastICA ─→ StyleSet ─→ words, motions
//! a clip + StyleSet ─→ aligned ─→ Δ activations ─→ low-pass ─→ bone lengths ─→ feet planted ─→ the clip, styled
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`figure`] | bones and turns that all skeletons share; one skeleton brought onto another |
//! | [`representation`] | positions, rotation vectors or Euler angles as numbers, and back |
//! | [`set`] | the decomposition of two clips; components as motions; merging |
//! | [`separate`] | how well a component tells the clips apart |
//! | `words` | what a component is, in words |
//! | [`cycle`] | whether a series repeats itself |
//! | [`align`] | time warping of a donor to a base |
//! | `steps`, `knees` | feet that go the base's way, knees that bend in its plane |
//! | [`mod@transfer`] | components of the one in the other, amounts, what is mended afterwards |
//! | [`edit`] | the clip edit |
//!
//! \[SCF06\] Shapiro, Cao, Faloutsos. Style components. Graphics Interface 2006.

pub mod align;
pub mod cycle;
pub mod edit;
pub mod error;
pub mod figure;
mod knees;
pub mod representation;
pub mod separate;
pub mod set;
mod steps;
#[cfg(test)]
mod tests;
pub mod transfer;
mod words;

pub use align::On;
pub use edit::Style;
pub use error::StyleError;
pub use representation::Representation;
pub use set::{Example, StyleOptions, StyleSet};
pub use transfer::{Styled, Timing, Transfer, transfer};
