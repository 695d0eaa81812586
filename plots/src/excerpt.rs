//! What of a trace a figure shows: all of it, or a span that keeps its clock, or chosen joints.
//!
//! In: a [`Trace`]. Out: an [`Excerpt`], which is a trace with a start time.

use std::borrow::Cow;
use std::ops::Deref;

use dynamics::Trace;
use dynamics::fall::{self, Fall};
use motion::Joint;

use crate::panel::Clock;

/// A trace, or a part of one. See the module header.
#[derive(Clone, Debug)]
pub struct Excerpt<'a> {
    trace: Cow<'a, Trace>,
    start_s: f64,
    joints: Option<Vec<usize>>,
    names: [&'static str; 2],
    fall: Option<Fall>,
}

/// What the two motions of a trace are called.
const NAMES: [&str; 2] = ["asked for", "performed"];

impl<'a> Excerpt<'a> {
    /// The whole trace.
    pub fn whole(trace: &'a Trace) -> Self {
        let fall = fall::of(trace);
        Self { trace: Cow::Borrowed(trace), start_s: 0.0, joints: None, names: NAMES, fall }
    }

    /// The rows from `from_s` to `to_s`, ends included; at least one row.
    pub fn between(trace: &'a Trace, from_s: f64, to_s: f64) -> Self {
        let rows = trace.rows();
        if rows == 0 {
            return Self::whole(trace);
        }
        let first = (from_s * trace.rate_hz - 1e-6).ceil().clamp(0.0, (rows - 1) as f64) as usize;
        let end = ((to_s * trace.rate_hz + 1e-6).floor() + 1.0).clamp(first as f64 + 1.0, rows as f64);
        let trace_of_span = trace.cut(first..end as usize);
        Self {
            trace: Cow::Owned(trace_of_span),
            start_s: first as f64 / trace.rate_hz,
            joints: None,
            names: NAMES,
            // of the whole run: a span may begin after the cause
            fall: fall::of(trace),
        }
    }

    /// The same with only these links' joints, where a figure shows joints.
    pub fn of_joints(mut self, links: Vec<usize>) -> Self {
        self.joints = Some(links);
        self
    }

    /// The same with other names for the motion asked for and the one performed.
    pub fn labelled(mut self, asked_for: &'static str, performed: &'static str) -> Self {
        self.names = [asked_for, performed];
        self
    }

    /// Names of the motion asked for and of the one performed.
    pub(crate) fn names(&self) -> [&'static str; 2] {
        self.names
    }

    /// The fall of the run, if its body fell.
    pub fn fall(&self) -> Option<&Fall> {
        self.fall.as_ref()
    }

    /// Time of its rows.
    pub fn clock(&self) -> Clock {
        Clock { rate_hz: self.trace.rate_hz, start_s: self.start_s }
    }

    /// Links with a joint that may be shown: those chosen, else all that muscles move, which welds and a free root are not.
    pub(crate) fn joints(&self) -> Vec<usize> {
        match &self.joints {
            Some(links) => links.clone(),
            None => {
                let links = self.trace.character.skeleton.links().iter().enumerate();
                links
                    .filter(|(_, l)| !matches!(l.joint, Joint::Fixed | Joint::Free))
                    .map(|(i, _)| i)
                    .collect()
            }
        }
    }
}

impl Deref for Excerpt<'_> {
    type Target = Trace;

    fn deref(&self) -> &Trace {
        &self.trace
    }
}

impl<'a> From<&'a Trace> for Excerpt<'a> {
    fn from(trace: &'a Trace) -> Self {
        Self::whole(trace)
    }
}

impl<'a> From<&'a Excerpt<'a>> for Excerpt<'a> {
    fn from(e: &'a Excerpt<'a>) -> Self {
        Self {
            trace: Cow::Borrowed(&e.trace),
            start_s: e.start_s,
            joints: e.joints.clone(),
            names: e.names,
            fall: e.fall.clone(),
        }
    }
}
