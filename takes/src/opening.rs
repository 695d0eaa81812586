//! Files that name files: which is being opened because of which, so that none is opened because of itself.
//!
//! A scene names the performance that it puts on a character, and key poses; key poses name performances, which are scenes.
//! An [`Opening`] is the chain of files that led to the one being opened, the youngest first, and knows how the next one is
//! opened: the modules that read such files are handed it, because [`crate::open()`] opens retargeted motions by them.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::MOST_NESTED;
use crate::{Ask, Take, TakeError};

/// How a file is opened because of others.
pub(crate) type Open = fn(&Path, &Ask, &Opening) -> Result<Take, TakeError>;

/// The files that led to the one being opened.
#[derive(Clone)]
pub(crate) struct Opening<'a> {
    open: Open,
    /// The youngest file: its path as written, and as the file system knows it.
    file: Option<(&'a Path, PathBuf)>,
    by: Option<&'a Opening<'a>>,
}

impl<'a> Opening<'a> {
    /// Of a file that a person names.
    pub(crate) fn new(open: Open) -> Self {
        Self { open, file: None, by: None }
    }

    /// The chain with one more file, whose references are opened next.
    ///
    /// # Errors
    /// [`TakeError::Cycle`] if it is in the chain already, [`TakeError::Nested`] beyond [`MOST_NESTED`] files.
    pub(crate) fn within(&'a self, file: &'a Path) -> Result<Self, TakeError> {
        let identity = fs::canonicalize(file).unwrap_or_else(|_| file.to_owned());
        let mut chain = vec![file.display().to_string()];
        let mut younger = Some(self);
        while let Some(opening) = younger {
            if let Some((path, known)) = &opening.file {
                chain.push(path.display().to_string());
                if *known == identity {
                    chain.reverse();
                    return Err(TakeError::Cycle { chain });
                }
            }
            younger = opening.by;
        }
        if chain.len() > MOST_NESTED {
            return Err(TakeError::Nested { path: file.display().to_string() });
        }
        Ok(Self { open: self.open, file: Some((file, identity)), by: Some(self) })
    }

    /// The take of a file that the youngest one names.
    ///
    /// # Errors
    /// As [`crate::open()`].
    pub(crate) fn take(&self, path: &Path, ask: &Ask) -> Result<Take, TakeError> {
        (self.open)(path, ask, self)
    }
}
