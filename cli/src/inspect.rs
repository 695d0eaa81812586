//! `inspect`: what is in a scene, a character or a clip.

use crate::args::InspectArgs;
use crate::failure::Failure;

/// Runs the command.
pub fn run(_args: &InspectArgs) -> Result<(), Failure> {
    Ok(())
}
