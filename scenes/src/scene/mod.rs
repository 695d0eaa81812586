//! Scenes: a scene file, checked, in SI units and with every name resolved.
//!
//! In: a path or a text. Out: a [`Scene`], or a [`SceneError`] at the very value that is wrong. The words are in
//! [`crate::schema`]. A scene is a specification: nothing it names but its character and its patch is opened here.
//!
//! | module | checks |
//! |---|---|
//! | [`script`] | actions, cycles, poses, elements |
//! | [`footwork`] | steps and jumps |
//! | [`motion`] | clips and retargeted motion |
//! | [`edits`] | edits |
//! | [`conditions`], [`disturbances`], [`reactive`] | what acts on the body |

pub mod conditions;
pub mod disturbances;
pub mod edits;
pub mod footwork;
pub mod motion;
pub mod reactive;
pub mod script;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bodies::Character;

use crate::conditions::ConditionsSpec;
use crate::overrides::LOOPS_S;
use crate::schema::SceneRon;
use crate::{Patch, SceneError, Source, StripSpec, TuneSpec, character_file, library};

pub use disturbances::push_of;
pub use edits::{EditKind, SceneEdit, StoredEdit, StyleSpec, edit_of_clip};
pub use motion::{RetargetSpec, SceneSource};
pub use script::ScriptSpec;

/// A checked scene.
pub struct Scene {
    /// The file, kept for errors found later.
    pub source: Source,
    /// Name: the file's stem.
    pub name: String,
    /// The body.
    pub character: Arc<Character>,
    /// Colour of each link, where the character's file has one.
    pub colors: Vec<Option<[u8; 3]>>,
    /// Frames per second of the clips written, Hz; `None`: those of the motion, 120 for a script.
    pub rate_hz: Option<f64>,
    /// Where its motion comes from.
    pub motion: SceneSource,
    /// How long a clip goes on by repeating a cycle of itself, s; `None`: as long as it is.
    pub loop_s: Option<f64>,
    /// Edits in order.
    pub edits: Vec<SceneEdit>,
    /// What acts on the body.
    pub conditions: ConditionsSpec,
    /// How film strips are drawn.
    pub strip: StripSpec,
    /// How it is tuned.
    pub tune: TuneSpec,
    /// Files on disk that it names and is made of, itself included.
    pub files: Vec<PathBuf>,
}

/// Reads a scene and its character.
///
/// # Errors
/// Anything wrong with either file, at its place.
pub fn read(path: &Path) -> Result<Scene, SceneError> {
    let source = Source::read(path)?;
    let name = path.file_stem().map_or_else(|| "scene".into(), |s| s.to_string_lossy().into_owned());
    parse(source, name)
}

/// Builds a scene from a source; its character is looked for beside the source's path.
///
/// # Errors
/// As [`read`].
pub fn parse(source: Source, name: String) -> Result<Scene, SceneError> {
    let ron: SceneRon = source.parse()?;
    let beside = source.beside("character", "character file", &ron.character)?;
    let read = character_file::read_file(&beside)?;
    let (character, colors) = (Arc::new(read.character), read.colors);
    let check = Check { source: &source, character: &character };
    let mut physics = check.physics(&ron)?;
    let mut files = vec![source.path().to_owned(), beside.clone()];
    if let Some(file) = &ron.patch {
        let patch = source.beside("patch", "patch", file)?;
        Patch::read(&patch)?.apply(&mut physics);
        files.push(patch);
    }
    check.motion_or_script(&ron)?;
    let script = check.script_spec(&ron, physics.root, physics.gravity.norm())?;
    let moves = script.moves();
    let motion = check.motion(&ron, &beside, script)?;
    files.extend(motion.files().into_iter().cloned());
    let tune = TuneSpec::read(ron.tune.as_ref(), moves || ron.motion.is_some(), &source)?;
    let edits = check.edits(&ron.edits, &motion)?;
    files.extend(edits.iter().filter_map(|e| e.kind.file().cloned()));
    let conditions = check.conditions(&ron, physics)?;
    files.extend(conditions.programs.iter().map(|program| program.file.clone()));
    files.retain(|file| !library::is_location(file));
    let rate = |x| check.within("rate_hz", x, 1.0, 1000.0, "Hz");
    let rate_hz = ron.rate_hz.map(rate).transpose()?;
    let loop_s = ron.loop_s.map(|x| check.within("loop_s", x, *LOOPS_S.start(), *LOOPS_S.end(), "s"));
    let loop_s = loop_s.transpose()?;
    if loop_s.is_some() && !matches!(motion, SceneSource::Clip(_)) {
        return Err(source.error(
            "loop_s",
            "only a clip goes on by repeating a cycle of itself; allowed: with `motion: Clip(…)`",
        ));
    }
    if ron.strip.figures < 2 || ron.strip.figures > 40 {
        return Err(source.error("strip.figures", format!("{} figures; allowed: 2 to 40", ron.strip.figures)));
    }
    Ok(Scene {
        name,
        rate_hz,
        loop_s,
        motion,
        edits,
        conditions,
        strip: ron.strip,
        tune,
        colors,
        files,
        character,
        source,
    })
}

/// A scene being checked.
pub(crate) struct Check<'a> {
    pub(crate) source: &'a Source,
    pub(crate) character: &'a Character,
}

impl Check<'_> {
    pub(crate) fn within(&self, at: &str, x: f64, lo: f64, hi: f64, unit: &str) -> Result<f64, SceneError> {
        if x >= lo && x <= hi {
            return Ok(x);
        }
        let name = at.rsplit('.').next().unwrap_or(at);
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        Err(self.source.error(at, format!("{name} is {x}{unit}; allowed: {lo} to {hi}{unit}")))
    }
}
