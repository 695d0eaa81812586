//! The edits of a scene, checked.
//!
//! In: the words of [`crate::schema`]. Out: a [`SceneEdit`] for each, in the order declared, or an error at the very value. Labels and
//! parts are found when the edits are applied: they are of the motion, which is not built here.
//!
//! Track edits change a script and come before clip edits, which change what was sampled from it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use edits::style::Timing;
use edits::{
    Amount, Amplitude, ClipEdit, ExtentReach, ExtentShoulder, Parameter, Reference, Succession, Tension,
    TrackEdit, Warp, Where,
};

use super::{Check, SceneSource};
use crate::SceneError;
use crate::schema::{EditRon, ParameterRon};

/// What an edit of a scene changes.
pub enum EditKind {
    /// The tracks of a script.
    Track(Box<dyn TrackEdit + Send + Sync>),
    /// A sampled motion, wherever it came from.
    Clip(Box<dyn ClipEdit + Send + Sync>),
    /// A sampled motion, by components that are in a file; `takes` reads it.
    Style(Box<StyleSpec>),
}

/// The edit `Style` as a scene has it.
#[derive(Clone, Debug, PartialEq)]
pub struct StyleSpec {
    /// The file of components.
    pub path: PathBuf,
    /// Numbers of the components, from 1; empty: those that tell the two clips apart.
    pub only: Vec<usize>,
    /// How much of them.
    pub amount: Parameter,
    /// Name of the clip whose style it is; `None`: the second.
    pub from: Option<String>,
    /// The bone that is aligned on; `None`: automatic.
    pub align: Option<String>,
    /// Whose timing.
    pub timing: Timing,
    /// Bones of the set and what the motion calls them.
    pub names: BTreeMap<String, String>,
}

impl EditKind {
    /// The file that it is made of.
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::Style(style) => Some(&style.path),
            Self::Track(_) | Self::Clip(_) => None,
        }
    }

    /// Its name, as scenes and the log call it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Track(edit) => edit.name(),
            Self::Clip(edit) => edit.name(),
            Self::Style(_) => "style",
        }
    }
}

/// An edit with what it applies to.
pub struct SceneEdit {
    /// The edit.
    pub kind: EditKind,
    /// Where it applies.
    pub place: Where,
    /// Path of the edit in the file, for errors.
    pub at: String,
}

impl Check<'_> {
    /// The edits of a scene whose motion is `source`.
    pub(crate) fn edits(&self, ron: &[EditRon], source: &SceneSource) -> Result<Vec<SceneEdit>, SceneError> {
        let mut out: Vec<SceneEdit> = Vec::new();
        for (i, e) in ron.iter().enumerate() {
            let edit = self.edit(&format!("edits[{i}]"), e)?;
            if let EditKind::Track(_) = edit.kind {
                self.may_edit_tracks(&edit, &out, source)?;
            }
            out.push(edit);
        }
        Ok(out)
    }

    /// Track edits need a script, and one that no clip edit has changed.
    fn may_edit_tracks(
        &self,
        edit: &SceneEdit,
        before: &[SceneEdit],
        source: &SceneSource,
    ) -> Result<(), SceneError> {
        let name = edit.kind.name();
        let refused = |why: String| self.source.error(&edit.at, why);
        if source.script().is_none() {
            let why = format!(
                "the edit `{name}` changes the poses of a script; the motion of this scene is: {}",
                source.describe()
            );
            return Err(refused(why).with_help("edits of any motion: Warp, Style"));
        }
        match before.iter().find(|b| matches!(b.kind, EditKind::Clip(_) | EditKind::Style(_))) {
            None => Ok(()),
            Some(clip) => Err(refused(format!(
                "the edit `{name}` changes the script, but `{}` before it changes what was sampled from the script; \
                 allowed: edits of the script first",
                clip.kind.name()
            ))),
        }
    }

    fn edit(&self, at: &str, e: &EditRon) -> Result<SceneEdit, SceneError> {
        let (on, repetition, parts, span_s) = match e {
            EditRon::Succession { on, repetition, parts, .. }
            | EditRon::Amplitude { on, repetition, parts, .. }
            | EditRon::ExtentShoulder { on, repetition, parts, .. }
            | EditRon::ExtentReach { on, repetition, parts, .. }
            | EditRon::Tension { on, repetition, parts, .. } => (on, repetition, parts, None),
            EditRon::Warp { on, repetition, parts, span_s, .. }
            | EditRon::Style { on, repetition, parts, span_s, .. } => (on, repetition, parts, *span_s),
        };
        let track = |edit: Box<dyn TrackEdit + Send + Sync>| EditKind::Track(edit);
        let kind = match e {
            EditRon::Succession { offset_s, direction, .. } => {
                track(Box::new(Succession { offset_s: parameter(offset_s), direction: direction.0 }))
            }
            EditRon::Amplitude { factor, reference, .. } => track(Box::new(Amplitude {
                factor: parameter(factor),
                reference: match reference.0 {
                    Reference::InterPose => None,
                    Reference::Rest => Some(self.character.rest.clone()),
                },
            })),
            EditRon::ExtentShoulder { extent, .. } => {
                track(Box::new(ExtentShoulder { extent: parameter(extent) }))
            }
            EditRon::ExtentReach { factor, .. } => track(Box::new(ExtentReach { factor: parameter(factor) })),
            EditRon::Tension { factor: Some(f), absolute: None, .. } => {
                track(Box::new(Tension { amount: Amount::Factor(parameter(f)) }))
            }
            EditRon::Tension { factor: None, absolute: Some(a), .. } => {
                track(Box::new(Tension { amount: Amount::Absolute(parameter(a)) }))
            }
            EditRon::Tension { .. } => {
                return Err(self.source.error(at, "a Tension takes either `factor` or `absolute`"));
            }
            EditRon::Style { components, amount, only, from, align, timing, names, .. } => {
                EditKind::Style(Box::new(StyleSpec {
                    path: self.source.beside(
                        &format!("{at}.components"),
                        "file of style components",
                        components,
                    )?,
                    only: only.clone(),
                    amount: parameter(amount),
                    from: from.clone(),
                    align: align.clone(),
                    timing: timing.0,
                    names: names.clone(),
                }))
            }
            EditRon::Warp { times_s, .. } => EditKind::Clip(Box::new(Warp { anchors: times_s.clone() })),
        };
        let on = on.split(',').map(|text| text.trim().to_owned()).collect();
        let place = Where { on, repetition: *repetition, parts: parts.clone(), span_s };
        // a repetition of something that has none is a fault of the text
        place.places().map_err(|e| self.source.error(&format!("{at}.on"), e.to_string()))?;
        Ok(SceneEdit { kind, place, at: at.into() })
    }
}

fn parameter(p: &ParameterRon) -> Parameter {
    match p {
        ParameterRon::Constant(x) => Parameter::Constant(*x),
        ParameterRon::PerPose(v) => Parameter::PerPose(v.clone()),
        ParameterRon::OverTime(k) => Parameter::OverTime(k.clone()),
        ParameterRon::OverRepetition(k) => Parameter::OverRepetition(k.clone()),
    }
}
