//! A temporary folder for what is made once and then moved as a whole, such as an environment in a cache.
//!
//! In: the folder beside which it is made. Out: an empty folder under a name nobody else has, removed with all that is in it
//! when the value is dropped and at Ctrl-C; what a killed process left is removed by the next one.

use std::io;
use std::path::{Path, PathBuf};

use super::commit::JOURNAL;
use super::staging::{self, Staging};

/// A temporary folder. See the module header.
///
/// # Examples
/// ```
/// # use takes::results::folder::Scratch;
/// # fn main() -> std::io::Result<()> {
/// # let home = tempfile::tempdir()?;
/// let scratch = Scratch::beside(&home.path().join("cache"))?;
/// std::fs::write(scratch.path().join("half"), "…")?;
/// std::fs::rename(scratch.path(), home.path().join("cache/whole"))?;
/// drop(scratch);
/// assert_eq!(std::fs::read_dir(home.path().join("cache"))?.count(), 1);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Scratch {
    _staging: Staging,
    path: PathBuf,
}

impl Scratch {
    /// Makes one in `home`, which is made if it does not exist, and removes those of processes that live no more.
    ///
    /// # Errors
    /// Of the file system.
    pub fn beside(home: &Path) -> io::Result<Self> {
        staging::remove_ownerless(home, JOURNAL);
        let staging = Staging::create(home)?;
        Ok(Self { path: staging.files(), _staging: staging })
    }

    /// The folder; it may be moved away.
    pub fn path(&self) -> &Path {
        &self.path
    }
}
