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
//! | [`mod@transfer`] | components of the one in the other, amounts, what is mended afterwards |
//! | `feet` | feet that stand where they stood |
//! | [`edit`] | the clip edit |
//!
//! \[SCF06\] Shapiro, Cao, Faloutsos. Style components. Graphics Interface 2006.

pub mod align;
pub mod cycle;
pub mod edit;
mod feet;
pub mod figure;
pub mod representation;
pub mod separate;
pub mod set;
#[cfg(test)]
mod tests;
pub mod transfer;
mod words;

use learn::dtw::DtwError;
use learn::ica::IcaError;
use motion::ik::IkError;
use motion::time_map::TimeMapError;
use thiserror::Error;

pub use align::On;
pub use edit::Style;
pub use representation::Representation;
pub use set::{Example, StyleOptions, StyleSet};
pub use transfer::{Styled, Timing, Transfer, transfer};

/// Why clips cannot be decomposed, or a style not be put into a clip.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum StyleError {
    /// A clip that is no motion.
    #[error("{name} has {frames} frames; a motion has at least 2")]
    Short {
        /// The clip.
        name: String,
        /// Its frames.
        frames: usize,
    },
    /// Skeletons that have too little in common.
    #[error(
        "only {found} of the {bones} bones are found in the other skeleton, at least half are needed; missing: {missing}; it has: {links}"
    )]
    Skeletons {
        /// Bones found.
        found: usize,
        /// Bones of the first skeleton.
        bones: usize,
        /// Those not found.
        missing: String,
        /// Links of the other.
        links: String,
    },
    /// Data that cannot be decomposed.
    #[error(transparent)]
    Ica(#[from] IcaError),
    /// Series that cannot be aligned.
    #[error(transparent)]
    Dtw(#[from] DtwError),
    /// Nothing to align on.
    #[error("{on} stands still in one of the clips: there is nothing to align on; give anchors")]
    Still {
        /// What was to be aligned on.
        on: String,
    },
    /// A bone that there is not.
    #[error("unknown bone `{name}` to align on{hint}")]
    Bone {
        /// As written.
        name: String,
        /// The nearest name.
        hint: String,
    },
    /// A component that there is not.
    #[error("there is no component {found}; allowed: 1 to {most}")]
    Component {
        /// As written, from 1.
        found: usize,
        /// Components there are.
        most: usize,
    },
    /// A clip that the set is not of.
    #[error("the set has no clip `{name}`; it is of {known}")]
    Name {
        /// As written.
        name: String,
        /// What there is.
        known: String,
    },
    /// An amount out of range.
    #[error("an amount of {value}; allowed: 0 to 1.5")]
    Amount {
        /// As found.
        value: f64,
    },
    /// A curve of amounts that is none.
    #[error(
        "an amount is a number, or (over_time_s: [(t, x), …]) with at least one knot, finite and in ascending order"
    )]
    Knots,
    /// A cut-off out of range.
    #[error("a cut-off of {value} Hz; it must be above 0")]
    Cutoff {
        /// As found, Hz.
        value: f64,
    },
    /// Anchors that are no time map.
    #[error("anchors from the base to the donor: {source}")]
    Anchors {
        /// What is wrong with them.
        source: TimeMapError,
    },
    /// A leg that cannot be solved.
    #[error(transparent)]
    Ik(#[from] IkError),
}
