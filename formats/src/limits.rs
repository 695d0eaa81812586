//! How much a file may hold, and reading it within that.
//!
//! In: a path and a number of bytes. Out: the bytes of a regular file, or an error at once: a device, a pipe or a folder is not
//! read at all, and a file that is too large is not read to its end. Work and memory of every reader are near linear in what
//! these limits allow.

use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::path::Path;

use crate::FileError;

/// Largest model file (MJCF, URDF) with all it includes.
pub const MODEL_BYTES: u64 = 64 << 20;
/// Largest motion file: two hours of a body of 100 joints at 120 Hz have 2 GB.
pub const CLIP_BYTES: u64 = 2 << 30;
/// Largest trace on disk.
pub const TRACE_BYTES: u64 = 8 << 30;
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
    let get = || -> std::io::Result<Vec<u8>> {
        let told = std::fs::metadata(path)?;
        if !told.is_file() {
            let what = if told.is_dir() { "a folder" } else { "a device, pipe or socket" };
            return Err(Error::new(ErrorKind::InvalidInput, format!("it is {what}, not a regular file")));
        }
        let too_large = || {
            let text = format!("it is larger than {}, the most that is read", in_words(limit));
            Err(Error::new(ErrorKind::FileTooLarge, text))
        };
        if told.len() > limit {
            return too_large();
        }
        // files under /proc state no length, and a file may grow
        let mut bytes = Vec::with_capacity(told.len() as usize);
        File::open(path)?.take(limit + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > limit { too_large() } else { Ok(bytes) }
    };
    get().map_err(|source| FileError { action: "read", path: path.into(), source })
}

fn in_words(bytes: u64) -> String {
    match bytes {
        b if b >= 1 << 30 => format!("{} GiB", b >> 30),
        b if b >= 1 << 20 => format!("{} MiB", b >> 20),
        b => format!("{b} bytes"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(path: &Path, limit: u64) -> String {
        read(path, limit).expect_err("refused").to_string()
    }

    #[test]
    fn a_file_is_read_up_to_its_limit() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("ten");
        std::fs::write(&path, [b'x'; 10]).expect("a file");
        assert_eq!(read(&path, 10).expect("ten bytes"), [b'x'; 10]);
        assert!(said(&path, 9).ends_with("it is larger than 9 bytes, the most that is read"));
        assert!(said(folder.path(), 9).ends_with("it is a folder, not a regular file"));
    }

    /// Endless devices and pipes without a writer are answered at once.
    #[cfg(unix)]
    #[test]
    fn devices_and_pipes_are_not_read() {
        let what = "it is a device, pipe or socket, not a regular file";
        assert!(said(Path::new("/dev/zero"), MODEL_BYTES).ends_with(what));
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo");
        assert!(made.success());
        assert!(said(&pipe, MODEL_BYTES).ends_with(what));
    }
}
