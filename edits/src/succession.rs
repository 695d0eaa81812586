//! Succession: movement that runs through the body joint by joint (NF03 §4.3.1).
//!
//! In: selected poses, a direction and an offset `t` (s). Out: start times, and holds that had to shrink.
//! Within each pose the start of an element shifts by `t × depth` of its joint (forward, from the hip out),
//! or by `t × height` above the furthest tip of its branch (reverse, from the extremities in).
//!
//! Depth counts joints from the root along all branches in parallel: the first joint of each branch and the
//! root itself are 0, the next moved joint is 1. Only joints count that the pose moves: with a selected
//! element whose end differs from where the DOF was (a joint that only holds its place is shifted with
//! its neighbours but does not count). Welded links never count, and joints at one place
//! (a link without length between them, as three hinges that make a hip) count once. Reverse mirrors this: the
//! furthest selected tip of each branch is 0, the root starts with its last branch. The least shift of a pose
//! is 0.
//!
//! Elements of one DOF stay serial: where the next would start too early, the hold before it shrinks;
//! if that is not enough the earlier transition is superseded. An element never starts after its
//! successor: a shift that would do that ends at the successor's start.
//!
//! *On a fit* ([`crate::on_fit`]) there are no poses that start together: depth is counted once, over all joints that
//! move in the span, and every key of a joint comes later by it. Captured motion is in motion where the span begins, so
//! lateness grows from there, and wanes before the end of a span after which the clip goes on.
//!
//! Offsets may be a list over the poses (0.2 s, then 0.3 s) or a curve. Negative offsets are refused: that is
//! what the direction is for.

use std::collections::{BTreeMap, BTreeSet};

use motion::fit::lasting;
use motion::names::Word;
use motion::{Dof, Joint, Label, Skeleton, Track, Tracks, smoothstep};

use crate::fit_place::FitPlace;
use crate::param::{Instant, PoseOrder};
use crate::poses::{PoseGroup, groups, selected};
use crate::{EditError, EditLog, Parameter, Selection, TrackEdit};

/// Which way a succession runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// From the hip to the extremities: flowing, natural.
    #[default]
    Forward,
    /// From the extremities to the hip: false, sinister.
    Reverse,
}

impl Word for Direction {
    const KIND: &'static str = "direction";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Forward, "forward", "From the hips outward"),
        (Self::Reverse, "reverse", "From the extremities inward"),
    ];
}

/// The succession edit. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Succession {
    /// `t`, s, 0 or more.
    pub offset_s: Parameter,
    /// Which way.
    pub direction: Direction,
}

impl Succession {
    /// From the hip out.
    pub fn forward(offset_s: impl Into<Parameter>) -> Self {
        Self { offset_s: offset_s.into(), direction: Direction::Forward }
    }

    /// From the extremities in.
    pub fn reverse(offset_s: impl Into<Parameter>) -> Self {
        Self { offset_s: offset_s.into(), direction: Direction::Reverse }
    }
}

/// Links at one place count as one joint.
const ZERO_LENGTH_M: f64 = 1e-9;

/// Depth (forward) or height (reverse) of every link, counting the joints in `moved` (one flag per link).
///
/// See the module header; the root and links that no moved joint precedes are 0.
pub fn ranks(skeleton: &Skeleton, moved: &[bool], direction: Direction) -> Vec<usize> {
    let links = skeleton.links();
    // the first of the links at one place stands for all; never the root, which does not count
    let mut place = vec![0; links.len()];
    for (i, link) in links.iter().enumerate().skip(1) {
        let p = link.parent.unwrap_or(0);
        let apart = link.parent_from_zero.translation.vector.norm() > ZERO_LENGTH_M;
        place[i] = if apart || p == 0 { i } else { place[p] };
    }
    let mut counts = vec![false; links.len()];
    for i in 1..links.len() {
        counts[place[i]] |= moved[i] && links[i].joint != Joint::Fixed;
    }
    let above = |i: usize| links[place[i]].parent.map_or(0, |p| place[p]);
    let mut rank = vec![0_usize; links.len()];
    match direction {
        Direction::Forward => {
            for i in (1..links.len()).filter(|&i| place[i] == i) {
                let p = above(i);
                rank[i] = rank[p] + usize::from(counts[p]);
            }
        }
        Direction::Reverse => {
            // children come after their parents
            for i in (1..links.len()).rev().filter(|&i| place[i] == i) {
                let p = above(i);
                // the root moves with the first joint of its longest branch
                let step = usize::from(counts[i] && p != 0);
                rank[p] = rank[p].max(rank[i] + step);
            }
        }
    }
    (0..links.len()).map(|i| rank[place[i]]).collect()
}

/// The elements that end elsewhere than the DOF was before.
pub fn moving(tracks: &Tracks) -> BTreeSet<Label> {
    let mut moves = BTreeSet::new();
    for track in &tracks.tracks {
        let mut before = track.dof.read(&tracks.skeleton, &tracks.base);
        for e in &track.elements {
            if before.distance(&e.end) > 1e-9 {
                moves.insert(e.label.clone());
            }
            before = e.end;
        }
    }
    moves
}

/// Depth (forward) or height (reverse) of the joint of every selected element of a pose, counting the joints that it moves;
/// `moves`: as [`moving`].
pub fn ranks_in_pose(
    skeleton: &Skeleton,
    group: &PoseGroup,
    moves: &BTreeSet<Label>,
    direction: Direction,
) -> Vec<usize> {
    let mut moved = vec![false; skeleton.links().len()];
    for (dof, e) in &group.elements {
        moved[dof.link()] |= moves.contains(&e.label);
    }
    let rank = ranks(skeleton, &moved, direction);
    group.elements.iter().map(|(dof, _)| rank[dof.link()]).collect()
}

/// Shift of every selected element of a pose, s.
fn shifts(
    skeleton: &Skeleton,
    group: &PoseGroup,
    moves: &BTreeSet<Label>,
    offset_s: f64,
    direction: Direction,
) -> Vec<(Label, f64)> {
    let rank = ranks_in_pose(skeleton, group, moves, direction);
    let least = rank.iter().copied().min().unwrap_or(0);
    let labels = group.elements.iter().map(|(_, e)| e.label.clone());
    labels.zip(rank).map(|(label, rank)| (label, offset_s * (rank - least) as f64)).collect()
}

impl TrackEdit for Succession {
    fn name(&self) -> &'static str {
        "succession"
    }

    fn change(&self, tracks: &mut Tracks, selection: &Selection, log: &mut EditLog) -> Result<(), EditError> {
        let order = PoseOrder::new(selected(tracks, selection));
        self.offset_s.check(self.name(), "offset_s", order.len(), "0 s or more", |x| x >= 0.0)?;
        let mut shift: BTreeMap<Label, f64> = BTreeMap::new();
        let moves = moving(tracks);
        for group in groups(tracks, selection) {
            let t = self.offset_s.at(&order.instant(group.label(), group.start_s()));
            let of_pose = shifts(&tracks.skeleton, &group, &moves, t, self.direction);
            shift.extend(of_pose.into_iter().filter(|(_, s)| *s > 0.0));
        }
        for track in &mut tracks.tracks {
            let elements = &mut track.elements;
            let mut capped = Vec::new();
            // from the last back: the successor's new start is known
            for i in (0..elements.len()).rev() {
                let by = shift.get(&elements[i].label).copied().unwrap_or(0.0);
                let next = elements.get(i + 1).map(|n| n.start_s);
                let e = &mut elements[i];
                let was = e.start_s;
                e.start_s += by;
                let Some(next) = next else { continue };
                if by > 0.0 && e.start_s > next {
                    e.start_s = next.max(was);
                    capped.push(e.label.clone());
                }
                let moved = by > 0.0 || elements.get(i + 1).is_some_and(|n| shift.contains_key(&n.label));
                let room = (next - elements[i].arrives_s()).max(0.0);
                // less than a nanosecond is rounding of serial times
                if moved && room + 1e-9 < elements[i].hold_s {
                    elements[i].hold_s = room;
                }
            }
            for label in capped {
                let name = label.named(&tracks.skeleton);
                log.note(format!("{name} would start after its successor and is superseded at once"));
            }
        }
        Ok(())
    }

    fn change_fit(&self, tracks: &mut Tracks, place: &FitPlace, log: &mut EditLog) -> Result<(), EditError> {
        self.offset_s.of_time(self.name(), "offset_s")?;
        self.offset_s.check(self.name(), "offset_s", 0, "0 s or more", |x| x >= 0.0)?;
        let moves = moving(tracks);
        let links = tracks.skeleton.links().len();
        let (mut moved, mut least) = (vec![false; links], usize::MAX);
        let selected: Vec<(Dof, &Label)> = tracks
            .elements()
            .map(|(dof, e)| (dof, &e.label))
            .filter(|(_, label)| place.selection.contains(label))
            .collect();
        for (dof, label) in &selected {
            moved[dof.link()] |= moves.contains(label);
        }
        let rank = ranks(&tracks.skeleton, &moved, self.direction);
        for (dof, _) in &selected {
            least = least.min(rank[dof.link()]);
        }
        for track in &mut tracks.tracks {
            let steps = rank[track.dof.link()].saturating_sub(least);
            if steps == 0 || !place.selection.allows(track.dof) {
                continue;
            }
            if late(track, place, &self.offset_s, steps) {
                let name = track.dof.name(&tracks.skeleton);
                log.note(format!("{name}: the span is too short for it to come as late as asked"));
            }
        }
        Ok(())
    }
}

/// Lateness comes over this many times itself: meanwhile a joint is 1/(1 + 1.5/2.5) = 0.6 times as fast, at the least.
const COMES: f64 = 2.5;
/// It goes over this many times itself: a joint is 1/(1 − 1.5/4) = 1.6 times as fast, at the most.
const GOES: f64 = 4.0;

/// Delays the keys of a fitted track by `steps` offsets, smoothly from the beginning of the span on and, where the clip goes on after
/// it, back before its end; says whether the span is too short for that.
fn late(track: &mut Track, place: &FitPlace, offset_s: &Parameter, steps: usize) -> bool {
    let asked = |t: f64| offset_s.at(&Instant { time_s: t, repetition: 0, pose: 0 }) * steps as f64;
    let most = track.elements.iter().map(|e| asked(e.arrives_s())).fold(0.0, f64::max);
    if most == 0.0 {
        return false;
    }
    let (comes_s, goes_s) = (COMES * most, GOES * most);
    let goes_on = place.to_s < place.end_s;
    let shifted = |t: f64| {
        let after = if goes_on { smoothstep((place.to_s - t) / goes_s) } else { 1.0 };
        t + asked(t) * smoothstep((t - place.from_s) / comes_s) * after
    };
    let mut before = f64::NEG_INFINITY;
    for e in &mut track.elements {
        // keys keep their order, however the offset changes over time
        let start = shifted(e.start_s).max(before);
        let end = shifted(e.arrives_s()).max(start);
        (e.start_s, e.duration_s) = (start, lasting(start, end));
        before = end;
    }
    comes_s + if goes_on { goes_s } else { 0.0 } > place.to_s - place.from_s
}
