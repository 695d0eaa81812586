//! Warp: retiming by anchors. What was at one time comes at another.
//!
//! In: anchors `(from_s, to_s)` in the time of the clip as the edits before left it; a span. Out: the clip and its
//! contacts retimed by a [`TimeMap`]: poses stay what they are, velocities are divided by the slope.
//!
//! - *The beginning of the span stays* where it is. If the first anchor lies later and is moved, the beginning is an
//!   anchor too, so what is between the two is stretched; if the first anchor is not moved, nothing before it is.
//! - *After the last anchor* nothing is stretched: it is shifted by what the last anchor was moved, and so is all that
//!   comes after the span.
//! - *Slopes are continuous*, at the outermost anchors too, where the motion goes on outside ([`End::Joined`]). The
//!   exception is an interval at the outside that runs more than twice as fast: the log then states the jump. At the
//!   beginning and the end of the clip the slope is what the anchors suggest ([`End::Free`]): two anchors there
//!   make the whole clip uniformly slower or faster.
//!
//! A warp retimes the whole body; naming parts is refused. Anchors that change no time are the identity, to the bit.
//!
//! Symbols: slope = retimed seconds for each second before; 2 is twice as slow.

use motion::TimeMap;
use motion::time_map::{End, TimeMapError};

use crate::{ClipEdit, ClipPlace, EditError, EditLog, Edited, Motion};

/// Times that differ by less are one time, s.
const SAME_S: f64 = 1e-9;

/// Retiming by anchors. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Warp {
    /// What was at the first time comes at the second, s; in order.
    pub anchors: Vec<(f64, f64)>,
}

impl Warp {
    /// The anchors, with the beginning of the span where it is one.
    fn anchors(&self, at: &ClipPlace) -> Result<Vec<(f64, f64)>, EditError> {
        let outside = |t: f64| t < at.from_s - SAME_S || t > at.to_s + SAME_S;
        if let Some(index) = self.anchors.iter().position(|(from, _)| outside(*from)) {
            let anchor_s = self.anchors[index].0;
            return Err(EditError::AnchorOutside { index, anchor_s, from_s: at.from_s, to_s: at.to_s });
        }
        let mut anchors = self.anchors.clone();
        if let Some(&(from, to)) = anchors.first() {
            let (begins, moves) = (from <= at.from_s + SAME_S, (from - to).abs() > SAME_S);
            if begins && moves {
                return Err(EditError::AnchorStart { from_s: at.from_s, to_s: to });
            }
            if !begins && (moves || anchors.len() == 1) {
                anchors.insert(0, (at.from_s, at.from_s));
            }
        }
        Ok(anchors)
    }
}

/// The error with its anchors counted as they were written, `added` of them not.
fn renumbered(mut error: TimeMapError, added: usize) -> TimeMapError {
    if let TimeMapError::NotFinite { index, .. } | TimeMapError::NotIncreasing { index, .. } = &mut error {
        *index = index.saturating_sub(added);
    }
    error
}

impl ClipEdit for Warp {
    fn name(&self) -> &'static str {
        "warp"
    }

    fn change(&self, motion: &Motion, at: &ClipPlace, log: &mut EditLog) -> Result<Edited, EditError> {
        if !at.parts.is_empty() {
            return Err(EditError::WholeBody { edit: self.name(), parts: at.parts.join(", ") });
        }
        let anchors = self.anchors(at)?;
        let end_s = motion.clip.duration_s();
        let goes_on = |t: f64| t > SAME_S && t < end_s - SAME_S;
        let outermost = [anchors.first(), anchors.last()].map(|a| a.map_or(0.0, |a| a.0));
        let ends = outermost.map(|t| if goes_on(t) { End::Joined } else { End::Free });
        let added = anchors.len() - self.anchors.len();
        let times = TimeMap::with_ends(&anchors, ends)
            .map_err(|e| EditError::Times { edit: self.name(), source: renumbered(e, added) })?;
        for t in outermost.into_iter().filter(|t| goes_on(*t)) {
            let slope = times.rate(t);
            if (slope - 1.0).abs() > 1e-6 {
                log.note(format!(
                    "the slope of time jumps between 1 and {slope:.3} at the anchor at {t:.3} s"
                ));
            }
        }
        Ok(Edited::retimed(motion, times))
    }
}
