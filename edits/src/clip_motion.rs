//! What clip edits are given, and what they give: a clip with what else is known of it.
//!
//! In: a clip, wherever it came from. Out: the values that one edit hands to the next: a [`Motion`] before it, an
//! [`Edited`] after it.
//!
//! Units: s, m.

use std::sync::Arc;

use motion::{Clip, ContactPlan, TimeMap, Tracks};

/// A motion as clip edits see it.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// What moves.
    pub clip: Clip,
    /// What stands when; empty where that is not known.
    pub contacts: ContactPlan,
    /// Height of the floor, m; `None` where there is none.
    pub floor_m: Option<f64>,
    /// The script it was sampled from, in the script's own time.
    pub tracks: Option<Arc<Tracks>>,
    /// The motion as it will be seen, where that is known to differ: with feet planted, which a script has only afterwards. Frames are those
    /// of `clip`. What recognises a motion looks at this one; what is changed is `clip`.
    pub seen: Option<Clip>,
    /// The motion before any edit, in its own time; `None` where it is `clip`.
    pub unedited: Option<Arc<Clip>>,
    /// From the time of the motion before any clip edit (the script's) to that of `clip`.
    pub times: TimeMap,
}

impl Motion {
    /// A clip of which nothing else is known.
    pub fn of(clip: Clip) -> Self {
        Self {
            clip,
            contacts: ContactPlan::default(),
            floor_m: None,
            tracks: None,
            seen: None,
            unedited: None,
            times: TimeMap::identity(),
        }
    }

    /// The motion after an edit, for the next one.
    pub fn with(self, edited: Edited) -> Self {
        let times = self.times.then(&edited.times);
        Self { clip: edited.clip, contacts: edited.contacts, times, seen: None, ..self }
    }
}

/// What a clip edit gives.
#[derive(Clone, Debug, PartialEq)]
pub struct Edited {
    /// The clip, of the same skeleton at the same rate.
    pub clip: Clip,
    /// What stands when, in its time.
    pub contacts: ContactPlan,
    /// From the time of the clip given to that of this one; the lengths of the clips follow it.
    pub times: TimeMap,
}

impl Edited {
    /// The motion as it was, for an edit to change.
    pub fn unchanged(motion: &Motion) -> Self {
        Self { clip: motion.clip.clone(), contacts: motion.contacts.clone(), times: TimeMap::identity() }
    }

    /// The motion retimed, contacts with it.
    pub fn retimed(motion: &Motion, times: TimeMap) -> Self {
        Self { clip: times.retime(&motion.clip), contacts: motion.contacts.retimed(&times), times }
    }
}
