//! What a report says of its subject: the body, and how the file of a clip was read.
//!
//! In: a take's source and body. Out: the parts of `report.json` that a run and an analysis share.

use formats::bvh::{Chosen, ImportReport};
use motion::names::Word;
use serde::Serialize;

use crate::take::ClipSource;

/// The body.
#[derive(Clone, Debug, Serialize)]
pub struct CharacterReport {
    /// Its name.
    pub name: String,
    /// Links.
    pub links: usize,
    /// Degrees of freedom, root included.
    pub dof: usize,
    /// Mass, kg.
    pub mass_kg: f64,
}

/// What the file of a clip does not say, and how it was decided.
#[derive(Clone, Debug, Serialize)]
pub struct DecidedReport {
    /// Metres in one unit of the file.
    pub metres_per_unit: f64,
    /// Where that comes from: `stated`, `guessed` or `unsure`.
    pub units: &'static str,
    /// Vertical axis of the file, `Y` or `Z`.
    pub up: String,
    /// Where that comes from.
    pub up_axis: &'static str,
    /// Whether the first frame is an inserted T-pose: dropped, kept, or null if it is none.
    pub t_pose_dropped: Option<bool>,
}

impl DecidedReport {
    pub(crate) fn new(import: &ImportReport) -> Self {
        Self {
            metres_per_unit: import.units.metres_per_unit,
            units: chosen(import.units.chosen),
            up: import.up.axis.identifier(),
            up_axis: chosen(import.up.chosen),
            t_pose_dropped: import.t_pose.map(|t| t.dropped),
        }
    }
}

/// How a clip was read.
#[derive(Clone, Debug, Serialize)]
pub struct ClipReport {
    /// What its file does not say.
    #[serde(flatten)]
    pub decided: DecidedReport,
    /// Whether the body was guessed.
    pub body_guessed: bool,
    /// What was read, guessed and repaired, in words.
    pub read: Vec<String>,
    /// What of it was repeated so that it goes on, in words; null of a clip that is as long as its file.
    pub cycle: Option<String>,
    /// What was guessed of the body that a person may want to overrule, in words.
    pub body_notes: Vec<String>,
}

impl ClipReport {
    /// Of a clip that was read from a file; `None` for one from memory, of which nothing was guessed.
    pub(crate) fn new(source: &ClipSource) -> Option<Self> {
        let import = source.import.as_ref()?;
        Some(Self {
            decided: DecidedReport::new(import),
            body_guessed: source.body.is_some(),
            read: import.to_string().lines().map(|l| l.trim().to_owned()).collect(),
            cycle: source.cycle.as_ref().map(ToString::to_string),
            body_notes: source.body.as_ref().map_or_else(Vec::new, |b| b.notes.clone()),
        })
    }
}

/// `stated`, `guessed` or `unsure`.
fn chosen(by: Chosen) -> &'static str {
    match by {
        Chosen::Stated => "stated",
        Chosen::Guessed => "guessed",
        Chosen::Unsure => "unsure",
    }
}
