//! A changed span first: what an edit makes of some seconds of a long clip, before the rest is done.
//!
//! In: an edit, a motion, a span. Out: the frames of the span, from a part of the clip with [`MARGIN_S`] on both sides. Features reach 0.125 s,
//! and what the blend takes from far frames falls off within a few tenths of a second, so that the frames are those of the whole
//! clip to [`SAME_RAD`]. Two things need the whole: a way over the ground that the edit changes, which here begins at the source's place, and
//! contacts that are kept, which here are free.
//!
//! Units: s.

use std::ops::Range;

use motion::Clip;

use super::{ByExample, Contacts, ExampleError};
use crate::{ClipPlace, Motion};

/// Time on both sides of the span that is predicted too, s.
pub const MARGIN_S: f64 = 1.0;
/// Rotations of the span are those of the whole to this, rad.
pub const SAME_RAD: f64 = 1e-4;

/// Some frames of a result, at the times of the source.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Which frames.
    pub frames: Range<usize>,
    /// They.
    pub clip: Clip,
}

/// What `edit` makes of the frames from `span_s.0` to `span_s.1` of a motion. See the module header.
///
/// # Errors
/// As [`ByExample::run`]; a span without frames.
pub fn first(
    edit: &ByExample,
    motion: &Motion,
    at: &ClipPlace,
    span_s: (f64, f64),
) -> Result<Part, ExampleError> {
    let clip = &motion.clip;
    let (rate_hz, last) = (clip.rate_hz, clip.frames() - 1);
    let (from, to) = ((span_s.0 * rate_hz).round(), (span_s.1 * rate_hz).round());
    if !(from >= 0.0 && from <= to && from <= last as f64) {
        let (pair, (from_s, to_s)) = ("the clip".into(), span_s);
        return Err(ExampleError::Span { pair, from_s, to_s, end_s: clip.duration_s() });
    }
    let frames = from as usize..(to as usize).min(last) + 1;
    let margin = (MARGIN_S * rate_hz).ceil() as usize;
    let (a, b) = (frames.start.saturating_sub(margin), (frames.end + margin).min(last + 1));
    let nq = clip.skeleton.nq();
    let cut = |clip: &Clip, of: Range<usize>| {
        Clip::new(clip.skeleton.clone(), clip.rate_hz, clip.data()[of.start * nq..of.end * nq].to_vec())
    };
    let seen = motion.seen.as_ref().map(|seen| cut(seen, a..b));
    let part = Motion { floor_m: motion.floor_m, seen, ..Motion::of(cut(clip, a..b)) };
    let start_s = a as f64 / rate_hz;
    let here = |t: f64| (t - start_s).clamp(0.0, part.clip.duration_s());
    let at = ClipPlace { from_s: here(at.from_s), to_s: here(at.to_s), ..at.clone() };
    let edit = ByExample { contacts: Contacts::Free, ..edit.clone() };
    let done = edit.run(&part, &at)?;
    Ok(Part { clip: cut(&done.untimed, frames.start - a..frames.end - a), frames })
}
