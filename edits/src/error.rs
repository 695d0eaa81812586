//! What can be wrong with an edit, in words an animator can act on.

use std::path::PathBuf;

use motion::fit::FitError;
use motion::ik::IkError;
use motion::ik::pose::PoseError;
use motion::names::nearest;
use motion::time_map::TimeMapError;
use thiserror::Error;

use crate::by_example::ExampleError;

/// Why a selector or an edit was refused. Tracks, clip and log are then as they were.
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
    /// A repetition of something that is not repeated.
    #[error(
        "`repetition: {repetition}` needs a cycle or a pose in `on`, such as \"twist_0\" or \"twist_0_1\"; found \"{found}\""
    )]
    Repetition {
        /// The repetition asked for.
        repetition: usize,
        /// The label as written.
        found: String,
    },
    /// A span of time for a track edit.
    #[error("`span_s` is of clip edits; a track edit applies to labels: use `on` and `repetition`")]
    SpanOfTracks,
    /// Labels where there is no script.
    #[error(
        "`on: \"{on}\"` names labels of a script, and this motion has none; use `span_s: (from, to)` within 0 s to {end_s:.3} s"
    )]
    NoScript {
        /// The labels as written.
        on: String,
        /// Length of the clip, s.
        end_s: f64,
    },
    /// Labels of elements that take no time.
    #[error("`on: \"{on}\"` takes no time; a clip edit needs elements with a duration or a hold")]
    NoTime {
        /// The labels as written.
        on: String,
    },
    /// A span that is not in the clip.
    #[error(
        "`span_s` is {from_s} s to {to_s} s; allowed: the first below the second, both within 0 s to {end_s:.3} s"
    )]
    Span {
        /// Beginning as written, s.
        from_s: f64,
        /// End as written, s.
        to_s: f64,
        /// Length of the clip, s.
        end_s: f64,
    },
    /// Labels and a span without common time.
    #[error(
        "`on: \"{on}\"` is {on_from_s:.3} s to {on_to_s:.3} s of the clip, which has nothing in common with {from_s:.3} s to {to_s:.3} s"
    )]
    SpanApart {
        /// The labels as written.
        on: String,
        /// Beginning of the labels, s.
        on_from_s: f64,
        /// End of the labels, s.
        on_to_s: f64,
        /// Beginning of the span, s.
        from_s: f64,
        /// End of the span, s.
        to_s: f64,
    },
    /// Body parts for an edit of the whole body.
    #[error("{edit}: applies to the whole body; found `parts`: {parts}; leave them out")]
    WholeBody {
        /// The edit.
        edit: &'static str,
        /// The parts as written.
        parts: String,
    },
    /// Anchors that are no time map.
    #[error("{edit}: {source}")]
    Times {
        /// The edit.
        edit: &'static str,
        /// What is wrong with them.
        source: TimeMapError,
    },
    /// An anchor of a warp that lies outside its span.
    #[error(
        "warp: anchor {index} is at {anchor_s} s; allowed: {from_s:.3} s to {to_s:.3} s, the span of the edit"
    )]
    AnchorOutside {
        /// Which, counted from 0.
        index: usize,
        /// Where it is, s.
        anchor_s: f64,
        /// Beginning of the span, s.
        from_s: f64,
        /// End of the span, s.
        to_s: f64,
    },
    /// An anchor that moves the beginning of the span of a warp.
    #[error(
        "warp: the first anchor moves {from_s:.3} s, the beginning of the span, to {to_s} s; it must stay, as what is before it does"
    )]
    AnchorStart {
        /// Beginning of the span, s.
        from_s: f64,
        /// Where it was to go, s.
        to_s: f64,
    },
    /// A time that is not in the span.
    #[error("{edit}: `{what}` is {t_s} s; allowed: {from_s:.3} s to {to_s:.3} s")]
    TimeOutside {
        /// The edit.
        edit: &'static str,
        /// Which parameter.
        what: &'static str,
        /// As written, s.
        t_s: f64,
        /// Beginning of the span, s.
        from_s: f64,
        /// End of the span, s.
        to_s: f64,
    },
    /// A pose dragged further in time than time may be bent.
    #[error(
        "{edit}: the pose moves by {moved_s:.3} s, and has {room_s:.3} s to do it in; `blend_s` must leave more room than it moves"
    )]
    NoRoom {
        /// The edit.
        edit: &'static str,
        /// How far the pose is moved, s.
        moved_s: f64,
        /// The blend on that side, within the span, s.
        room_s: f64,
    },
    /// A pose without anything to drag.
    #[error("{edit}: nothing is dragged; name a joint and where it goes, as x, y, z in m, world, Y up")]
    NothingDragged {
        /// The edit.
        edit: &'static str,
    },
    /// A pin without a drag.
    #[error("{edit}: nothing is dragged, so that `{name}` cannot be pinned")]
    OnlyDragged {
        /// The edit.
        edit: &'static str,
        /// What was pinned.
        name: String,
    },
    /// Limits of a body that has none.
    #[error("{edit}: `limits`: no joint of this body has limits; those of a scene's character have")]
    NoLimits {
        /// The edit.
        edit: &'static str,
    },
    /// A pose that cannot be asked for.
    #[error("{edit}: {source}")]
    Pose {
        /// The edit.
        edit: &'static str,
        /// What is wrong.
        source: PoseError,
    },
    /// Body parts for an edit that moves the whole body.
    #[error("pin: `parts` are {parts}; a pin moves the whole body, as little as it can: leave them out")]
    PinParts {
        /// As written.
        parts: String,
    },
    /// A point held on what goes where it goes.
    #[error(
        "pin: `{point}` cannot be held on `{link}`, which it carries or is part of; allowed: links that do not hang on it"
    )]
    PinnedToItself {
        /// The point.
        point: String,
        /// The link.
        link: String,
    },
    /// Two pins for one point.
    #[error("pin: `{point}` has two pins at {at_s:.3} s; a point is held at one place at a time")]
    PinnedTwice {
        /// The point.
        point: String,
        /// When, s.
        at_s: f64,
    },
    /// A difference of poses of the wrong length, or with a number that is not finite.
    #[error(
        "{edit}: the difference of the poses must have {needed} finite numbers, as the skeleton needs; found {found}"
    )]
    Delta {
        /// The edit.
        edit: &'static str,
        /// Numbers found.
        found: usize,
        /// Numbers needed.
        needed: usize,
    },
    /// A clip that no edit may give.
    #[error("{edit}: the clip it gives {what}")]
    ClipResult {
        /// The edit.
        edit: &'static str,
        /// What is wrong with it.
        what: String,
    },
    /// A value for each pose or repetition of a motion that has neither.
    #[error(
        "{edit}: `{what}` has a value for each pose or repetition, and a fitted clip has neither; allowed: a number, or (over_time_s: [(t, x), …])"
    )]
    NoPoses {
        /// The edit.
        edit: &'static str,
        /// The parameter.
        what: &'static str,
    },
    /// An edit that has nothing to do with shape.
    #[error("{edit}: changes no pose, so that it cannot act on a fit")]
    NotOfFits {
        /// The edit.
        edit: &'static str,
    },
    /// A place in which a fit has nothing to change.
    #[error("{edit}: nothing to change: {what}")]
    NothingFitted {
        /// The edit.
        edit: &'static str,
        /// Why.
        what: String,
    },
    /// A clip that cannot be fitted.
    #[error("{edit}: {source}")]
    Fit {
        /// The edit.
        edit: &'static str,
        /// What is wrong.
        source: FitError,
    },
    /// A limb that cannot be solved.
    #[error(transparent)]
    Ik(#[from] IkError),
    /// An edit by example that does not fit.
    #[error("by example: {0}")]
    Example(#[from] ExampleError),
    /// A program of the user.
    #[error("{message}\n  --> {}:{line}:{column}", file.display())]
    Program {
        /// Its file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What was found and what is allowed.
        message: String,
    },
    /// A style that does not fit.
    #[error("style: {0}")]
    Style(Box<crate::style::error::StyleError>),
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
