//! Contact plans: which point of a body stands, from when to when, and where.
//!
//! In: [`Contact`]s in any order. Out: a [`ContactPlan`], sorted and checked. It says what is asked of a motion, not
//! what a simulation found; it holds for scripts, clips and retargeted motion alike.
//!
//! A point is named as the body names it: a limb (its end stands: a foot, a hand), a link, or a site (a heel, a
//! toe). The plan does not know the body, so it does not check that the name exists.
//!
//! Units and frames: s, both ends of a contact included; `world_from_point` in m, y up.

use std::cmp::Ordering;
use std::ops::Range;

use thiserror::Error;

use crate::{TimeMap, Transform};

/// A time in which one point stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// The point: name of a limb, link or site.
    pub point: String,
    /// First time of contact, s.
    pub from_s: f64,
    /// Last time of contact, s.
    pub to_s: f64,
    /// Where it stands and how it is turned; `None` where that is not known.
    pub world_from_point: Option<Transform>,
}

impl Contact {
    /// Its frames of a clip of so many: those whose times it has; empty where the clip has none of them.
    pub fn frames(&self, rate_hz: f64, frames: usize) -> Range<usize> {
        // frame times are not exact in binary
        let first = (self.from_s * rate_hz - 1e-6).ceil().max(0.0) as usize;
        let end = ((self.to_s * rate_hz + 1e-6).floor() + 1.0).max(0.0) as usize;
        let end = end.min(frames);
        first.min(end)..end
    }
}

/// Why contacts are no plan.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ContactPlanError {
    /// A contact without a name.
    #[error("the contact from {from_s} s to {to_s} s names no point")]
    Unnamed {
        /// Start, s.
        from_s: f64,
        /// End, s.
        to_s: f64,
    },
    /// Times that are not finite, or in the wrong order.
    #[error(
        "the contact of `{point}` is from {from_s} s to {to_s} s; allowed: finite times, the first no later than the last"
    )]
    Times {
        /// The point.
        point: String,
        /// Start, s.
        from_s: f64,
        /// End, s.
        to_s: f64,
    },
    /// A place with a number that is not finite.
    #[error(
        "the contact of `{point}` from {from_s} s to {to_s} s has a place with a number that is not finite"
    )]
    Place {
        /// The point.
        point: String,
        /// Start, s.
        from_s: f64,
        /// End, s.
        to_s: f64,
    },
    /// Two contacts of one point at one time.
    #[error(
        "the contact of `{point}` from {from_s} s begins before the one that ends at {before_to_s} s has ended; a point has one contact at a time"
    )]
    Overlap {
        /// The point.
        point: String,
        /// Start of the later one, s.
        from_s: f64,
        /// End of the earlier one, s.
        before_to_s: f64,
    },
}

/// What stands when. See the module header.
///
/// # Examples
/// ```
/// use motion::contact_plan::{Contact, ContactPlan};
/// let foot = |from_s, to_s| Contact { point: "leg_l".into(), from_s, to_s, world_from_point: None };
/// let plan = ContactPlan::new(vec![foot(1.5, 2.0), foot(0.0, 1.0)]).unwrap();
/// assert_eq!(plan.of("leg_l").next().unwrap().to_s, 1.0);
/// assert_eq!(plan.at(1.2).count(), 0); // it steps
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactPlan {
    contacts: Vec<Contact>,
}

impl ContactPlan {
    /// The plan of these contacts, in order of their start, then of their name.
    ///
    /// # Errors
    /// See [`ContactPlanError`]. Contacts include both ends, so one that begins when another of its point ends
    /// overlaps it.
    pub fn new(mut contacts: Vec<Contact>) -> Result<Self, ContactPlanError> {
        for c in &contacts {
            let (point, from_s, to_s) = (c.point.clone(), c.from_s, c.to_s);
            if c.point.is_empty() {
                return Err(ContactPlanError::Unnamed { from_s, to_s });
            }
            if !from_s.is_finite() || !to_s.is_finite() || from_s > to_s {
                return Err(ContactPlanError::Times { point, from_s, to_s });
            }
            if c.world_from_point.is_some_and(|w| !w.to_homogeneous().iter().all(|x| x.is_finite())) {
                return Err(ContactPlanError::Place { point, from_s, to_s });
            }
        }
        contacts.sort_by(order);
        for (i, later) in contacts.iter().enumerate() {
            let earlier = contacts[..i].iter().rev().find(|c| c.point == later.point);
            if let Some(earlier) = earlier.filter(|e| e.to_s >= later.from_s) {
                return Err(ContactPlanError::Overlap {
                    point: later.point.clone(),
                    from_s: later.from_s,
                    before_to_s: earlier.to_s,
                });
            }
        }
        Ok(Self { contacts })
    }

    /// All contacts, in order of their start, then of their name.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Whether nothing ever stands.
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    /// What stands at `t_s`.
    pub fn at(&self, t_s: f64) -> impl Iterator<Item = &Contact> {
        self.contacts.iter().filter(move |c| c.from_s <= t_s && t_s <= c.to_s)
    }

    /// The contacts of one point, in order.
    pub fn of<'a>(&'a self, point: &'a str) -> impl Iterator<Item = &'a Contact> {
        self.contacts.iter().filter(move |c| c.point == point)
    }

    /// Whether a point stands, frame by frame of a clip of so many.
    pub fn stands(&self, point: &str, rate_hz: f64, frames: usize) -> Vec<bool> {
        let mut stands = vec![false; frames];
        self.of(point).for_each(|c| stands[c.frames(rate_hz, frames)].fill(true));
        stands
    }

    /// The points that ever stand, in order of their names.
    pub fn points(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.contacts.iter().map(|c| c.point.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// The part from `from_s` to `to_s`, by the clock of a motion that begins at `from_s`.
    pub fn between(&self, from_s: f64, to_s: f64) -> Self {
        let inside = self.contacts.iter().filter(|c| c.to_s >= from_s && c.from_s <= to_s);
        let cut = |c: &Contact| Contact {
            from_s: c.from_s.max(from_s) - from_s,
            to_s: c.to_s.min(to_s) - from_s,
            ..c.clone()
        };
        let mut contacts: Vec<Contact> = inside.map(cut).collect();
        contacts.sort_by(order);
        Self { contacts }
    }

    /// The plan of the motion retimed by `times`: places stay, times follow.
    pub fn retimed(&self, times: &TimeMap) -> Self {
        let retimed =
            |c: &Contact| Contact { from_s: times.at(c.from_s), to_s: times.at(c.to_s), ..c.clone() };
        let mut contacts: Vec<Contact> = self.contacts.iter().map(retimed).collect();
        contacts.sort_by(order);
        Self { contacts }
    }
}

fn order(a: &Contact, b: &Contact) -> Ordering {
    a.from_s.total_cmp(&b.from_s).then_with(|| a.point.cmp(&b.point))
}
