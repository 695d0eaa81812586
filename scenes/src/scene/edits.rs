//! The edits of a scene, checked.
//!
//! In: the words of [`crate::schema`]. Out: a [`SceneEdit`] for each, in the order declared, or an error at the very value. Labels and
//! parts are found when the edits are applied: they are of the motion, which is not built here.
//!
//! Track edits change a script, clip edits what was sampled. A track edit becomes a clip edit, through a fit ([`edits::OnFit`]),
//! where there is no script, after a clip edit, and where `span_s` or `fit` is given.

use std::collections::BTreeMap;
use std::path::PathBuf;

use edits::by_example::Contacts;
use edits::style::Timing;
use edits::{
    Amount, Amplitude, ClipEdit, ExtentReach, ExtentShoulder, OnFit, Parameter, Pin, PinAt, PoseChange,
    PoseDelta, PoseRequest, Reference, Succession, Tension, TimeDelta, TrackEdit, Warp, Where,
};

use bodies::Character;
use motion::Tolerance;

use super::{Check, SceneSource};
use crate::schema::{ArgumentRon, EditRon, ParameterRon, PinAtRon};
use crate::{ProgramSpec, SceneError, Source};

/// What an edit of a scene changes.
pub enum EditKind {
    /// The tracks of a script.
    Track(Box<dyn TrackEdit + Send + Sync>),
    /// How tense the joints of a motion without a script are.
    Tension(Tension),
    /// A sampled motion, wherever it came from.
    Clip(Box<dyn ClipEdit + Send + Sync>),
    /// The same, by what a file holds; nothing is opened here.
    Stored(StoredEdit),
    /// A point held while the edits before it apply; all pins of a scene act at once.
    Pin(Pin),
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
            Self::Tension(edit) => edit.name(),
            Self::Clip(edit) => edit.name(),
            Self::Stored(edit) => edit.name(),
            Self::Pin(_) => "pin",
            Self::Program(_) => "program",
        }
    }

    /// The file that holds it, if one does.
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::Stored(stored) => Some(stored.file()),
            Self::Program(program) => Some(&program.file),
            Self::Track(_) | Self::Tension(_) | Self::Clip(_) | Self::Pin(_) => None,
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
            let sampled = out.iter().any(|before| before.kind.is_of_clips());
            let of = Of { script: source.script().is_some(), sampled };
            let edit = self.edit(&format!("edits[{i}]"), e, of)?;
            if let (false, Some(EditKind::Pin(pin))) =
                (matches!(edit.kind, EditKind::Pin(_)), out.last().map(|last| &last.kind))
            {
                let (name, point) = (edit.kind.name(), &pin.point);
                let why = format!(
                    "the edit `{name}` comes after the pin of `{point}`; allowed: pins last, they hold whatever the other edits do"
                );
                return Err(self.source.error(&edit.at, why));
            }
            out.push(edit);
        }
        Ok(out)
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

    fn edit(&self, at: &str, e: &EditRon, of: Of) -> Result<SceneEdit, SceneError> {
        let (on, repetition, parts, span_s) = match e {
            EditRon::Succession { on, repetition, parts, span_s, .. }
            | EditRon::Amplitude { on, repetition, parts, span_s, .. }
            | EditRon::ExtentShoulder { on, repetition, parts, span_s, .. }
            | EditRon::ExtentReach { on, repetition, parts, span_s, .. }
            | EditRon::Tension { on, repetition, parts, span_s, .. }
            | EditRon::Warp { on, repetition, parts, span_s, .. }
            | EditRon::ByExample { on, repetition, parts, span_s, .. }
            | EditRon::PoseDelta { on, repetition, parts, span_s, .. }
            | EditRon::Style { on, repetition, parts, span_s, .. }
            | EditRon::Program { on, repetition, parts, span_s, .. }
            | EditRon::TimeDelta { on, repetition, parts, span_s, .. } => (on, repetition, parts, *span_s),
            EditRon::Pin { .. } => (const { &String::new() }, &None, const { &Vec::new() }, None),
        };
        let track = |edit: Box<dyn TrackEdit + Send + Sync>| self.track(at, e, edit, of);
        let kind = match e {
            EditRon::Succession { offset_s, direction, .. } => {
                track(Box::new(Succession { offset_s: parameter(offset_s), direction: direction.0 }))?
            }
            EditRon::Amplitude { factor, reference, .. } => track(Box::new(Amplitude {
                factor: parameter(factor),
                reference: match reference.0 {
                    Reference::InterPose => None,
                    Reference::Rest => Some(self.character.rest.clone()),
                },
            }))?,
            EditRon::ExtentShoulder { extent, .. } => {
                track(Box::new(ExtentShoulder { extent: parameter(extent) }))?
            }
            EditRon::ExtentReach { factor, .. } => {
                track(Box::new(ExtentReach { factor: parameter(factor) }))?
            }
            EditRon::Tension { factor, absolute, .. } => {
                let amount = match (factor, absolute) {
                    (Some(f), None) => Amount::Factor(parameter(f)),
                    (None, Some(a)) => Amount::Absolute(parameter(a)),
                    _ => {
                        return Err(self.source.error(at, "a Tension takes either `factor` or `absolute`"));
                    }
                };
                self.tension(at, Tension { amount }, span_s.is_some(), of)?
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
            EditRon::Pin { point, point_m, at, from_s, to_s, blend_s } => EditKind::Pin(Pin {
                point: point.clone(),
                point_m: (*point_m).into(),
                at: match at {
                    PinAtRon::World(x, y, z) => PinAt::World([*x, *y, *z]),
                    PinAtRon::Link(link, at) => PinAt::Link(link.clone(), (*at).into()),
                    PinAtRon::Asked => PinAt::Asked,
                },
                from_s: *from_s,
                to_s: *to_s,
                blend_s: *blend_s,
            }),
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

/// What an edit of a scene meets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Of {
    /// The motion is a script.
    script: bool,
    /// A clip edit comes before it.
    sampled: bool,
}

impl Check<'_> {
    /// An edit of elements: of those of the script, or of elements fitted to the motion.
    fn track(
        &self,
        at: &str,
        e: &EditRon,
        edit: Box<dyn TrackEdit + Send + Sync>,
        of: Of,
    ) -> Result<EditKind, SceneError> {
        let (EditRon::Succession { fit, span_s, .. }
        | EditRon::Amplitude { fit, span_s, .. }
        | EditRon::ExtentShoulder { fit, span_s, .. }
        | EditRon::ExtentReach { fit, span_s, .. }) = e
        else {
            return Ok(EditKind::Track(edit));
        };
        if of.script && !of.sampled && fit.is_none() && span_s.is_none() {
            return Ok(EditKind::Track(edit));
        }
        let usual = Tolerance::default();
        let fit = fit.map_or(usual, |fit| Tolerance {
            deg: fit.deg.unwrap_or(usual.deg),
            mm: fit.mm.unwrap_or(usual.mm),
        });
        fit.check().map_err(|e| self.source.error(&format!("{at}.fit"), e.to_string()))?;
        Ok(EditKind::Clip(Box::new(OnFit { edit, fit })))
    }

    /// An edit of tension: of the elements of a script, which a retiming takes along, or of a clip over time.
    fn tension(&self, at: &str, edit: Tension, spans: bool, of: Of) -> Result<EditKind, SceneError> {
        if !of.script {
            return Ok(EditKind::Tension(edit));
        }
        if spans {
            let why = "the tension of a script is that of its elements: name them in `on`; `span_s` is for motion without a script";
            return Err(self.source.error(&format!("{at}.span_s"), why));
        }
        Ok(EditKind::Track(Box::new(edit)))
    }
}

/// An edit as a text of its own, of a motion without a script: what `--edit` of the command line takes.
///
/// # Errors
/// As in a scene, at the place in the text.
pub fn edit_of_clip(source: &Source, character: &Character) -> Result<SceneEdit, SceneError> {
    let ron: EditRon = source.parse()?;
    Check { source, character }.edit("", &ron, Of { script: false, sampled: false })
}

fn parameter(p: &ParameterRon) -> Parameter {
    match p {
        ParameterRon::Constant(x) => Parameter::Constant(*x),
        ParameterRon::PerPose(v) => Parameter::PerPose(v.clone()),
        ParameterRon::OverTime(k) => Parameter::OverTime(k.clone()),
        ParameterRon::OverRepetition(k) => Parameter::OverRepetition(k.clone()),
    }
}
