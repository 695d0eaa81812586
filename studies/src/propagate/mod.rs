//! Edits by example as a project: pairs, corrections, the model, and how good it is.
//!
//! | module | holds |
//! |---|---|
//! | [`rules`] | known edits, to measure against |
//! | [`compare`] | learned edits beside what an artist would do instead |

pub mod compare;
pub mod rules;

use edits::EditError;
use edits::by_example::ExampleError;
use thiserror::Error;

/// Why a study of edits by example cannot go on.
#[derive(Debug, Error)]
pub enum PropagateError {
    /// Examples that cannot be learned from or applied.
    #[error(transparent)]
    Example(#[from] ExampleError),
    /// A place that the clip does not have.
    #[error(transparent)]
    Edit(EditError),
    /// A clip that no rule can act on.
    #[error(transparent)]
    Rule(#[from] rules::RuleError),
}
