//! Edits by example as a project: pairs, corrections, the model, and how good it is.
//!
//! | module | holds |
//! |---|---|
//! | [`project`] | pairs, corrections and the model on disk |
//! | [`apply`] | an edit used on a clip |
//! | [`background`] | learning and applying in threads of their own |
//! | [`report`] | what is said of learning, applying and the project |
//! | [`rules`] | known edits, to measure against |
//! | [`route`] | walks as scripts, with and without a change |
//! | [`shipped`] | the two edits that ship, and how well they hold |
//! | [`compare`] | learned edits beside what an artist would do instead |
//! | [`transition`] | how smoothly an edit comes and goes |

pub mod apply;
pub mod background;
pub mod compare;
pub mod project;
pub mod report;
pub mod route;
pub mod rules;
pub mod shipped;
pub mod transition;

use std::path::PathBuf;

use edits::EditError;
use edits::by_example::ExampleError;
use thiserror::Error;

pub use edits::Where;
pub use edits::by_example::{
    Contacts, ExampleEdit, ExampleOptions as EditOptions, Learning, Onto, Pair, Part,
};
pub use learn::ExampleMethod;

/// Why a study of edits by example cannot go on.
#[derive(Debug, Error)]
pub enum PropagateError {
    /// Examples that cannot be learned from or applied.
    #[error(transparent)]
    Example(#[from] ExampleError),
    /// A place that the clip does not have.
    #[error(transparent)]
    Edit(EditError),
    /// A folder that is no project.
    #[error("{}: no project here; `contrapposto propagate new` makes one", path.display())]
    NoProject {
        /// The folder.
        path: PathBuf,
    },
    /// A project without a model.
    #[error("{}: nothing was learned yet; run `contrapposto propagate train {}`", path.display(), path.display())]
    Untrained {
        /// The folder.
        path: PathBuf,
    },
    /// Something that is there already.
    #[error("{}: is there already; choose another name, or remove it", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// A name that cannot be a file's.
    #[error("`{name}` is no name of a pair; allowed: letters, digits, `-`, `_` and `.`, not first")]
    Name {
        /// As given.
        name: String,
    },
    /// A file that cannot be read or written, or makes no sense.
    #[error("{}: {what}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        what: String,
    },
    /// A file that is no learned edit.
    #[error("{}: {source}", path.display())]
    Model {
        /// The file.
        path: PathBuf,
        /// Why.
        source: formats::ExampleFileError,
    },
    /// A clip that cannot be read.
    #[error(transparent)]
    Clip(#[from] Box<formats::ClipFileError>),
    /// A clip that cannot be written.
    #[error("cannot write the clip: {0}")]
    Bvh(String),
    /// A correction of another clip.
    #[error(
        "the edited clip has {} frames and {} links, the result it should correct {} and {}; edit what `propagate export` wrote, and keep its frames and its frame rate",
        found.0, found.1, needed.0, needed.1
    )]
    NotTheResult {
        /// Frames and links of the edited clip.
        found: (usize, usize),
        /// Of the result.
        needed: (usize, usize),
    },
    /// A correction that corrects nothing.
    #[error("no frame of the edited clip differs from the result by more than 0.1°")]
    NothingChanged,
    /// A clip whose feet cannot be kept where they stand.
    #[error("contacts cannot be kept: {what}")]
    Feet {
        /// Why.
        what: String,
    },
    /// Files that were not written.
    #[error(transparent)]
    Folder(#[from] takes::results::folder::FolderError),
    /// A context that no pair has.
    #[error("no pair has the context `{found}`; {}", if known.is_empty() { "no pair has any".into() } else { format!("there are {known}") })]
    Context {
        /// As asked for.
        found: String,
        /// Those there are, in words.
        known: String,
    },
    /// No thread for the work.
    #[error("cannot start a thread: {0}")]
    Thread(std::io::Error),
    /// Work that was ended.
    #[error("cancelled")]
    Cancelled,
    /// A scene that does not open.
    #[error(transparent)]
    Scene(#[from] Box<takes::TakeError>),
    /// A clip that no rule can act on.
    #[error(transparent)]
    Rule(#[from] rules::RuleError),
}

impl PropagateError {
    /// Whether the input is at fault, not the writing.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Folder(e) => e.is_input(),
            Self::Bvh(_) | Self::Thread(_) | Self::Cancelled => false,
            _ => true,
        }
    }
}
