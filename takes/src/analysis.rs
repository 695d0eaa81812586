//! A motion to be analysed: a recorded trace, a clip, or the kinematic motion of a scene, with its body.
//!
//! In: a path. Out: an [`AnalysisInput`]: who moves and how, and on demand its [`Analysis`], the trace for its figures, and
//! its ground forces from other sources (measured, penalty contact, MuJoCo). Nothing is simulated here.
//!
//! ```text
//! trace.npz, folder with one ─→ Trace ─────────────┐
//! clip.bvh ─→ body guessed or given ───────────────┼─→ AnalysisInput ─→ analyze ─→ Analysis, GroundForces
//! scene.ron ─→ kinematic motion ───────────────────┘
//! ```
//!
//! A clip is analysed as it was captured: not clamped to joint limits, which would hide what is wrong.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bodies::Character;
use dynamics::analysis::trace_of;
use dynamics::penalty::PenaltyError;
use dynamics::{
    Analysis, AnalysisError, AnalysisOptions, FloorChoice, GivenBy, GroundForces, RootMode, Trace, analyze,
};
use formats::TraceFileError;
use formats::bvh::ImportOptions;
use motion::smooth::Smoothing;
use motion::{Clip, Vec3};
use plots::View;
use scenes::library::{self, Kind};

use crate::open::open as open_take;
use crate::results::figures::strip_view;
use crate::slides::Slides;
use crate::take::{ClipSource, Source};
use crate::{Ask, Take, TakeError, is_ron};

/// Why a motion cannot be opened or analysed.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisInputError {
    /// A scene, clip or body.
    #[error(transparent)]
    Take(#[from] TakeError),
    /// Neither trace nor clip nor scene.
    #[error("{0}: neither a trace (.npz, or a folder with trace.npz) nor a clip (.bvh) nor a scene (.ron)")]
    Kind(String),
    /// A folder without a trace.
    #[error("{0}: no trace.npz in this folder; allowed: a folder that `contrapposto render` wrote")]
    NoTrace(String),
    /// A trace that cannot be read.
    #[error("{path}: {source}")]
    Trace {
        /// The file.
        path: String,
        /// Why.
        source: TraceFileError,
    },
    /// Joints that no muscle moves.
    #[error(transparent)]
    Slides(#[from] Slides),
    /// A motion that cannot be analysed.
    #[error("{path}: {source}")]
    Analysis {
        /// Where it came from.
        path: String,
        /// Why.
        source: AnalysisError,
    },
    /// A penalty contact that cannot be.
    #[error(transparent)]
    Penalty(#[from] PenaltyError),
    /// A trace of another body or another run.
    #[error("{other}: a trace of {found}; allowed: of {needed}, as in {path}")]
    OtherBody {
        /// The other trace.
        other: String,
        /// Its body.
        found: String,
        /// The first one's body.
        needed: String,
        /// The first one.
        path: String,
    },
}

/// Where a motion came from.
#[derive(Clone, Debug)]
pub enum AnalysisSource {
    /// A recorded run.
    Trace(Box<Trace>),
    /// A clip.
    Clip(Box<ClipSource>),
    /// A scene's kinematic motion.
    Scene,
}

impl AnalysisSource {
    /// One word.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Trace(_) => "trace",
            Self::Clip(_) => "clip",
            Self::Scene => "scene",
        }
    }
}

/// How to analyse; what is not said is chosen by the source.
#[derive(Clone, Copy, Debug, Default)]
pub struct AnalysisSettings {
    /// Smoothing; `None`: automatic for clips and runs with a pinned root, none for other runs and scenes,
    /// which carry no noise.
    pub smoothing: Option<Smoothing>,
    /// Coefficient of friction; `None`: that of the scene, 0.8 else.
    pub friction: Option<f64>,
}

/// A motion with its body. See the module header.
#[derive(Clone, Debug)]
pub struct AnalysisInput {
    /// Name of the file, without folder and ending; of a trace, of its folder.
    pub name: String,
    /// The file that was read.
    pub path: PathBuf,
    /// Where the motion came from.
    pub source: AnalysisSource,
    /// The body.
    pub character: Arc<Character>,
    /// The motion as it was given, on the body's skeleton.
    pub given: Clip,
    /// Colour of each link, where the body has one.
    pub colors: Vec<Option<[u8; 3]>>,
    /// From where its film strips are seen.
    pub view: View,
    gravity: Vec3,
    ground: FloorChoice,
    friction: Option<f64>,
}

/// Opens a trace, a folder with one, a clip or a scene (also by its name in the library); `body` is a character file for a clip.
///
/// # Errors
/// [`AnalysisInputError`].
pub fn open(
    path: &Path,
    body: Option<&Path>,
    import: &ImportOptions,
) -> Result<AnalysisInput, AnalysisInputError> {
    if path.is_dir() {
        let file = path.join("trace.npz");
        if !file.is_file() {
            return Err(AnalysisInputError::NoTrace(path.display().to_string()));
        }
        return of_trace(&file);
    }
    let path = &library::resolve(path, &[Kind::Scene]).map_err(TakeError::from)?;
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz")) {
        of_trace(path)
    } else if is_ron(path) || formats::table::is_clip(path) {
        of_take(path, body, import)
    } else {
        Err(AnalysisInputError::Kind(path.display().to_string()))
    }
}

/// Bodies of the same links whose masses differ by less than this share count as one: a mass changed on
/// purpose, to see what it does, is still to be compared.
const ALIKE: f64 = 0.05;

/// Reads a trace, saying which file it is.
fn read_trace(path: &Path) -> Result<Trace, AnalysisInputError> {
    formats::trace_npz::open(path)
        .map_err(|source| AnalysisInputError::Trace { path: path.display().to_string(), source })
}

fn of_trace(path: &Path) -> Result<AnalysisInput, AnalysisInputError> {
    let trace = read_trace(path)?;
    let folder = path.parent().and_then(Path::file_name);
    let name = folder.or(path.file_stem()).map_or_else(|| "trace".into(), |s| s.to_string_lossy().into());
    let ground = match (trace.ground_m, trace.root) {
        (Some(height), _) => FloorChoice::At(height),
        // a pinned root touches no ground: that on which the clip was captured is found
        (None, RootMode::Pinned) => FloorChoice::Detect,
        (None, _) => FloorChoice::None,
    };
    Ok(AnalysisInput {
        name,
        path: path.to_owned(),
        character: trace.character.clone(),
        given: trace.clip(),
        colors: trace.colors.clone(),
        view: View::default(),
        gravity: trace.gravity,
        ground,
        friction: None,
        source: AnalysisSource::Trace(Box::new(trace)),
    })
}

fn of_take(
    path: &Path,
    body: Option<&Path>,
    import: &ImportOptions,
) -> Result<AnalysisInput, AnalysisInputError> {
    let ask = Ask { body: body.map(Path::to_owned), import: *import, ..Ask::default() };
    let take = open_take(path, &ask)?;
    take.check_performable()?;
    Ok(AnalysisInput::of(take, path.to_owned()))
}

impl AnalysisInput {
    /// The motion of a take that was opened from `path`: of a clip without edits as captured, else as asked for.
    pub fn of(take: Take, path: PathBuf) -> Self {
        let physics = take.conditions.physics;
        let captured = take.is_captured();
        let (name, character, gravity) = (take.name, take.body.character, physics.gravity);
        let (colors, view) = (take.body.colors, strip_view(&take.strip));
        let (given, ground, friction, source) = match take.source {
            Source::Clip(source) if captured => (
                source.map.clip_to_character(&source.clip, &character.skeleton),
                // the take's floor is made to stand on; the analysis looks for the one walked on
                FloorChoice::Detect,
                None,
                AnalysisSource::Clip(source),
            ),
            Source::Clip(_) | Source::Script | Source::Retarget(_) => (
                take.asked.clip,
                physics.ground.map_or(FloorChoice::None, |g| FloorChoice::At(g.height_m)),
                physics.ground.map(|g| g.friction),
                AnalysisSource::Scene,
            ),
        };
        Self { given, ground, friction, source, name, path, character, gravity, colors, view }
    }

    /// Inverse dynamics of the motion.
    ///
    /// # Errors
    /// A motion too short, numbers that are not finite, settings out of range.
    pub fn analyze(&self, options: &AnalysisSettings) -> Result<Analysis, AnalysisInputError> {
        // a pinned root follows a clip with all its noise; what moved freely was integrated, and is smooth
        let noisy = match &self.source {
            AnalysisSource::Clip(_) => true,
            AnalysisSource::Trace(trace) => trace.root == RootMode::Pinned,
            AnalysisSource::Scene => false,
        };
        let usual = if noisy { Smoothing::Auto } else { Smoothing::Off };
        let defaults = AnalysisOptions::default();
        let options = AnalysisOptions {
            smoothing: options.smoothing.unwrap_or(usual),
            gravity: self.gravity,
            ground: self.ground,
            friction: options.friction.or(self.friction).unwrap_or(defaults.friction),
            ..defaults
        };
        analyze(&self.character, &self.given, &options)
            .map_err(|source| AnalysisInputError::Analysis { path: self.path.display().to_string(), source })
    }

    /// The recorded trace, if it is one.
    pub fn recorded(&self) -> Option<&Trace> {
        match &self.source {
            AnalysisSource::Trace(trace) => Some(trace),
            _ => None,
        }
    }

    /// The recorded trace, or the analysis in the form of one.
    pub fn trace(&self, analysis: &Analysis) -> Trace {
        match self.recorded() {
            Some(trace) => trace.clone(),
            None => trace_of(&self.character, &self.given, analysis),
        }
    }

    /// Where a cross-check leaves MuJoCo's trace of this run; `None` if there is none.
    pub fn mujoco_beside(&self) -> Option<PathBuf> {
        self.recorded()?;
        let path = self.path.parent()?.join("mujoco").join("trace.npz");
        path.is_file().then_some(path)
    }

    /// Ground forces of another run of the same body, such as MuJoCo's.
    ///
    /// # Errors
    /// A file that is no trace, or of a body with other links or another mass.
    pub fn other_run(&self, path: &Path) -> Result<GroundForces, AnalysisInputError> {
        let other = read_trace(path)?;
        let names =
            |c: &Character| -> Vec<String> { c.skeleton.links().iter().map(|l| l.name.clone()).collect() };
        let alike = (other.character.mass() / self.character.mass() - 1.0).abs() < ALIKE;
        if names(&other.character) != names(&self.character) || !alike {
            let describe = |c: &Character| {
                format!("`{}` with {} links and {:.2} kg", c.name, c.skeleton.links().len(), c.mass())
            };
            return Err(AnalysisInputError::OtherBody {
                other: path.display().to_string(),
                found: describe(&other.character),
                needed: describe(&self.character),
                path: self.path.display().to_string(),
            });
        }
        Ok(GroundForces::measured(&other))
    }

    /// What penalty contact gives, for a body that would rest `sink_m` deep; `None` without ground.
    ///
    /// # Errors
    /// A sink that is not positive.
    pub fn penalty(
        &self,
        analysis: &Analysis,
        sink_m: f64,
    ) -> Result<Option<(GroundForces, GivenBy)>, AnalysisInputError> {
        Ok(GroundForces::given(&self.character, analysis, sink_m)?)
    }
}
