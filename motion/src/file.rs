//! Files that are read whole, within a limit.
//!
//! In: a path and a number of bytes. Out: the bytes of a regular file, or an error at once: a device, a pipe or a folder is not read at
//! all, and a file that is too large is not read to its end. What the limits of the formats are is said where they are read.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// All bytes of a regular file of at most `limit` bytes.
///
/// # Errors
/// No such file, no regular file, or one that is larger.
pub fn read_within(path: &Path, limit: u64) -> Result<Vec<u8>> {
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
        read_within(path, limit).expect_err("refused").to_string()
    }

    #[test]
    fn a_file_is_read_up_to_its_limit() {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"));
        let length = std::fs::metadata(path).expect("the manifest").len();
        assert_eq!(read_within(path, length).expect("within").len() as u64, length);
        assert_eq!(said(path, 9), "it is larger than 9 bytes, the most that is read");
        assert_eq!(said(Path::new("/"), 9), "it is a folder, not a regular file");
    }

    /// Endless devices are answered at once.
    #[cfg(unix)]
    #[test]
    fn devices_are_not_read() {
        let what = "it is a device, pipe or socket, not a regular file";
        assert_eq!(said(Path::new("/dev/zero"), 1 << 30), what);
    }
}
