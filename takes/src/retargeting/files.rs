//! Performances, key poses and sessions from files.
//!
//! In: paths. Out: what this module's parent works with, opened by [`crate::open()`].

use std::path::Path;

use formats::bvh::ImportOptions;
use retarget::Puppet;

use super::{KeyPoseFile, Performance, RetargetingError, Session, key_pose_file};
use crate::open::of_path;
use crate::opening::Opening;

/// Nothing was opened before.
fn first() -> Opening<'static> {
    Opening::new(of_path)
}

impl Performance {
    /// Opens a scene or a clip; the clip's body is guessed from its skeleton.
    ///
    /// # Errors
    /// Anything wrong with the file; a body that is not human.
    pub fn open(path: &Path, import: &ImportOptions) -> Result<Self, RetargetingError> {
        Self::with_body(path, None, import)
    }

    /// As [`Performance::open`], of a clip with a character file as its body.
    ///
    /// # Errors
    /// Likewise; a body that does not fit the clip, or is given to a scene.
    pub fn with_body(
        path: &Path,
        body: Option<&Path>,
        import: &ImportOptions,
    ) -> Result<Self, RetargetingError> {
        Self::opened_by(&first(), path, body, import)
    }
}

impl KeyPoseFile {
    /// Reads the key poses of a puppet.
    ///
    /// # Errors
    /// Anything wrong with the file or its performances, at its place: too few pairs, one pair twice, one human
    /// pose with two character poses, a moment that a performance does not have, unknown joints, angles beyond
    /// a limit, performances of another skeleton.
    pub fn open(path: &Path, puppet: &Puppet) -> Result<Self, RetargetingError> {
        key_pose_file::read(path, puppet, &first())
    }
}

impl Session {
    /// Opens everything; `key_poses` default to those that lie beside the character.
    ///
    /// # Errors
    /// [`RetargetingError`].
    pub fn open(
        performance: &Path,
        character: &Path,
        key_poses: Option<&Path>,
        import: &ImportOptions,
    ) -> Result<Self, RetargetingError> {
        Self::of(Performance::open(performance, import)?, character, key_poses)
    }

    /// As [`Session::open`], of a performance that is open already.
    ///
    /// # Errors
    /// [`RetargetingError`].
    pub fn of(
        performance: Performance,
        character: &Path,
        key_poses: Option<&Path>,
    ) -> Result<Self, RetargetingError> {
        Self::opened_by(&first(), performance, character, key_poses)
    }
}
