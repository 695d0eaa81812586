//! Extent of reach: how far the hands are from the shoulders (NF03 §4.3.3).
//!
//! In: selected poses that move an arm, and a factor `s`. Out: end values of their shoulders and elbows.
//! With `dᵢ = |hand − shoulder|` in pose `i` and the mean `d̄` over the poses selected, each arm apart:
//! `dᵢ' = s d̄ + (dᵢ − d̄)`, so the mean scales and the offsets stay: a wave comes nearer without losing its
//! shape. The arm is solved as two bones; the direction to the hand in the chest's frame and the
//! swivel of the elbow are kept. `dᵢ'` is cut to what the elbow's limits allow, and to full stretch (or `dᵢ`
//! where that was further); the log says where.
//!
//! A pose moves an arm if a selected element of it moves its shoulder or elbow. If it lacks the other of
//! the two, that element is made, with the timing, curve and tension of the one it has. A pose whose shoulder
//! or elbow is outside the selection is left alone, with a note, since reach needs both.
//!
//! The direction is kept even where that takes the shoulder past its limits, which are not enforced here;
//! those of the elbow are, so an elbow that is a limited ball may fall short of the distance.
//!
//! *On a fit* ([`crate::on_fit`]) `d̄` is the mean over time.
//!
//! A change of less than 1e-8 m counts as none: near full stretch the elbow bends with the square root of
//! the distance, and ten nanometres would be 0.4 mrad. With curves, `s` is read at each pose.

use motion::ik::{Reach, reach_range, solve_two_bone};
use motion::{Dof, Element, Kinematics, Limb, LimbKind, Tracks};

use crate::fit_place::FitPlace;
use crate::param::PoseOrder;
use crate::poses::{PoseGroup, groups, selected, within_limits};
use crate::{EditError, EditLog, Parameter, Selection, TrackEdit};

/// Changes of the distance below this are none, m.
const LEAST_CHANGE_M: f64 = 1e-8;

/// The reach extent edit. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtentReach {
    /// `s`, > 0: below 1 pulls the hands closer, above 1 moves them further out.
    pub factor: Parameter,
}

impl ExtentReach {
    /// With a factor.
    pub fn new(factor: impl Into<Parameter>) -> Self {
        Self { factor: factor.into() }
    }
}

/// One arm in one pose.
struct Hand {
    group: PoseGroup,
    /// The pose, length `nq`.
    q: Vec<f64>,
    /// The element whose timing a missing one copies.
    model: Element,
    distance_m: f64,
}

impl TrackEdit for ExtentReach {
    fn name(&self) -> &'static str {
        "extent_reach"
    }

    fn change(&self, tracks: &mut Tracks, selection: &Selection, log: &mut EditLog) -> Result<(), EditError> {
        self.reach(tracks, selection, None, log)
    }

    fn change_fit(&self, tracks: &mut Tracks, place: &FitPlace, log: &mut EditLog) -> Result<(), EditError> {
        self.factor.of_time(self.name(), "factor")?;
        self.reach(tracks, &place.selection, Some(place), log)
    }
}

impl ExtentReach {
    /// Changes the poses selected; on a fit `d̄` is the mean over the time of `place`, since its keys are denser here than there.
    fn reach(
        &self,
        tracks: &mut Tracks,
        selection: &Selection,
        place: Option<&FitPlace>,
        log: &mut EditLog,
    ) -> Result<(), EditError> {
        let order = PoseOrder::new(selected(tracks, selection));
        self.factor.check(self.name(), "factor", order.len(), "above 0", |x| x > 0.0)?;
        let skeleton = tracks.skeleton.clone();
        let before = tracks.clone();
        let poses = groups(&before, selection);
        for limb in skeleton.limbs().iter().filter(|l| l.kind == LimbKind::Arm) {
            let hands = hands(&before, selection, &poses, limb, log);
            let mean = match place {
                Some(place) => place.mean_of(&before, |k| (k.origin(limb.end) - k.origin(limb.upper)).norm()),
                None => hands.iter().map(|h| h.distance_m).sum::<f64>() / hands.len().max(1) as f64,
            };
            for hand in hands {
                let s = self.factor.at(&order.instant(&hand.model.label, hand.model.start_s));
                // s d̄ + (dᵢ − d̄)
                let wanted = hand.distance_m + (s - 1.0) * mean;
                if (wanted - hand.distance_m).abs() >= LEAST_CHANGE_M {
                    solve(tracks, limb, hand, wanted, log)?;
                }
            }
        }
        Ok(())
    }
}

/// DOFs of the shoulder and the elbow.
fn dofs(tracks: &Tracks, limb: &Limb) -> [Option<Dof>; 2] {
    [limb.upper, limb.lower].map(|l| Dof::of_link(&tracks.skeleton, l))
}

/// The poses that move the arm and may be changed.
fn hands(
    tracks: &Tracks,
    selection: &Selection,
    poses: &[PoseGroup],
    limb: &Limb,
    log: &mut EditLog,
) -> Vec<Hand> {
    let [Some(shoulder), Some(elbow)] = dofs(tracks, limb) else { return Vec::new() };
    let mut hands = Vec::new();
    for group in poses {
        let Some(model) = group.element(shoulder).or_else(|| group.element(elbow)) else { continue };
        // what the pose has must be selected, what it lacks must be allowed
        let free = [shoulder, elbow].into_iter().all(|dof| {
            let unselected = group.others.iter().any(|(d, _)| *d == dof);
            !unselected && (selection.allows(dof) || group.element(dof).is_some())
        });
        if !free {
            let label = model.label.named(&tracks.skeleton);
            log.note(format!(
                "{label} left alone: reach needs both shoulder and elbow of {} selected",
                limb.name
            ));
            continue;
        }
        let q = group.goal(tracks);
        let k = Kinematics::new(&tracks.skeleton, &q);
        let distance_m = (k.origin(limb.end) - k.origin(limb.upper)).norm();
        hands.push(Hand { group: group.clone(), model: model.clone(), q, distance_m });
    }
    hands
}

/// Solves the arm for the distance `wanted` (m) and writes shoulder and elbow.
fn solve(
    tracks: &mut Tracks,
    limb: &Limb,
    mut hand: Hand,
    wanted: f64,
    log: &mut EditLog,
) -> Result<(), EditError> {
    let skeleton = tracks.skeleton.clone();
    let (least, most) = reach_range(&skeleton, &hand.q, limb)?;
    let d = wanted.clamp(least.min(hand.distance_m), most.max(hand.distance_m));
    if d != wanted {
        log.clamp(&hand.model.label);
    }
    let k = Kinematics::new(&skeleton, &hand.q);
    let shoulder = k.origin(limb.upper);
    let direction = k.origin(limb.end) - shoulder;
    if direction.norm() < 1e-9 || (d - hand.distance_m).abs() < LEAST_CHANGE_M {
        return Ok(());
    }
    let before = hand.q.clone();
    let target = shoulder + direction * (d / hand.distance_m);
    if let Reach::Clamped { .. } = solve_two_bone(&skeleton, &mut hand.q, limb, &target)?
        && d == wanted
    {
        log.clamp(&hand.model.label);
    }
    for dof in dofs(tracks, limb).into_iter().flatten() {
        let mut end = dof.read(&skeleton, &hand.q);
        if dof.link() == limb.lower {
            // a hinge is within its limits already, a ball may not be
            let (allowed, cut) = within_limits(&skeleton, dof, &dof.read(&skeleton, &before), &end);
            end = allowed;
            if cut {
                log.clamp(&hand.model.label);
            }
        }
        let Some(index) = dof.index(&skeleton) else { continue };
        let Some(track) = tracks.track_mut(dof) else { continue };
        if let Some(old) = hand.group.element(dof) {
            for e in track.elements.iter_mut().filter(|e| e.label == old.label) {
                e.end = end;
            }
        } else {
            let mut made = Element { end, ..hand.model.clone() };
            made.label.dof = index;
            track.insert(made);
        }
    }
    Ok(())
}
