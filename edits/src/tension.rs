//! Tension: how stiffly the muscles hold what the elements ask for.
//!
//! In: selected elements. Out: their dimensionless tension multiplied, or set. Kinematics ignores it;
//! the dynamic pass does not. 1 is relaxed and natural.
//!
//! A joint has a base tension before any element moves it. It is changed too where the whole script is
//! selected; and where body parts are named, for joints that no element ever moves: such a joint
//! has only one tension, the base, for the whole motion, so a tense arm is tense down to the wrist.
//! A parameter curve is then read at time 0, repetition 0.

use motion::{Dof, Tracks};

use crate::param::{Instant, PoseOrder};
use crate::poses::selected;
use crate::{EditError, EditLog, Parameter, Selection, TrackEdit};

/// How tension is changed.
#[derive(Clone, Debug, PartialEq)]
pub enum Amount {
    /// Multiplied by this, > 0; 1 changes nothing.
    Factor(Parameter),
    /// Set to this dimensionless value, > 0.
    Absolute(Parameter),
}

/// The tension edit. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Tension {
    /// By how much, or to what.
    pub amount: Amount,
}

impl TrackEdit for Tension {
    fn name(&self) -> &'static str {
        "tension"
    }

    fn change(&self, tracks: &mut Tracks, selection: &Selection, _: &mut EditLog) -> Result<(), EditError> {
        let order = PoseOrder::new(selected(tracks, selection));
        let (parameter, factor) = match &self.amount {
            Amount::Factor(p) => (p, true),
            Amount::Absolute(p) => (p, false),
        };
        let what = if factor { "factor" } else { "tension" };
        parameter.check(self.name(), what, order.len(), "above 0", |x| x > 0.0)?;
        let new = |old: f64, at: &Instant| if factor { old * parameter.at(at) } else { parameter.at(at) };
        for (_, e) in tracks.elements_mut() {
            if selection.contains(&e.label) {
                e.tension = new(e.tension, &order.instant(&e.label, e.start_s));
            }
        }
        let start = Instant { time_s: 0.0, repetition: 0, pose: 0 };
        for link in 0..tracks.skeleton.links().len() {
            let Some(dof) = Dof::of_link(&tracks.skeleton, link) else { continue };
            let still = tracks.track(dof).is_none_or(|t| t.elements.is_empty());
            let base = selection.is_whole_script() || (selection.names_parts() && still);
            if base && selection.allows(dof) {
                tracks.base_tension[link] = new(tracks.base_tension[link], &start);
            }
        }
        Ok(())
    }
}
