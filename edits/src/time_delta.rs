//! Time delta: one pose dragged in time, y(t) = x(t + k(t)) (IAF09, §5).
//!
//! In: a time, when what is there shall come, and how long before and after time is bent. Out: the clip and its contacts
//! retimed by a [`TimeMap`] of three anchors: the pose moves, what is `blend_s` or more away stays when it was. A [`Warp`](crate::Warp)
//! shifts all that comes after; this is its layer for one pose, and layers add up. The length of the clip stays.
//!
//! `span_s` bounds the times that change, as the ends of the clip do: a blend that would leave them is made shorter. It is of the whole
//! body: naming parts is refused. `to_s` = `at_s` is the identity, to the bit.

use motion::TimeMap;
use motion::time_map::End;

use crate::{ClipEdit, ClipPlace, EditError, EditLog, Edited, Motion};

/// Times that differ by less are one time, s.
const SAME_S: f64 = 1e-9;

/// One pose dragged in time. See the module header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeDelta {
    /// When the pose is, s.
    pub at_s: f64,
    /// When it shall be, s.
    pub to_s: f64,
    /// How long before and after it time is bent, s, more than it is moved.
    pub blend_s: f64,
}

impl ClipEdit for TimeDelta {
    fn name(&self) -> &'static str {
        "time-delta"
    }

    fn change(&self, motion: &Motion, at: &ClipPlace, _: &mut EditLog) -> Result<Edited, EditError> {
        let edit = self.name();
        if !at.parts.is_empty() {
            return Err(EditError::WholeBody { edit, parts: at.parts.join(", ") });
        }
        for (what, t_s) in [("at_s", self.at_s), ("to_s", self.to_s)] {
            if !(t_s > at.from_s - SAME_S && t_s < at.to_s + SAME_S) {
                return Err(EditError::TimeOutside { edit, what, t_s, from_s: at.from_s, to_s: at.to_s });
            }
        }
        let moved_s = self.to_s - self.at_s;
        if moved_s.abs() < SAME_S {
            return Ok(Edited::unchanged(motion));
        }
        let (from_s, to_s) =
            ((self.at_s - self.blend_s).max(at.from_s), (self.at_s + self.blend_s).min(at.to_s));
        let room_s = if moved_s > 0.0 { to_s - self.at_s } else { self.at_s - from_s };
        if !(self.blend_s.is_finite() && room_s > moved_s.abs()) {
            return Err(EditError::NoRoom { edit, moved_s, room_s });
        }
        let end_s = motion.clip.duration_s();
        let mut anchors = vec![(self.at_s, self.to_s)];
        if from_s < self.at_s - SAME_S {
            anchors.insert(0, (from_s, from_s));
        }
        if to_s > self.at_s + SAME_S {
            anchors.push((to_s, to_s));
        }
        let joined = |t: f64| if t > SAME_S && t < end_s - SAME_S { End::Joined } else { End::Free };
        let ends = [joined(anchors[0].0), joined(anchors[anchors.len() - 1].0)];
        let times = TimeMap::with_ends(&anchors, ends).map_err(|source| EditError::Times { edit, source })?;
        Ok(Edited::retimed(motion, times))
    }
}
