//! Tension: how stiffly the muscles hold what the elements ask for.
//!
//! In: selected elements. Out: their dimensionless tension multiplied, or set. Kinematics ignores it;
//! the dynamic pass does not. 1 is relaxed and natural.
//!
//! A joint has a base tension before any element moves it. It is changed too where the whole script is
//! selected; and where body parts are named, for joints that no element ever moves: such a joint
//! has only one tension, the base, for the whole motion, so a tense arm is tense down to the wrist.
//! A parameter curve is then read at time 0, repetition 0.
//!
//! *On a clip* there are no elements: the tension of the joints named is changed over the span ([`Tension::on_clip`]), as steps
//! over time; a curve is read every 0.05 s.

use motion::{Dof, Tracks};

use crate::fit_place::FitPlace;
use crate::param::{Instant, PoseOrder};
use crate::poses::selected;
use crate::{EditError, EditLog, Motion, Parameter, Selection, TrackEdit, Where};

/// How tension is changed.
#[derive(Clone, Debug, PartialEq)]
pub enum Amount {
    /// Multiplied by this, > 0; 1 changes nothing.
    Factor(Parameter),
    /// Set to this dimensionless value, > 0.
    Absolute(Parameter),
}

/// Tension of a joint from a time on: s (ascending), 1 is natural; before the first it is that of the first. None: natural throughout.
pub type Steps = Vec<(f64, f64)>;

/// Between two steps of a curve, s.
const STEP_S: f64 = 0.05;

/// The tension edit. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Tension {
    /// By how much, or to what.
    pub amount: Amount,
}

impl Tension {
    /// Changes the tension of a clip's joints over time.
    ///
    /// * `steps`: of each link's joint
    /// * `fixed`: links whose tension is not the clip's to say, and why; `parts` that name one are refused, and the whole body is
    ///   all but them
    ///
    /// # Errors
    /// Places that the motion does not have, parameters that make no sense.
    pub fn on_clip(
        &self,
        motion: &Motion,
        at: &Where,
        fixed: (&[usize], &str),
        steps: &mut [Steps],
        log: &mut EditLog,
    ) -> Result<(), EditError> {
        let place = at.in_clip(motion)?;
        let (parameter, what) = match &self.amount {
            Amount::Factor(p) => (p, "factor"),
            Amount::Absolute(p) => (p, "absolute"),
        };
        parameter.of_time(self.name(), what)?;
        parameter.check(self.name(), what, 0, "above 0", |x| x > 0.0)?;
        let s = &motion.clip.skeleton;
        let (fixed, why) = fixed;
        let mut links: Vec<usize> = place.dofs.iter().map(|dof| dof.link()).filter(|l| *l != 0).collect();
        links.dedup();
        if let Some(held) = links.iter().find(|l| fixed.contains(l)).filter(|_| !place.parts.is_empty()) {
            let what = format!("{}: {why}", s.links()[*held].name);
            return Err(EditError::NothingFitted { edit: self.name(), what });
        }
        let left_out = links.iter().any(|l| fixed.contains(l));
        links.retain(|l| !fixed.contains(l));
        if links.is_empty() {
            let what = "the root has no muscles; name joints in `parts`".into();
            return Err(EditError::NothingFitted { edit: self.name(), what });
        }
        for link in &links {
            let before = std::mem::take(&mut steps[*link]);
            let was = |t: f64| {
                let next = before.partition_point(|(from_s, _)| *from_s <= t);
                before.get(next.saturating_sub(1)).map_or(1.0, |step| step.1)
            };
            let mut times: Vec<f64> = before.iter().map(|step| step.0).collect();
            times.extend([0.0, place.from_s]);
            if let Parameter::OverTime(_) = parameter {
                let n = ((place.to_s - place.from_s) / STEP_S).ceil() as usize;
                times.extend((0..n).map(|i| place.from_s + i as f64 * STEP_S));
            }
            if place.to_s < motion.clip.duration_s() {
                times.push(place.to_s);
            }
            times.sort_by(f64::total_cmp);
            let now = |t: f64| {
                let old = was(t);
                if t < place.from_s || (t >= place.to_s && place.to_s < motion.clip.duration_s()) {
                    return old;
                }
                let x = parameter.at(&Instant { time_s: t, repetition: 0, pose: 0 });
                if matches!(self.amount, Amount::Factor(_)) { old * x } else { x }
            };
            steps[*link] = times.into_iter().map(|t| (t, now(t))).collect();
            steps[*link].dedup_by(|b, a| a.1 == b.1 || a.0 == b.0);
        }
        log.begin(self.name());
        let names: Vec<&str> = links.iter().map(|l| s.links()[*l].name.as_str()).collect();
        let (from_s, to_s) = (place.from_s, place.to_s);
        log.note(format!("tension of {} from {from_s:.3} s to {to_s:.3} s", names.join(", ")));
        if left_out {
            let names: Vec<&str> = fixed.iter().map(|l| s.links()[*l].name.as_str()).collect();
            log.note(format!("left out: {}: {why}", names.join(", ")));
        }
        Ok(())
    }
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

    fn change_fit(&self, _: &mut Tracks, _: &FitPlace, _: &mut EditLog) -> Result<(), EditError> {
        Err(EditError::NotOfFits { edit: self.name() })
    }
}
