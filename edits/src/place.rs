//! Where an edit applies, as a person writes it, for both kinds of edit.
//!
//! In: a [`Where`]: labels, a repetition, body parts, a span of time. Out: for a track edit [`Selector`]s of
//! elements; for a clip edit a [`ClipPlace`]: a span of time and a set of degrees of freedom.
//!
//! | word | track edit | clip edit |
//! |---|---|---|
//! | `on` | the elements of these labels | from the first start to the last end of these elements; only with a script |
//! | `repetition` | only this one of the cycle or pose named | the same |
//! | `parts` | only elements of these parts | these joints, over the whole span |
//! | `span_s` | refused: tracks are placed by labels | this time; with `on`, what both have in common |
//!
//! Times of a clip edit are those of the clip as the edits before it left it: labels of a script are moved by
//! what was retimed ([`Motion::times`]). Units: s.

use std::collections::BTreeSet;

use motion::Dof;

use crate::selector::parts_dofs;
use crate::{EditError, Motion, Place, Selector};

/// Where an edit applies. See the module header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Where {
    /// Labels as text (see [`crate::selector`]); none, or an empty one, is everything.
    pub on: Vec<String>,
    /// Only this repetition of the cycle or pose that each label names, counted from 0.
    pub repetition: Option<usize>,
    /// Body parts, links or DOFs; none is the whole body.
    pub parts: Vec<String>,
    /// From when to when, s; clip edits only.
    pub span_s: Option<(f64, f64)>,
}

/// Where a clip edit applies, in one clip.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipPlace {
    /// First time, s.
    pub from_s: f64,
    /// Last time, s.
    pub to_s: f64,
    /// What may be moved.
    pub dofs: BTreeSet<Dof>,
    /// The body parts as written; empty is the whole body.
    pub parts: Vec<String>,
}

impl ClipPlace {
    /// Whether `t_s` lies in the span; both ends do.
    pub fn covers(&self, t_s: f64) -> bool {
        self.from_s <= t_s && t_s <= self.to_s
    }

    /// Whether this DOF may be moved.
    pub fn allows(&self, dof: Dof) -> bool {
        self.dofs.contains(&dof)
    }
}

impl Where {
    /// Everything under one label.
    pub fn label(text: impl Into<String>) -> Self {
        Self { on: vec![text.into()], ..Self::default() }
    }

    /// A span of time, s.
    pub fn span(from_s: f64, to_s: f64) -> Self {
        Self { span_s: Some((from_s, to_s)), ..Self::default() }
    }

    /// The same place, of these body parts only.
    pub fn of<S: Into<String>>(mut self, parts: impl IntoIterator<Item = S>) -> Self {
        self.parts = parts.into_iter().map(Into::into).collect();
        self
    }

    /// The places in the script that are meant, one for each label.
    ///
    /// # Errors
    /// A repetition of something that is neither a cycle nor a pose.
    pub fn places(&self) -> Result<Vec<Place>, EditError> {
        if self.on.is_empty() {
            return Ok(vec![place("", self.repetition)?]);
        }
        self.on.iter().map(|text| place(text, self.repetition)).collect()
    }

    /// For track edits: the selectors, one for each label, to be applied one after another.
    ///
    /// # Errors
    /// As [`Where::places`]; a span, which tracks do not know.
    pub fn selectors(&self) -> Result<Vec<Selector>, EditError> {
        if self.span_s.is_some() {
            return Err(EditError::SpanOfTracks);
        }
        let places = self.places()?;
        Ok(places.into_iter().map(|place| Selector { place, parts: self.parts.clone() }).collect())
    }

    /// For clip edits: the span and the DOFs of `motion` that are meant. See the table of the module header.
    ///
    /// # Errors
    /// Unknown labels and parts; labels where there is no script; a span that is not in the clip, or has nothing in
    /// common with the labels.
    pub fn in_clip(&self, motion: &Motion) -> Result<ClipPlace, EditError> {
        let end_s = motion.clip.duration_s();
        let (mut from_s, mut to_s) = (0.0, end_s);
        if let Some((from, to)) = self.span_s {
            // half a frame of grace: written times are rounded
            let grace = 0.5 / motion.clip.rate_hz;
            let inside = from >= -grace && to <= end_s + grace && from < to;
            if !inside {
                return Err(EditError::Span { from_s: from, to_s: to, end_s });
            }
            (from_s, to_s) = (from.max(0.0), to.min(end_s));
        }
        if self.repetition.is_some() || self.on.iter().any(|text| !text.is_empty()) {
            let (start, end) = self.labelled(motion)?;
            let (on_from_s, on_to_s) = (start.max(0.0), end.min(end_s));
            if on_from_s.max(from_s) >= on_to_s.min(to_s) {
                let on = self.on.join(", ");
                return Err(EditError::SpanApart { on, on_from_s, on_to_s, from_s, to_s });
            }
            (from_s, to_s) = (on_from_s.max(from_s), on_to_s.min(to_s));
        }
        let dofs = parts_dofs(&motion.clip.skeleton, &self.parts)?;
        Ok(ClipPlace { from_s, to_s, dofs, parts: self.parts.clone() })
    }

    /// First start and last end of the elements of all labels, in the time of the clip, s.
    fn labelled(&self, motion: &Motion) -> Result<(f64, f64), EditError> {
        let places = self.places()?;
        let Some(tracks) = &motion.tracks else {
            return Err(EditError::NoScript { on: self.on.join(", "), end_s: motion.clip.duration_s() });
        };
        let (mut start, mut end) = (f64::INFINITY, f64::NEG_INFINITY);
        for place in places {
            let selection = Selector::at(place).select(tracks)?;
            for (_, e) in tracks.elements().filter(|(_, e)| selection.contains(&e.label)) {
                (start, end) = (start.min(e.start_s), end.max(e.ends_s()));
            }
        }
        // a pose of pauses has no elements
        if start >= end {
            return Err(EditError::NoTime { on: self.on.join(", ") });
        }
        Ok((motion.times.at(start), motion.times.at(end)))
    }
}

/// A label as text; with a repetition it must be that of a cycle (`twist_0`) or a pose (`twist_0_1`).
fn place(text: &str, repetition: Option<usize>) -> Result<Place, EditError> {
    let Some(n) = repetition else {
        return Ok(if text.is_empty() { Place::Script } else { Place::Label(text.into()) });
    };
    let number = |s: &str| s.parse::<usize>().ok();
    if let Some((rest, last)) = text.rsplit_once('_')
        && let Some(last) = number(last)
    {
        if let Some((action, cycle)) = rest.rsplit_once('_')
            && let Some(cycle) = number(cycle)
        {
            let action = action.to_owned();
            return Ok(Place::Pose { action, cycle, pose: last, repetition: Some(n) });
        }
        return Ok(Place::Repetition { action: rest.to_owned(), cycle: last, repetition: n });
    }
    Err(EditError::Repetition { repetition: n, found: text.into() })
}
