//! Single files: written whole or not at all, and never over an input.
//!
//! [`ReadFiles`] knows the inputs of a run and finds them under every name: through symbolic links, `.` and `..`
//! (canonical paths), hard links and names in other case (device and inode, on Unix).

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::error::{FolderError, Foreign};
use super::interrupt;
use super::staging;

/// The files that a run has read.
#[derive(Debug, Clone, Default)]
pub(super) struct ReadFiles(Vec<ReadFile>);

#[derive(Debug, Clone)]
struct ReadFile {
    named: PathBuf,
    canonical: Option<PathBuf>,
    inode: Option<(u64, u64)>,
}

impl ReadFile {
    fn of(path: &Path) -> Self {
        Self { named: path.into(), canonical: fs::canonicalize(path).ok(), inode: inode(path) }
    }

    fn is(&self, other: &Self) -> bool {
        (self.canonical.is_some() && self.canonical == other.canonical)
            || (self.inode.is_some() && self.inode == other.inode)
    }
}

/// Device and inode of the file that a path leads to; folders are no inputs.
#[cfg(unix)]
fn inode(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    fs::metadata(path).ok().filter(|m| !m.is_dir()).map(|m| (m.dev(), m.ino()))
}

#[cfg(not(unix))]
fn inode(_: &Path) -> Option<(u64, u64)> {
    None
}

impl ReadFiles {
    /// Looks the files up now; those that do not exist count as not read.
    pub(super) fn new(paths: &[PathBuf]) -> Self {
        Self(paths.iter().map(|path| ReadFile::of(path)).collect())
    }

    /// The one of them that a path leads to.
    fn find(&self, path: &Path) -> Option<&ReadFile> {
        if self.0.is_empty() || fs::symlink_metadata(path).is_err() {
            return None;
        }
        let file = ReadFile::of(path);
        self.0.iter().find(|read| read.is(&file))
    }

    /// Refuses a path that leads to one of them; `shown` is its name in the error.
    pub(super) fn refuse(&self, path: &Path, shown: &Path) -> Result<(), FolderError> {
        match self.find(path) {
            Some(read) => Err(FolderError::Input { path: shown.into(), input: read.named.clone() }),
            None => Ok(()),
        }
    }
}

/// Whether a path leads to one of the files that were read, under any name.
pub fn was_read(path: &Path, reads: &[PathBuf]) -> bool {
    ReadFiles::new(reads).find(path).is_some()
}

/// What is at a path: nothing, a regular file, or what cannot be replaced.
pub(super) fn kind(path: &Path) -> io::Result<Result<Option<fs::Metadata>, Foreign>> {
    Ok(match fs::symlink_metadata(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => return Err(e),
        Ok(meta) if meta.is_symlink() => Err(Foreign::Link),
        Ok(meta) if meta.is_dir() => Err(Foreign::Folder),
        Ok(meta) if !meta.is_file() => Err(Foreign::Special),
        Ok(meta) => Ok(Some(meta)),
    })
}

/// Moves a file to a name that nobody has; whether it could.
pub(super) fn place(from: &Path, to: &Path) -> io::Result<bool> {
    // a hard link is the portable way to make a name only if it does not exist
    match fs::hard_link(from, to) {
        Ok(()) => fs::remove_file(from).map(|()| true),
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Ok(false),
        // file systems without hard links
        Err(_) => match fs::symlink_metadata(to) {
            Ok(_) => Ok(false),
            Err(_) => fs::rename(from, to).map(|()| true),
        },
    }
}

/// Whether a file that exists may be replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overwrite {
    /// No.
    Refuse,
    /// Yes, if it is a regular file and no input.
    Allow,
}

/// Tells whether [`write_file`] may write to a path, without writing: for the start of a long run.
///
/// # Errors
/// As [`write_file`], but for those of writing.
pub fn check_file(path: &Path, overwrite: Overwrite, reads: &[PathBuf]) -> Result<(), FolderError> {
    ReadFiles::new(reads).refuse(path, path)?;
    match kind(path).map_err(FolderError::io("write", path))? {
        Err(why) => Err(FolderError::NotAFile { path: path.into(), why }),
        Ok(Some(_)) if overwrite == Overwrite::Refuse => Err(FolderError::Exists { path: path.into() }),
        Ok(_) if path.file_name().is_none() => {
            Err(FolderError::NotAFile { path: path.into(), why: Foreign::Folder })
        }
        Ok(_) => Ok(()),
    }
}

/// Writes a file whole or not at all: under a temporary name beside it, synchronised with the disk, then renamed.
///
/// The temporary file is removed if writing fails and if the process is interrupted.
///
/// * `reads`: files the run has read; they are never replaced
///
/// # Errors
/// `Input` for a file of `reads`, `NotAFile` for a symbolic link (it is not followed), a folder, a device or a pipe, `Exists`
/// for a file that exists and `Overwrite::Refuse`, `Io` of the file system. What was there is then untouched.
pub fn write_file(
    path: &Path,
    bytes: &[u8],
    overwrite: Overwrite,
    reads: &[PathBuf],
) -> Result<(), FolderError> {
    check_file(path, overwrite, reads)?;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (mut file, temporary) = staging::temporary_file(folder).map_err(FolderError::io("write", path))?;
    let mut save = || file.write_all(bytes).and_then(|()| file.sync_all());
    save().map_err(FolderError::io("write", path))?;
    let placed = {
        let _pass = interrupt::pass();
        match overwrite {
            Overwrite::Allow => fs::rename(temporary.path(), path).map(|()| true),
            Overwrite::Refuse => place(temporary.path(), path),
        }
    };
    match placed.map_err(FolderError::io("write", path))? {
        true => temporary.keep(),
        false => return Err(FolderError::Exists { path: path.into() }),
    }
    Ok(())
}
