//! Offsets that foresight chose, as a file, and back.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use dynamics::Model;
use formats::TraceFileError;
use formats::foresight_npz::{self, Offsets};
use sim::Outcome;
use sim::foresight::{Foreseen, Replay, Used};

/// A file that holds no offsets.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {}: {source}", path.display())]
pub struct ReplayFileError {
    /// The file.
    path: PathBuf,
    /// Why.
    source: TraceFileError,
}

/// What is asked of a pass by a file of offsets.
///
/// # Errors
/// [`ReplayFileError`]: no such file, or one of something else.
pub fn replay(path: &Path) -> Result<Foreseen, ReplayFileError> {
    let read = foresight_npz::open(path);
    let Offsets { input, joints, offsets, .. } =
        read.map_err(|source| ReplayFileError { path: path.to_owned(), source })?;
    Ok(Foreseen::Replay(Arc::new(Replay { input, channels: joints.len(), offsets })))
}

/// The offsets of a run as they are written.
pub(crate) fn offsets(outcome: &Outcome, used: &Used) -> Offsets {
    let links = outcome.trace.character.skeleton.links();
    let bodies = Model::new(&outcome.trace.character, outcome.trace.gravity).bodies;
    Offsets {
        input: used.input,
        rate_hz: outcome.trace.rate_hz,
        joints: used.channels.iter().map(|c| links[bodies[c.body].link].name.clone()).collect(),
        axes: used.channels.iter().map(|c| c.axis).collect(),
        offsets: used.offsets.clone(),
    }
}
