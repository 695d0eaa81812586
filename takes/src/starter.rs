//! A starter project: a scene with two edits, the body that performs it, and how to go on.
//!
//! In: a folder. Out: three files in it, or none. They are a person's from then on: no manifest lists them, so no run
//! replaces or removes them.

use std::path::{Path, PathBuf};
use std::{fs, io};

use scenes::library;

use crate::results::folder::{FolderError, Overwrite, write_file};

/// The scene of the project.
pub const SCENE: &str = "hello.ron";

/// Why there is no project.
#[derive(Debug, thiserror::Error)]
pub enum StarterError {
    /// A file of that name is there.
    #[error("{} exists already, and nothing is replaced; allowed: a folder without {}", .0.display(), names())]
    Exists(PathBuf),
    /// No folder.
    #[error("cannot make the folder {}: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file that cannot be written.
    #[error(transparent)]
    File(#[from] FolderError),
}

impl StarterError {
    /// Whether the folder named is at fault, not the writing.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Exists(_) => true,
            Self::Folder { source, .. } => {
                matches!(source.kind(), io::ErrorKind::AlreadyExists | io::ErrorKind::NotADirectory)
            }
            Self::File(e) => e.is_input(),
        }
    }
}

/// Names and texts.
fn files() -> [(&'static str, &'static str); 3] {
    let human = library::find(Path::new("library:characters/human.ron")).map_or("", |entry| entry.text());
    [
        (SCENE, include_str!("../starter/hello.ron")),
        ("human.ron", human),
        ("README.md", include_str!("../starter/README.md")),
    ]
}

fn names() -> String {
    files().map(|(name, _)| name).join(", ")
}

/// Writes the project into a folder, which is made if it does not exist; the files written.
///
/// # Errors
/// [`StarterError`]; none of the files is then there that was not before.
pub fn write(dir: &Path) -> Result<Vec<PathBuf>, StarterError> {
    let files = files().map(|(name, text)| (dir.join(name), text));
    if let Some((path, _)) = files.iter().find(|(path, _)| fs::symlink_metadata(path).is_ok()) {
        return Err(StarterError::Exists(path.clone()));
    }
    fs::create_dir_all(dir).map_err(|source| StarterError::Folder { path: dir.into(), source })?;
    let mut written = Vec::new();
    for (path, text) in files {
        if let Err(e) = write_file(&path, text.as_bytes(), Overwrite::Refuse, &[]) {
            // only what was written just now; a file that cannot be removed is not worth hiding the fault
            written.iter().for_each(|path| drop(fs::remove_file(path)));
            return Err(e.into());
        }
        written.push(path);
    }
    Ok(written)
}
