//! Why output cannot be written: what was found, what is allowed, what to do.

use std::fmt;
use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Why a file in an output folder may not be replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foreign {
    /// The manifest of the folder does not list it, or there is no manifest.
    NotListed,
    /// An earlier run wrote it, and its content was changed afterwards.
    Changed,
    /// It is a symbolic link (also one to nothing).
    Link,
    /// It is a folder, and a file is to be written.
    Folder,
    /// It is a file, and a folder of this name is needed.
    File,
    /// A device, a pipe or a socket.
    Special,
}

impl fmt::Display for Foreign {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::NotListed => "was not written by an earlier run",
            Self::Changed => "was changed after an earlier run wrote it",
            Self::Link => "is a symbolic link",
            Self::Folder => "is a folder",
            Self::File => "is a file where a folder is needed",
            Self::Special => "is not a regular file",
        })
    }
}

/// Output that cannot be written, or must not be.
#[derive(Debug, Error)]
pub enum FolderError {
    /// A file that this run would replace is not ours.
    #[error(
        "{} {why} and would be replaced; allowed: files that an earlier run wrote and nobody changed. Give another folder \
         with --out, or move it away",
        path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is.
        why: Foreign,
    },
    /// A file that this run would replace is one of its inputs.
    #[error(
        "{} would be replaced, but it is an input of this run ({}); inputs are never overwritten. Give another name or \
         folder for the output (--out), or move the input",
        path.display(), input.display()
    )]
    Input {
        /// The file to be written.
        path: PathBuf,
        /// The input that it is, as it was named.
        input: PathBuf,
    },
    /// A single file exists already.
    #[error("{} exists already; allowed: a new name, or --force to replace it", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// A single file is to replace something that is not a plain file.
    #[error("cannot write {}: it {why}; allowed: a new name or a regular file. Give another name", path.display())]
    NotAFile {
        /// What was named.
        path: PathBuf,
        /// What it is.
        why: Foreign,
    },
    /// The output folder is something else.
    #[error(
        "cannot write into {}: it is {what}, not a folder; allowed: a folder, or a name that does not exist (--out)",
        path.display()
    )]
    NotAFolder {
        /// What was named.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// The manifest of a folder cannot be used.
    #[error(
        "{} cannot be used ({why}), so it is unknown which files here may be replaced. Give another folder with --out, or \
         move the files and the manifest away",
        path.display()
    )]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// A name that does not stay in the folder.
    #[error(
        "`{name}` cannot be the name of an output file: {why}; allowed: relative names such as `plots/motion.svg`"
    )]
    Name {
        /// The name.
        name: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// Two outputs want one name.
    #[error("`{name}` is the name of two output files: `{first}` and `{second}`")]
    Twice {
        /// The name.
        name: String,
        /// The first output's key.
        first: String,
        /// The second output's key.
        second: String,
    },
    /// A file was added to the folder, but nothing was written to its path.
    #[error("the output file `{name}` was announced but not written")]
    NotWritten {
        /// The name.
        name: String,
    },
    /// Another run has written into the folder between two commits of this one.
    #[error(
        "another run has written into {} meanwhile; what this run would add to its own files was not written. Give each run \
         a folder of its own (--out)",
        dir.display()
    )]
    Overtaken {
        /// The folder.
        dir: PathBuf,
    },
    /// Another process holds the folder for its commit and does not let go.
    #[error("another process has been writing into {} for {waited_s} s; try again when it has ended", dir.display())]
    Busy {
        /// The folder.
        dir: PathBuf,
        /// How long was waited, s.
        waited_s: u64,
    },
    /// The file system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// `write`, `write into`, `read` or `remove`.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
}

impl FolderError {
    /// Whether what was asked for is at fault (exit code 2) and not the run (exit code 1).
    #[must_use]
    pub fn is_input(&self) -> bool {
        match self {
            Self::Foreign { .. }
            | Self::Input { .. }
            | Self::Exists { .. }
            | Self::NotAFile { .. }
            | Self::NotAFolder { .. }
            | Self::Manifest { .. }
            | Self::Name { .. } => true,
            Self::Twice { .. }
            | Self::NotWritten { .. }
            | Self::Overtaken { .. }
            | Self::Busy { .. }
            | Self::Io { .. } => false,
        }
    }

    /// For `map_err`: the operation and its path.
    pub(super) fn io(action: &'static str, path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        move |source| Self::Io { action, path, source }
    }
}
