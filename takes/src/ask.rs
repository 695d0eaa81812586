//! What a take is opened from, and what is asked beside it.

use std::path::{Path, PathBuf};

use formats::bvh::ImportOptions;
use motion::Clip;
use scenes::Overrides;
use sim::foresight::{Choice, Foreseen, Settings};

/// What a take is opened from.
#[derive(Clone, Debug)]
pub enum Input {
    /// A scene (.ron) or a clip, or the name of a scene of the library, see [`scenes::library`].
    Path(PathBuf),
    /// The text of a scene; what it names lies in the folder `base`, or is a location of the library.
    Text {
        /// The scene.
        ron: String,
        /// The folder its files are relative to.
        base: PathBuf,
    },
    /// A clip in memory.
    Clip {
        /// The clip.
        clip: Clip,
        /// Its name, for output folders.
        name: String,
    },
}

impl From<&Path> for Input {
    fn from(path: &Path) -> Self {
        Self::Path(path.to_owned())
    }
}

impl From<&PathBuf> for Input {
    fn from(path: &PathBuf) -> Self {
        Self::Path(path.clone())
    }
}

impl From<PathBuf> for Input {
    fn from(path: PathBuf) -> Self {
        Self::Path(path)
    }
}

/// How a free body that steps looks ahead.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum LookAhead {
    /// Scripts do, with the default settings; clips and retargeted motion have muscles and contacts alone.
    #[default]
    Usual,
    /// Nothing does: muscles and contacts alone.
    Off,
    /// Everything that steps does, like this.
    As(Foreseen),
}

impl LookAhead {
    /// What looks ahead of a take; `scripted`: of a script that steps.
    pub(crate) fn of(&self, scripted: bool) -> Option<Foreseen> {
        match self {
            Self::Usual => scripted.then(|| Foreseen::Search(Settings::default())),
            Self::Off => None,
            Self::As(foreseen) => Some(foreseen.clone()),
        }
    }
}

impl From<Choice> for LookAhead {
    fn from(choice: Choice) -> Self {
        choice.settings().map_or(Self::Off, |settings| Self::As(Foreseen::Search(settings)))
    }
}

/// What is asked beside the file.
#[derive(Clone, Debug, Default)]
pub struct Ask {
    /// Numbers of the dynamic pass other than the file's.
    pub overrides: Overrides,
    /// Engine other than the file's.
    pub engine: Option<String>,
    /// How a free body that steps looks ahead.
    pub foresight: LookAhead,
    /// Character file for a clip, or the name of a character of the library; by default its body is guessed.
    pub body: Option<PathBuf>,
    /// How to read a clip.
    pub import: ImportOptions,
    /// How long a clip goes on by repeating a cycle of itself, s; by default as its scene says, else as long as it is.
    pub loop_s: Option<f64>,
    /// Edits of a clip, each the text that a scene would have in its list; scenes have their own.
    pub edits: Vec<String>,
    /// Pushes beside those of the file, each the text that a scene would have in its list.
    pub pushes: Vec<String>,
    /// What stands when in a clip, and where: a `contacts.ron` of an earlier run, edited; by default it is found.
    pub contacts: Option<PathBuf>,
    /// Leave out the edits.
    pub no_edits: bool,
}

/// Whether the name says a scene, a character or another text of ours.
pub fn is_ron(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ron"))
}
