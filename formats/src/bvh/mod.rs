//! Biovision BVH: a hierarchy of joints with offsets and channels, and a block of channel values.
//!
//! In: bytes as found in the wild. Out: [`Bvh`], the file as it is (its own units, degrees); from it
//! [`import`] makes a [`Clip`] and an [`ImportReport`] of all that was guessed; [`write()`] makes text of
//! a clip.
//!
//! | file | holds |
//! |---|---|
//! | `number` | correctly rounded decimals, read |
//! | `fixed` | the same, written |
//! | `parse` | bytes to [`Bvh`], errors with line and column |
//! | `pose` | where the joints of a frame are |
//! | `guess` | the unit of length |
//! | `up` | the vertical axis |
//! | `rate` | the frame rate |
//! | `t_pose` | an inserted T-pose |
//! | `glitches` | joints that jump |
//! | `offsets` | joint offsets that move: held, or slides |
//! | `import` | [`Bvh`] to [`Clip`] |
//! | `write` | [`Clip`] to text |
//!
//! # What the numbers mean
//!
//! With `C_j` the product of a joint's rotation channels from left to right, the first channel the
//! outermost factor: `world_j = world_parent · T(offset_j) · C_j`. Position channels *replace* the
//! components of the offset, for the root as for any other joint, as MotionBuilder and the CMU
//! conversions have it; a component without a channel keeps the offset's.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::FileError;
use super::limits::{self, CLIP_BYTES};
use motion::Clip;

mod fixed;
mod glitches;
mod guess;
mod import;
mod number;
mod offsets;
mod parse;
mod pose;
mod rate;
mod t_pose;
mod up;
mod write;

pub use glitches::{Glitches, NamedGlitch};
pub use guess::{Candidate, Chosen, Units};
pub use import::{ImportError, ImportOptions, ImportReport, import};
pub use offsets::{Moved, OffsetRule, Offsets};
pub use parse::{BvhError, BvhFault};
pub use rate::FrameRate;
pub use t_pose::{TPose, TPoseRule};
pub use up::{Axis, Heights, UpAxis};
pub use write::{WriteError, WriteOptions, write};

/// One number of a frame: a coordinate or an angle about one axis (0 x, 1 y, 2 z).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// `Xposition` …, file units.
    Position(usize),
    /// `Xrotation` …, degrees.
    Rotation(usize),
}

/// A joint as the file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct BvhJoint {
    /// Name, white space inside kept, as `mixamorig:Upper Chest`.
    pub name: String,
    /// Index of the parent, smaller than the joint's own; `None` for the root, which is first.
    pub parent: Option<usize>,
    /// Origin in the parent's frame when all channels are zero, file units.
    pub offset: [f64; 3],
    /// Channels in the order of the file.
    pub channels: Vec<Channel>,
    /// Where the joint's values start in a frame.
    pub channels_at: usize,
    /// Offsets of its `End Site`s, file units; usually one for a joint without children.
    pub ends: Vec<[f64; 3]>,
}

/// A BVH file: nothing converted, nothing guessed.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    /// Joints in the order of the file, parents first.
    pub joints: Vec<BvhJoint>,
    /// Seconds from frame to frame, as printed.
    pub frame_time_s: f64,
    /// One unit of the last printed digit of the frame time, s: `0.0083333` has 1e-7.
    pub frame_time_digit_s: f64,
    /// Numbers in a frame.
    pub channels: usize,
    /// Number of frames; may be 0.
    pub frames: usize,
    /// Channel values, `frames × channels`, file units and degrees.
    pub motion: Vec<f64>,
}

impl Bvh {
    /// Values of a frame, length `channels`.
    pub fn frame(&self, frame: usize) -> &[f64] {
        &self.motion[frame * self.channels..(frame + 1) * self.channels]
    }
}

/// Why a BVH file did not become a clip, or a clip no file.
#[derive(Debug, Error)]
pub enum BvhFileError {
    /// The file could not be opened, read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The text is not BVH.
    #[error("{}\n  --> {}:{}:{}", source.fault, path.display(), source.line, source.column)]
    Parse {
        /// The file.
        path: PathBuf,
        /// What was found and where.
        source: BvhError,
    },
    /// The file is BVH but holds no clip.
    #[error("{source}\n  --> {}", path.display())]
    Import {
        /// The file.
        path: PathBuf,
        /// What is missing.
        source: ImportError,
    },
    /// The clip cannot be written as BVH.
    #[error("{source}\n  --> {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        source: WriteError,
    },
}

/// Reads a clip and a report of what was guessed.
///
/// # Errors
/// [`BvhFileError`]; every message names the path, and the line and column where there is one.
pub fn read_file(path: &Path, options: &ImportOptions) -> Result<(Clip, ImportReport), BvhFileError> {
    let bytes = limits::read(path, CLIP_BYTES)?;
    let bvh = Bvh::parse(&bytes).map_err(|source| BvhFileError::Parse { path: path.into(), source })?;
    import(&bvh, options).map_err(|source| BvhFileError::Import { path: path.into(), source })
}

/// Writes a clip; whole or not at all.
///
/// # Errors
/// [`BvhFileError`] with the path.
pub fn write_file(path: &Path, clip: &Clip, options: &WriteOptions) -> Result<(), BvhFileError> {
    let text = write(clip, options).map_err(|source| BvhFileError::Write { path: path.into(), source })?;
    Ok(super::write(path, text.as_bytes())?)
}
