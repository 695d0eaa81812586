//! Every reader and writer: text and bytes to clips, characters and traces, and back.
//!
//! In: paths, bytes. Out: clips, characters, traces and reports of what was read; files. Parsers only parse; what a file
//! does not say is guessed by its importer and reported. Degrees and file units stop at this border: inside are metres and
//! radians, Y up.
//!
//! | module | holds |
//! |---|---|
//! | [`bvh`] | Biovision hierarchy: read, guess units and up axis, write |
//! | [`glb`] | binary glTF 2.0: write skeleton, skinned solids, animation |
//! | [`mjcf`] | MuJoCo's XML: bodies, joints, geoms, inertias, read and written |
//! | [`urdf`] | the robot description of ROS: links, joints, inertias |
//! | [`model`] | characters from MJCF and URDF |
//! | [`model_file`] | what both of these are read into |
//! | [`mujoco_layout`] | between our vectors and MuJoCo's |
//! | [`table`] | the formats once: endings, what is kept and lost, [`open_clip`], [`open_model`] |
//! | [`trace_npz`] | a trace as numpy arrays, written and read |
//! | [`foresight_npz`] | offsets that foresight chose, written and read |
//! | [`example_file`] | a learned edit, written and read |
//! | [`style_file`] | a set of style components, written and read |
//! | [`analysis`] | an analysis as CSV, MOT and npz |
//! | [`limits`] | how much a file may hold; reading it |
//! | [`place`] | places in text files |
//! | [`xml`] | XML whose elements know their place |

use std::io::Write;
use std::path::{Path, PathBuf};

use thiserror::Error;

pub mod analysis;
mod attributes;
pub mod bvh;
pub mod example_file;
pub mod foresight_npz;
pub mod glb;
pub mod limits;
pub mod mjcf;
pub mod model;
pub mod model_file;
pub mod mujoco_layout;
pub mod place;
pub mod style_file;
pub mod table;
pub mod trace_npz;
pub mod urdf;
mod vocabulary;
pub mod xml;

pub use example_file::ExampleFileError;
pub use style_file::StyleFileError;
pub use table::{ClipFileError, ClipOut, FORMATS, Format, format_of, open_clip, open_model};
pub use trace_npz::TraceFileError;

/// A file that could not be read or written.
#[derive(Debug, Error)]
#[error("cannot {action} {}: {source}", path.display())]
pub struct FileError {
    /// `read` or `write`.
    pub action: &'static str,
    /// The file.
    pub path: PathBuf,
    /// What the operating system said.
    pub source: std::io::Error,
}

/// Writes a file whole or not at all: to a temporary name beside it, which is then renamed.
///
/// # Errors
/// [`FileError`] with the path; an earlier file of that name is then untouched.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(name);
    let save = || -> std::io::Result<()> {
        let mut file = std::fs::File::create(&temporary)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        drop(file);
        std::fs::rename(&temporary, path)
    };
    save().map_err(|source| {
        let _ = std::fs::remove_file(&temporary);
        FileError { action: "write", path: path.into(), source }
    })
}
