//! Why no body could be guessed of a skeleton.

use motion::skeleton::SkeletonError;
use thiserror::Error;

use super::aliases::AnatomyError;
use crate::character::CharacterError;

/// Why no body could be guessed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GuessError {
    /// The names do not make a human.
    #[error(transparent)]
    Anatomy(#[from] AnatomyError),
    /// The reference pose lies or sits.
    #[error(
        "the {what} of the {pose} leans {angle_deg:.0}° (at most {limit_deg:.0}°): it is not a standing pose, so left, front and the hanging limbs cannot be read from it; a body is guessed of a clip whose zero pose or one frame stands"
    )]
    NotStanding {
        /// The pose looked at.
        pose: &'static str,
        /// What leans.
        what: &'static str,
        /// By how much, degrees.
        angle_deg: f64,
        /// What is allowed, degrees.
        limit_deg: f64,
    },
    /// Too small, too large, or without trunk or legs.
    #[error(
        "the legs suggest a stature of {stature:.3} m (allowed: 0.2 to 4 m, with hips apart and a trunk); state the unit of the file"
    )]
    Size {
        /// Stature suggested by the legs, m.
        stature: f64,
    },
    /// A mass that is no mass.
    #[error("a body of {0} kg is impossible; give a positive number")]
    Mass(f64),
    /// A reference pose of the wrong length.
    #[error("the reference pose has {found} numbers, the skeleton needs {needed}")]
    Reference {
        /// Length found.
        found: usize,
        /// Length needed.
        needed: usize,
    },
    /// A skeleton that cannot be cut at its pelvis.
    #[error("the skeleton cannot be cut at its pelvis: {0}")]
    Fold(String),
    /// A root that cannot move.
    #[error("the root `{0}` must have a free joint")]
    Root(String),
    /// The result does not hold together.
    #[error(transparent)]
    Character(#[from] CharacterError),
    /// The skeleton refuses a guessed name or limit.
    #[error(transparent)]
    Skeleton(#[from] SkeletonError),
}
