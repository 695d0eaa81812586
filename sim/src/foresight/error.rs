//! Why foresight cannot start or go on.

use controllers::ReactiveError;
use thiserror::Error;

use super::replay::ReplayError;
use crate::EngineError;

/// Why foresight cannot start or go on.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ForesightError {
    /// Of the core in which it looks ahead.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// Of the controller that steps ahead.
    #[error(transparent)]
    Reactive(#[from] ReactiveError),
    /// Offsets that are of another run.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}
