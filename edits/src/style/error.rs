//! What can be wrong with style components, in words that a person can act on.

use learn::dtw::DtwError;
use learn::ica::IcaError;
use motion::ik::IkError;
use motion::time_map::TimeMapError;
use thiserror::Error;

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
