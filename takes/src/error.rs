//! Why there is no take: anything wrong with the input and the files it names.

use bodies::anthropometry::GuessError;
use bodies::pose_map::PoseMapError;
use formats::ClipFileError;
use motion::CycleError;
use motion::ik::IkError;
use scenes::SceneError;
use scenes::library::UnknownName;

use crate::results::number;

/// Why there is no take.
#[derive(Debug, thiserror::Error)]
pub enum TakeError {
    /// A scene or character file.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A name that is no file and not in the library.
    #[error(transparent)]
    Name(#[from] UnknownName),
    /// A clip's file.
    #[error(transparent)]
    ClipFile(#[from] ClipFileError),
    /// A physics model.
    #[error(transparent)]
    Model(#[from] formats::model::ImportError),
    /// No body for a clip.
    #[error(
        "{path}: {source}\n  help: `contrapposto convert` works without a body; a body for a skeleton that is not guessed is a character file of its links, given with --body FILE.ron (docs/SCENES.md)"
    )]
    Body {
        /// The clip.
        path: String,
        /// Why.
        source: GuessError,
    },
    /// A body that does not fit the clip.
    #[error("the body does not fit {path}: {source}")]
    Map {
        /// The clip.
        path: String,
        /// Why.
        source: PoseMapError,
    },
    /// A clip too short to perform.
    #[error("{path}: the clip has {frames} frame(s); a motion needs at least 2")]
    Short {
        /// The clip.
        path: String,
        /// Frames found.
        frames: usize,
    },
    /// A clip too long to perform.
    #[error("{path}: {text}", text = too_long(*duration_s, *rate_hz))]
    Long {
        /// The clip.
        path: String,
        /// Its length, s.
        duration_s: f64,
        /// Frames or control steps per second, whichever are more.
        rate_hz: f64,
    },
    /// A span that is not in the clip.
    #[error(
        "{path}: no span {from}..{to} s; the clip lasts {duration_s:.3} s, and a span has at least two frames"
    )]
    Span {
        /// The clip.
        path: String,
        /// Begin asked for, s.
        from: f64,
        /// End asked for, s.
        to: f64,
        /// Length of the clip, s.
        duration_s: f64,
    },
    /// A clip that does not go on.
    #[error("{path}: {source}")]
    Cycling {
        /// The clip.
        path: String,
        /// Why.
        source: CycleError,
    },
    /// A loop of what is no clip.
    #[error(
        "{path}: only clips (.bvh, or scenes with `motion: Clip(…)`) go on by repeating a cycle of themselves"
    )]
    Loop {
        /// The scene.
        path: String,
    },
    /// Contacts for what has its own.
    #[error(
        "{path}: --contacts is for clips, and for retargeted motion with --foresight; a script says itself what stands, and the steps of a retargeted motion are changed with `contacts: \"FILE.ron\"`"
    )]
    Contacts {
        /// The scene.
        path: String,
    },
    /// Legs that cannot be planted.
    #[error(
        "{path}: its feet cannot be planted: {source}\n  help: --root pinned performs it without the ground"
    )]
    Legs {
        /// The clip.
        path: String,
        /// Why.
        source: IkError,
    },
    /// A file that is named by what it names.
    #[error("`{file}` refers to itself: {chain}", file = chain[0], chain = chain.join(" → "))]
    Cycle {
        /// The files from it to itself.
        chain: Vec<String>,
    },
    /// Files that name files, too many in a row.
    #[error(
        "`{path}` is opened for a file that is opened for another, and so on; allowed: up to {MOST_NESTED} files in a row"
    )]
    Nested {
        /// The last of them.
        path: String,
    },
    /// Edits beside a scene.
    #[error("{path}: edits beside the file are for clips; a scene has its own list, `edits`")]
    Edits {
        /// The scene.
        path: String,
    },
    /// Something else than a scene or clip.
    #[error("{0}: neither a scene (.ron) nor a clip ({clips}){models}", models = models(_0), clips = formats::table::endings(|f| f.read_clip.is_some()))]
    Kind(String),
}

/// Where a physics model is read, if the path is one.
fn models(path: &str) -> &'static str {
    if formats::table::is_model(std::path::Path::new(path)) {
        "; a physics model is read by inspect, convert and crosscheck"
    } else {
        ""
    }
}

/// Longer chains of files that name each other are refused.
pub(crate) const MOST_NESTED: usize = 16;

/// The most frames or control steps of a motion: half an hour at 240 Hz makes a trace of some gigabytes.
pub const MOST_STEPS: f64 = 5e5;

/// What is said of a motion that is too long.
pub(crate) fn too_long(duration_s: f64, rate_hz: f64) -> String {
    let shown = if duration_s < 1e7 { format!("{duration_s:.1}") } else { format!("{duration_s:e}") };
    let most = MOST_STEPS / rate_hz;
    format!(
        "the motion lasts {shown} s; at {} Hz (frames or control steps) allowed: up to {most:.0} s",
        number(rate_hz)
    )
}
