//! The pipeline: mapping, global transform, contacts, refinement.

use motion::Clip;

use crate::{KeyPoses, Options, Performer, Puppet, RetargetError, Retargeted};

/// Puts a human motion on a puppet.
///
/// * `clip`: of the performer's skeleton
///
/// # Errors
/// See [`RetargetError`].
pub fn run(
    clip: &Clip,
    performer: &Performer,
    puppet: &Puppet,
    key_poses: &KeyPoses,
    options: &Options,
) -> Result<Retargeted, RetargetError> {
    key_poses.check(puppet)?;
    let _ = (clip, performer, options);
    Err(RetargetError::Learn("not connected".into()))
}
