//! The formats, once: what each is called, how its files end, what it keeps and loses, and who reads and writes it.
//!
//! In: a path. Out: a clip or a physics model, whatever the format. A new format is a file beside this one and a row of
//! [`FORMATS`]; the commands, their help and `docs/FORMATS.md` take it from here.

use std::path::Path;

use motion::{Clip, Shape};
use thiserror::Error;

use crate::bvh::{self, BvhFileError, ImportOptions, ImportReport};
use crate::glb::{self, GlbError};
use crate::model::{self, ImportError, Imported};

/// A clip as a file had it, with what was guessed.
type ReadClip = fn(&Path, &ImportOptions) -> Result<(Clip, ImportReport), ClipFileError>;
/// The bytes of a clip.
type WriteClip = fn(&ClipOut) -> Result<Vec<u8>, ClipFileError>;
/// A character as a model file had it, with what was left out.
type ReadModel = fn(&Path, &model::ImportOptions) -> Result<Imported, ImportError>;

/// A file format.
pub struct Format {
    /// The name of the field.
    pub name: &'static str,
    /// How its files end, without the dot, lower case; the first is what we write.
    pub endings: &'static [&'static str],
    /// What a file of ours or of others keeps of a motion or a body.
    pub keeps: &'static str,
    /// What is lost on the way in or out.
    pub loses: &'static str,
    /// Reads a clip.
    pub read_clip: Option<ReadClip>,
    /// Writes a clip.
    pub write_clip: Option<WriteClip>,
    /// Whether a clip written has the unit of length asked for; otherwise metres.
    pub units: bool,
    /// Reads a physics model.
    pub read_model: Option<ReadModel>,
    /// Whether a body is written ([`crate::mjcf::write`]).
    pub writes_body: bool,
}

/// A clip on its way to a file.
#[derive(Clone, Copy, Debug)]
pub struct ClipOut<'a> {
    /// The motion.
    pub clip: &'a Clip,
    /// Solids to show: a link and a shape in its frame, m; may be empty.
    pub solids: &'a [(usize, Shape)],
    /// A colour of each link; may be empty.
    pub colors: &'a [Option<[u8; 3]>],
    /// What the file calls the motion.
    pub name: &'a str,
    /// Metres per unit of length in the file, where the format has a choice.
    pub metres_per_unit: f64,
}

/// All formats that hold a clip or a body.
pub const FORMATS: &[Format] = &[
    Format {
        name: "BVH",
        endings: &["bvh"],
        keeps: "hierarchy, offsets, every joint's rotation and position channels, frame rate",
        loses: "units and up axis, which are guessed and reported; digits after the sixth decimal; no solids, colours, limits, masses",
        read_clip: Some(|path, options| Ok(bvh::read_file(path, options)?)),
        write_clip: Some(|out| {
            let options = bvh::WriteOptions { metres_per_unit: out.metres_per_unit, ..Default::default() };
            let text = bvh::write(out.clip, &options);
            let text = text.map_err(|source| ClipFileError::Write { source: Box::new(source) })?;
            Ok(text.into_bytes())
        }),
        units: true,
        read_model: None,
        writes_body: false,
    },
    Format {
        name: "glTF 2.0 (binary)",
        endings: &["glb"],
        keeps: "hierarchy, rotations and the root's path at every frame, solids as a skinned mesh, colours; metres, Y up",
        loses: "single precision; no limits, no masses; not read",
        read_clip: None,
        write_clip: Some(|out| {
            let bytes = glb::write(out.clip, out.solids, out.colors, out.name);
            bytes.map_err(|source: GlbError| ClipFileError::Write { source: Box::new(source) })
        }),
        units: false,
        read_model: None,
        writes_body: false,
    },
    Format {
        name: "MJCF (MuJoCo XML)",
        endings: &["xml", "mjcf"],
        keeps: "bodies, joints with ranges, inertias, solids, gravity; written, also the ground and the antagonists' set points",
        loses: "what makes forces and is not read (actuators, tendons, sensors …) refuses the file, or is left out and listed with --dynamics-only; looks",
        read_clip: None,
        write_clip: None,
        units: false,
        read_model: Some(model::open),
        writes_body: true,
    },
    Format {
        name: "URDF",
        endings: &["urdf"],
        keeps: "links, joints with limits, inertials, collision solids",
        loses: "the same, and that joints follow others (mimic); planar joints refuse the file; looks",
        read_clip: None,
        write_clip: None,
        units: false,
        read_model: Some(model::open),
        writes_body: false,
    },
    Format {
        name: "learned edit",
        endings: &["edit"],
        keeps: "examples and kernels of an edit by example, to the bit; numpy arrays in a zip, with words in RON",
        loses: "the clips themselves; `contrapposto propagate` and the edit ByExample of a scene read it",
        read_clip: None,
        write_clip: None,
        units: false,
        read_model: None,
        writes_body: false,
    },
    Format {
        name: "style components",
        endings: &["style"],
        keeps: "bones, mean, components, activations of both clips, how they were found, to the bit; numpy arrays in a zip, with words in RON",
        loses: "the clips themselves; `contrapposto style` and the edit Style of a scene read it",
        read_clip: None,
        write_clip: None,
        units: false,
        read_model: None,
        writes_body: false,
    },
];

/// Why a file gave no clip, or a clip no file.
#[derive(Debug, Error)]
pub enum ClipFileError {
    /// A BVH file.
    #[error(transparent)]
    Bvh(#[from] BvhFileError),
    /// A clip that the format cannot hold.
    #[error(transparent)]
    Write {
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A file whose ending is no clip's.
    #[error("{path}: cannot read a clip from this; allowed: {allowed}")]
    Kind {
        /// The file.
        path: String,
        /// Endings that can be read.
        allowed: String,
    },
}

/// The format a file's name says; `None` if it is none of [`FORMATS`]. Upper and lower case are the same.
pub fn format_of(path: &Path) -> Option<&'static Format> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    FORMATS.iter().find(|format| format.endings.contains(&ending.as_str()))
}

/// Whether the file's name says a clip that can be read.
pub fn is_clip(path: &Path) -> bool {
    format_of(path).is_some_and(|format| format.read_clip.is_some())
}

/// Whether the file's name says a physics model.
pub fn is_model(path: &Path) -> bool {
    format_of(path).is_some_and(|format| format.read_model.is_some())
}

/// The endings of the formats that `which` picks, as `.bvh, .glb`.
pub fn endings(which: impl Fn(&Format) -> bool) -> String {
    let picked = FORMATS.iter().filter(|format| which(format)).flat_map(|format| format.endings);
    picked.map(|ending| format!(".{ending}")).collect::<Vec<_>>().join(", ")
}

/// Reads a clip and a report of what was guessed.
///
/// # Errors
/// [`ClipFileError`] with the path, and the line and column where there is one.
pub fn open_clip(path: &Path, options: &ImportOptions) -> Result<(Clip, ImportReport), ClipFileError> {
    let Some(read) = format_of(path).and_then(|format| format.read_clip) else {
        let allowed = endings(|format| format.read_clip.is_some());
        return Err(ClipFileError::Kind { path: path.display().to_string(), allowed });
    };
    read(path, options)
}

/// Reads the character of a physics model and a report of what was left out.
///
/// # Errors
/// [`ImportError`]; every message ends in file, line and column. A file with another ending is tried by its root
/// element.
pub fn open_model(path: &Path, options: &model::ImportOptions) -> Result<Imported, ImportError> {
    format_of(path).and_then(|format| format.read_model).unwrap_or(model::open)(path, options)
}

/// The table as Markdown, as `docs/FORMATS.md` has it.
pub fn markdown() -> String {
    let mut text = "| format | files | clip | body | keeps | loses |\n|---|---|---|---|---|---|\n".to_owned();
    let say = |read: bool, write: bool| match (read, write) {
        (true, true) => "read, write",
        (true, false) => "read",
        (false, true) => "write",
        (false, false) => "–",
    };
    for format in FORMATS {
        let files = format.endings.iter().map(|e| format!("`.{e}`")).collect::<Vec<_>>().join(", ");
        text += &format!(
            "| {} | {files} | {} | {} | {} | {} |\n",
            format.name,
            say(format.read_clip.is_some(), format.write_clip.is_some()),
            say(format.read_model.is_some(), format.writes_body),
            format.keeps,
            format.loses
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ending_belongs_to_one_format() {
        let mut all: Vec<&str> = FORMATS.iter().flat_map(|format| format.endings).copied().collect();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count);
        assert!(all.iter().all(|ending| *ending == ending.to_lowercase()));
        assert_eq!(format_of(Path::new("A/B.BVH")).map(|format| format.name), Some("BVH"));
        assert!(format_of(Path::new("bvh")).is_none());
    }

    #[test]
    fn the_page_has_the_table() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/FORMATS.md");
        let text = std::fs::read_to_string(page).expect("docs/FORMATS.md");
        assert!(text.contains(&markdown()), "docs/FORMATS.md should have this table:\n{}", markdown());
    }

    #[test]
    fn a_clip_written_in_a_format_that_is_read_comes_back() {
        let human = bodies::anthropometry::human::human().0;
        let clip = Clip::new(human.skeleton.clone(), 30.0, human.rest.repeat(3));
        let dir = tempfile::tempdir().expect("a folder");
        for format in FORMATS {
            let (Some(read), Some(write)) = (format.read_clip, format.write_clip) else { continue };
            let out = ClipOut { clip: &clip, solids: &[], colors: &[], name: "still", metres_per_unit: 0.01 };
            let path = dir.path().join("clip").with_extension(format.endings[0]);
            std::fs::write(&path, write(&out).expect("bytes")).expect("a file");
            let (back, _) = read(&path, &ImportOptions::default()).expect("a clip");
            assert_eq!((back.frames(), back.rate_hz), (3, 30.0), "{}", format.name);
        }
    }

    #[test]
    fn another_ending_is_refused_with_what_is_allowed() {
        let refused =
            open_clip(Path::new("walk.fbx"), &ImportOptions::default()).expect_err("no such format");
        assert_eq!(refused.to_string(), "walk.fbx: cannot read a clip from this; allowed: .bvh");
    }
}
