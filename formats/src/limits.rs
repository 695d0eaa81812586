//! How much a file may hold, and reading it within that.
//!
//! In: a path and one of these limits. Out: the bytes, or an error at once. Work and memory of every reader are near linear in what
//! the limits allow.

use std::path::Path;

use motion::file::read_within;

use crate::FileError;

/// Largest model file (MJCF, URDF) with all it includes.
pub const MODEL_BYTES: u64 = 64 << 20;
/// Largest motion file: two hours of a body of 100 joints at 120 Hz have 2 GB.
pub const CLIP_BYTES: u64 = 2 << 30;
/// Largest trace on disk.
pub const TRACE_BYTES: u64 = 8 << 30;
/// Largest learned edit: an hour of examples at 30 Hz has 800 MB.
pub const EDIT_BYTES: u64 = 1 << 30;
/// Largest set of style components: two clips of half an hour at 120 Hz in 20 components have 70 MB.
pub const STYLE_BYTES: u64 = 256 << 20;
/// Most elements of a model with all it includes.
pub const ELEMENTS: usize = 200_000;
/// Most attributes of one element.
pub const ATTRIBUTES: usize = 200;
/// Most files a model includes.
pub const INCLUDES: usize = 1000;
/// Most bodies and joints, together, of a model.
pub const BODIES: usize = 10_000;
/// Greatest number in a model or clip, in SI: what is written in single precision stays finite, and so do squares.
pub const NUMBER: f64 = 1e12;

/// All bytes of a regular file of at most `limit` bytes.
///
/// # Errors
/// [`FileError`] with the path: no such file, no regular file, or one that is larger.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>, FileError> {
    read_within(path, limit).map_err(|source| FileError { action: "read", path: path.into(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pipe without a writer is answered at once.
    #[cfg(unix)]
    #[test]
    fn pipes_are_not_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo");
        assert!(made.success());
        let said = read(&pipe, MODEL_BYTES).expect_err("refused").to_string();
        assert!(said.ends_with("pipe: it is a device, pipe or socket, not a regular file"), "{said}");
    }
}
