//! What can be wrong with examples, in words that a person can act on.

use learn::dtw::DtwError;
use learn::{FitError, InputError};
use motion::time_map::TimeMapError;
use thiserror::Error;

/// Why an edit cannot be learned, or not be applied.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ExampleError {
    /// Whoever watched ended the learning.
    #[error("learning was cancelled, at the {model}, after {evaluations} evaluations")]
    Cancelled {
        /// Which of the two models.
        model: &'static str,
        /// Evaluations of its likelihood.
        evaluations: usize,
    },
    /// Nothing to learn from.
    #[error("there is no pair to learn from; needed: at least one source clip with its edited version")]
    NoPairs,
    /// Source and target that do not go together.
    #[error(
        "pair `{pair}`: the source has {source_frames} frames at {source_hz} Hz and the target {target_frames} at {target_hz} Hz; \
         they must be the same: frame {{n}} of the target is frame {{n}} of the source, edited"
    )]
    Unequal {
        /// The pair.
        pair: String,
        /// Frames of the source.
        source_frames: usize,
        /// Its rate, Hz.
        source_hz: f64,
        /// Frames of the target.
        target_frames: usize,
        /// Its rate, Hz.
        target_hz: f64,
    },
    /// Times that are not those of the frames.
    #[error("pair `{pair}`: {what}")]
    Times {
        /// The pair.
        pair: String,
        /// What is wrong.
        what: String,
    },
    /// A number that is not finite.
    #[error("pair `{pair}`: frame {frame} of the {side} has a number that is not finite")]
    NotFinite {
        /// The pair.
        pair: String,
        /// Source or target.
        side: &'static str,
        /// Which frame.
        frame: usize,
    },
    /// Two performances that no path matches.
    #[error("pair `{pair}`: the two performances cannot be matched: {source}")]
    Matching {
        /// The pair.
        pair: String,
        /// Why.
        source: DtwError,
    },
    /// A span without frames.
    #[error("pair `{pair}`: the span {from_s} s to {to_s} s has no frames; the clip lasts {end_s:.3} s")]
    Span {
        /// The pair.
        pair: String,
        /// Beginning, s.
        from_s: f64,
        /// End, s.
        to_s: f64,
        /// Length of the clip, s.
        end_s: f64,
    },
    /// Another skeleton than that of the model.
    #[error("the skeleton is not one that this edit was taught on: {what}")]
    OtherRig {
        /// What differs.
        what: String,
    },
    /// A skeleton of which nothing moves.
    #[error(
        "the skeleton has no joint that moves, or no point away from its root: nothing to learn an edit of"
    )]
    NothingMoves,
    /// A root that cannot move.
    #[error("the root `{link}` is not free: edits by example are of bodies that move through the world")]
    Root {
        /// The root.
        link: String,
    },
    /// An amount or weight out of range.
    #[error("{what} is {value}; allowed: {allowed}")]
    Setting {
        /// What.
        what: &'static str,
        /// As found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Examples that no model can be fitted to.
    #[error("learning the {model}: {source}")]
    Fit {
        /// Which of the two models.
        model: &'static str,
        /// Why.
        source: FitError,
    },
    /// A frame that a model cannot answer.
    #[error("frame {frame}: {source}")]
    Input {
        /// Which frame.
        frame: usize,
        /// Why.
        source: InputError,
    },
    /// Stored parts that do not fit each other.
    #[error("the stored edit: {what}")]
    Stored {
        /// What does not fit.
        what: String,
    },
    /// Predicted times that are no motion.
    #[error("the predicted times are no map of time: {0}")]
    Retime(#[from] TimeMapError),
}
