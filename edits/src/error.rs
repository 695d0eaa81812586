//! What can be wrong with an edit, in words an animator can act on.

use motion::ik::IkError;
use motion::names::nearest;
use thiserror::Error;

/// Why a selector or an edit was refused. The tracks are then as they were.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EditError {
    /// A name that does not exist.
    #[error("unknown {what} `{name}`{hint}")]
    Unknown {
        /// Kind of name: action, label, body part.
        what: &'static str,
        /// As written.
        name: String,
        /// The nearest name, and what exists.
        hint: String,
    },
    /// A number that selects nothing.
    #[error("{place} has no {what} {found}; it has {exist}, counted from 0")]
    Index {
        /// Where was looked: `action "wave"`.
        place: String,
        /// Cycle, pose or repetition.
        what: &'static str,
        /// As asked.
        found: usize,
        /// How many there are.
        exist: usize,
    },
    /// A parameter out of its range.
    #[error("{edit}: {what} is {value}{at}; allowed: {allowed}")]
    Parameter {
        /// The edit.
        edit: &'static str,
        /// Which parameter.
        what: &'static str,
        /// As found.
        value: f64,
        /// Where along a curve, or nothing.
        at: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A curve without knots, or with knots out of order or not finite.
    #[error("a parameter curve needs finite knots in ascending order; knot {0} is not")]
    Knots(usize),
    /// A list of per-pose values of the wrong length.
    #[error("{edit}: {given} values for {needed} poses; one for each pose selected is needed")]
    PerPose {
        /// The edit.
        edit: &'static str,
        /// Values given.
        given: usize,
        /// Poses selected.
        needed: usize,
    },
    /// A reference pose of the wrong length, or with a value that is not finite.
    #[error("the reference pose must have {needed} finite numbers, as the skeleton needs; found {found}")]
    Reference {
        /// Numbers found.
        found: usize,
        /// Numbers needed.
        needed: usize,
    },
    /// A result that is not finite, or a negative duration or hold.
    #[error("{edit}: the result for {label} is not finite, or takes negative time")]
    Result {
        /// The edit.
        edit: &'static str,
        /// The element.
        label: String,
    },
    /// A limb that cannot be solved.
    #[error(transparent)]
    Ik(#[from] IkError),
}

impl EditError {
    /// An unknown name, with the nearest of the known ones and a list of them (at most 40).
    pub fn unknown<'a>(what: &'static str, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        let all: Vec<&str> = known.into_iter().collect();
        let near =
            nearest(name, all.iter().copied()).map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
        let list = match all.len() {
            0 => " There are none.".into(),
            n if n > 40 => format!(" There are {n}: {}, …", all[..40].join(", ")),
            _ => format!(" There are: {}", all.join(", ")),
        };
        let hint =
            if near.is_empty() { format!(";{}", list.replace(" There", " there")) } else { near + &list };
        Self::Unknown { what, name: name.into(), hint }
    }
}
