//! The edits of a scene, checked.
//!
//! In: the words of [`crate::schema`]. Out: a [`SceneEdit`] for each, in the order declared, or an error at the very value. Labels and
//! parts are found when the edits are applied: they are of the motion, which is not built here.
//!
//! Track edits change a script and come before clip edits, which change what was sampled from it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use edits::by_example::Contacts;
use edits::style::Timing;
use edits::{
    Amount, Amplitude, ClipEdit, ExtentReach, ExtentShoulder, Parameter, PoseChange, PoseDelta, PoseRequest,
    Reference, Succession, Tension, TimeDelta, TrackEdit, Warp, Where,
};

use super::{Check, SceneSource};
use crate::schema::{ArgumentRon, EditRon, ParameterRon};
use crate::{ProgramSpec, SceneError, Source};

/// What an edit of a scene changes.
pub enum EditKind {
    /// The tracks of a script.
    Track(Box<dyn TrackEdit + Send + Sync>),
    /// A sampled motion, wherever it came from.
    Clip(Box<dyn ClipEdit + Send + Sync>),
    /// The same, by what a file holds; nothing is opened here.
    Stored(StoredEdit),
    /// What a program of the user changes: its file says which of the two.
    Program(ProgramSpec),
}

/// A clip edit that a file holds.
#[derive(Clone, Debug, PartialEq)]
pub enum StoredEdit {
    /// An edit learned from examples.
    ByExample {
        /// The file of `contrapposto propagate train`.
        model: PathBuf,
        /// How much of it; 1 is what was taught.
        amount: f64,
        /// Whether what stands keeps standing; `None`: as it was taught.
        contacts: Option<Contacts>,
    },
    /// Style components of two clips.
    Style(Box<StyleSpec>),
}

impl StoredEdit {
    /// Its name, as scenes and the log call it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::ByExample { .. } => "by example",
            Self::Style(_) => "style",
        }
    }

    /// Its file.
    pub fn file(&self) -> &PathBuf {
        match self {
            Self::ByExample { model, .. } => model,
            Self::Style(spec) => &spec.path,
        }
    }
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
    /// Its name, as scenes and the log call it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Track(edit) => edit.name(),
            Self::Clip(edit) => edit.name(),
            Self::Stored(edit) => edit.name(),
            Self::Program(_) => "program",
        }
    }

    /// Whether it is known to change a sampled motion; of a program only its file says it.
    pub fn is_of_clips(&self) -> bool {
        matches!(self, Self::Clip(_) | Self::Stored(_))
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

    fn may_edit_tracks(
        &self,
        edit: &SceneEdit,
        before: &[SceneEdit],
        source: &SceneSource,
    ) -> Result<(), SceneError> {
        let clip = before.iter().find(|b| b.kind.is_of_clips()).map(|b| b.kind.name());
        may_edit_tracks(self.source, edit, clip, source)
    }

    /// A program.
    pub(crate) fn program(
        &self,
        at: &str,
        file: &str,
        params: &BTreeMap<String, ArgumentRon>,
    ) -> Result<ProgramSpec, SceneError> {
        Ok(ProgramSpec {
            file: self.source.beside(&format!("{at}.file"), "program", file)?,
            params: params.iter().map(|(name, value)| (name.clone(), value.0.clone())).collect(),
            at: at.into(),
        })
    }

    fn edit(&self, at: &str, e: &EditRon) -> Result<SceneEdit, SceneError> {
        let (on, repetition, parts, span_s) = match e {
            EditRon::Succession { on, repetition, parts, .. }
            | EditRon::Amplitude { on, repetition, parts, .. }
            | EditRon::ExtentShoulder { on, repetition, parts, .. }
            | EditRon::ExtentReach { on, repetition, parts, .. }
            | EditRon::Tension { on, repetition, parts, .. } => (on, repetition, parts, None),
            EditRon::Warp { on, repetition, parts, span_s, .. }
            | EditRon::ByExample { on, repetition, parts, span_s, .. }
            | EditRon::PoseDelta { on, repetition, parts, span_s, .. }
            | EditRon::Style { on, repetition, parts, span_s, .. }
            | EditRon::Program { on, repetition, parts, span_s, .. }
            | EditRon::TimeDelta { on, repetition, parts, span_s, .. } => (on, repetition, parts, *span_s),
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
            EditRon::ByExample { model, amount, contacts, .. } => {
                let at_model = format!("{at}.model");
                EditKind::Stored(StoredEdit::ByExample {
                    model: self.source.beside(&at_model, "learned edit", model)?,
                    amount: self.within(&format!("{at}.amount"), amount.unwrap_or(1.0), 0.0, 1.5, "")?,
                    contacts: contacts.as_ref().map(|c| c.0),
                })
            }
            EditRon::PoseDelta { at_s, drag, pin, weight, group, limits, blend_s, block_s, .. } => {
                let request = PoseRequest {
                    drag: drag.iter().map(|(name, &(x, y, z))| (name.clone(), [x, y, z])).collect(),
                    pin: pin.clone(),
                    weight: weight.iter().map(|(name, w)| (name.clone(), *w)).collect(),
                    group: group.clone(),
                    limits: *limits,
                };
                let change = PoseChange::Asked(request);
                EditKind::Clip(Box::new(PoseDelta {
                    at_s: *at_s,
                    change,
                    blend_s: *blend_s,
                    block_s: *block_s,
                }))
            }
            &EditRon::TimeDelta { at_s, to_s, blend_s, .. } => {
                EditKind::Clip(Box::new(TimeDelta { at_s, to_s, blend_s }))
            }
            EditRon::Style { components, amount, only, from, align, timing, names, .. } => {
                EditKind::Stored(StoredEdit::Style(Box::new(StyleSpec {
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
                })))
            }
            EditRon::Program { file, params, .. } => EditKind::Program(self.program(at, file, params)?),
            EditRon::Warp { times_s, .. } => EditKind::Clip(Box::new(Warp { anchors: times_s.clone() })),
        };
        let on = on.split(',').map(|text| text.trim().to_owned()).collect();
        let place = Where { on, repetition: *repetition, parts: parts.clone(), span_s };
        // a repetition of something that has none is a fault of the text
        place.places().map_err(|e| self.source.error(&format!("{at}.on"), e.to_string()))?;
        Ok(SceneEdit { kind, place, at: at.into() })
    }
}

/// Track edits need a script, and one that no clip edit has changed; `clip`: the name of a clip edit before it.
///
/// # Errors
/// At the edit.
pub fn may_edit_tracks(
    text: &Source,
    edit: &SceneEdit,
    clip: Option<&str>,
    source: &SceneSource,
) -> Result<(), SceneError> {
    let name = edit.kind.name();
    let refused = |why: String| text.error(&edit.at, why);
    if source.script().is_none() {
        let why = format!(
            "the edit `{name}` changes the poses of a script; the motion of this scene is: {}",
            source.describe()
        );
        return Err(refused(why).with_help(
            "edits of any motion: Warp, PoseDelta, TimeDelta, ByExample, Style, a Program with `fn clip`",
        ));
    }
    match clip {
        None => Ok(()),
        Some(clip) => Err(refused(format!(
            "the edit `{name}` changes the script, but `{clip}` before it changes what was sampled from the script; \
             allowed: edits of the script first"
        ))),
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
