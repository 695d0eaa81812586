//! Amplitude: how far a movement goes (NF03 §4.3.2).
//!
//! In: selected elements and a factor `a > 0`. Out: their end values. Per DOF, with end values `e₀` (the
//! value before), `e₁ … eₙ` and midpoints `mᵢ = (eᵢ₋₁ + eᵢ)/2`, transition `i` suggests the end
//! `mᵢ + aᵢ(eᵢ − mᵢ)` and the start `mᵢ + aᵢ(eᵢ₋₁ − mᵢ)`; a value with two suggestions takes their mean:
//!
//! - interior: `eᵢ' = eᵢ + (a − 1)[eᵢ − (mᵢ + mᵢ₊₁)/2]`
//! - last: `eₙ' = eₙ + (a − 1)(eₙ − eₙ₋₁)/2`
//! - `e₀' = e₀ + (a − 1)(e₀ − e₁)/2`, only if it is a selected element itself: one of no duration that
//!   opens its track, which places the body and is no transition. Otherwise `e₀` stays.
//!
//! Only transitions to selected elements suggest. What follows from the formulas:
//!
//! - `a = 1` is the identity, to the bit;
//! - interior values of alternating poses (… x, y, x, y …) scale exactly by `a` about the average; the
//!   first transition, from an unselected `e₀`, and the last value only half as much on their free side;
//! - a value midway between its neighbours (evenly monotone) stays where it is;
//! - `a` and then `1/a` is not the identity: midpoints have moved in between. Use a reference for that.
//!
//! With a reference pose `r`: `r + a(e − r)`, for which `a` and then `1/a` is the identity to rounding.
//! Rotations: the same with slerp, extrapolating for `a > 1`; the mean is the slerp half-way.
//! Values are kept within joint limits, or as far outside as they were before.
//!
//! *On a fit* ([`crate::on_fit`]) keys are dense, so that a value lies near the average of its neighbours and would
//! hardly move: without a reference `r` is each DOF's mean over the span.
//!
//! NF03: Neff, Fiume. Aesthetic edits for character animation. SCA 2003.

use motion::names::Word;
use motion::{Tracks, Value};

use crate::fit_place::FitPlace;
use crate::param::{Instant, PoseOrder};
use crate::poses::{selected, within_limits};
use crate::{EditError, EditLog, Parameter, Selection, TrackEdit};

/// The amplitude edit. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Amplitude {
    /// `a`, > 0: below 1 reduces, above 1 enlarges.
    pub factor: Parameter,
    /// Pose (length `nq`) about which to scale, instead of the average between poses.
    pub reference: Option<Vec<f64>>,
}

/// What an amplitude is measured from, as a scene names it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reference {
    /// The average of neighbouring poses.
    #[default]
    InterPose,
    /// The rest pose of the character.
    Rest,
}

impl Word for Reference {
    const KIND: &'static str = "reference";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::InterPose, "inter-pose", "The average of neighbouring poses"),
        (Self::Rest, "rest", "The rest pose of the character"),
    ];
}

impl Amplitude {
    /// About the average between poses.
    pub fn new(factor: impl Into<Parameter>) -> Self {
        Self { factor: factor.into(), reference: None }
    }

    /// About a pose (length `nq`).
    pub fn about(factor: impl Into<Parameter>, reference: Vec<f64>) -> Self {
        Self { factor: factor.into(), reference: Some(reference) }
    }
}

/// `to` moved away from the midpoint of `from` and `to`: `m + a(to − m)`.
fn suggestion(from: &Value, to: &Value, a: f64) -> Value {
    // = from + (½ + a/2)(to − from), written so that a = 1 is `to` itself
    Value::between(to, from, -0.5 * (a - 1.0))
}

impl TrackEdit for Amplitude {
    fn name(&self) -> &'static str {
        "amplitude"
    }

    fn change(&self, tracks: &mut Tracks, selection: &Selection, log: &mut EditLog) -> Result<(), EditError> {
        let order = PoseOrder::new(selected(tracks, selection));
        self.factor.check(self.name(), "factor", order.len(), "above 0", |x| x > 0.0)?;
        let skeleton = tracks.skeleton.clone();
        let needed = skeleton.nq();
        if let Some(r) = &self.reference
            && (r.len() != needed || !r.iter().all(|x| x.is_finite()))
        {
            let found = r.iter().filter(|x| x.is_finite()).count();
            return Err(EditError::Reference { found, needed });
        }
        for track in &mut tracks.tracks {
            let dof = track.dof;
            let base = dof.read(&skeleton, &tracks.base);
            let old = track.elements.clone();
            // the factor of each transition that suggests
            let factors: Vec<Option<f64>> = old
                .iter()
                .enumerate()
                .map(|(i, e)| {
                    let places = i == 0 && e.duration_s == 0.0 && self.reference.is_none();
                    let suggests = selection.contains(&e.label) && !places;
                    suggests.then(|| self.factor.at(&order.instant(&e.label, e.start_s)))
                })
                .collect();
            for (i, e) in track.elements.iter_mut().enumerate() {
                if !selection.contains(&e.label) {
                    continue;
                }
                let end = old[i].end;
                let changed = if let Some(reference) = &self.reference {
                    let r = dof.read(&skeleton, reference);
                    factors[i].filter(|a| *a != 1.0).map(|a| about(&r, &end, a))
                } else {
                    let before = if i == 0 { base } else { old[i - 1].end };
                    let own = factors[i].map(|a| (a, before));
                    let next = factors.get(i + 1).copied().flatten().map(|a| (a, old[i + 1].end));
                    inter_pose(&end, own, next)
                };
                if let Some(value) = changed {
                    let (value, cut) = within_limits(&skeleton, dof, &end, &value);
                    e.end = value;
                    if cut {
                        log.clamp(&e.label);
                    }
                }
            }
        }
        Ok(())
    }

    fn change_fit(&self, tracks: &mut Tracks, place: &FitPlace, log: &mut EditLog) -> Result<(), EditError> {
        self.factor.of_time(self.name(), "factor")?;
        if self.reference.is_some() {
            return self.change(tracks, &place.selection, log);
        }
        self.factor.check(self.name(), "factor", 0, "above 0", |x| x > 0.0)?;
        let skeleton = tracks.skeleton.clone();
        for track in &mut tracks.tracks {
            let Some(mean) = place.mean(&skeleton, track) else { continue };
            for e in track.elements.iter_mut().filter(|e| place.selection.contains(&e.label)) {
                // a key says where its element arrives
                let a = self.factor.at(&Instant { time_s: e.arrives_s(), repetition: 0, pose: 0 });
                if a == 1.0 {
                    continue;
                }
                let (value, cut) = within_limits(&skeleton, track.dof, &e.end, &about(&mean, &e.end, a));
                e.end = value;
                if cut {
                    log.clamp(&e.label);
                }
            }
        }
        Ok(())
    }
}

/// `r + a(e − r)`, from `e`, so that a change of `a` by a rounding error moves `e` by one.
fn about(r: &Value, e: &Value, a: f64) -> Value {
    Value::between(e, r, 1.0 - a)
}

/// The mean of what the transitions before and after suggest for `end`; `None` where nothing changes.
fn inter_pose(end: &Value, own: Option<(f64, Value)>, next: Option<(f64, Value)>) -> Option<Value> {
    let suggest = |s: Option<(f64, Value)>| s.map(|(a, other)| (a, suggestion(&other, end, a)));
    match (suggest(own), suggest(next)) {
        (Some((a, x)), None) | (None, Some((a, x))) => (a != 1.0).then_some(x),
        (Some((a, x)), Some((b, y))) => (a != 1.0 || b != 1.0).then(|| Value::between(&x, &y, 0.5)),
        (None, None) => None,
    }
}
