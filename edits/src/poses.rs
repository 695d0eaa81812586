//! Elements grouped by pose, the values a pose leads to, and limits: shared by edits that think in poses.

use std::collections::BTreeMap;
use std::sync::Arc;

use motion::skeleton::BallLimits;
use motion::{Dof, Element, Label, Limits, Range, Skeleton, Tracks, Value, Vec3};

use crate::Selection;

/// One pose of one repetition: its elements that are selected, and the others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseGroup {
    /// The elements selected, in order of DOFs; at least one.
    pub elements: Vec<(Dof, Element)>,
    /// The elements of the pose that are not selected.
    pub others: Vec<(Dof, Element)>,
}

impl PoseGroup {
    /// When its first selected element starts, s.
    pub fn start_s(&self) -> f64 {
        self.elements.iter().map(|(_, e)| e.start_s).fold(f64::INFINITY, f64::min)
    }

    /// A label of the pose; of its first selected element.
    pub fn label(&self) -> &Label {
        &self.elements[0].1.label
    }

    /// The selected element of a DOF.
    pub fn element(&self, dof: Dof) -> Option<&Element> {
        self.elements.iter().find(|(d, _)| *d == dof).map(|(_, e)| e)
    }

    /// The pose this group leads to: all end values of the pose, selected or not, over the state the other
    /// DOFs have when its last element arrives. Length `nq`.
    pub fn goal(&self, tracks: &Tracks) -> Vec<f64> {
        let all = || self.elements.iter().chain(&self.others);
        let arrives = all().map(|(_, e)| e.arrives_s()).fold(f64::NEG_INFINITY, f64::max);
        let mut q = vec![0.0; tracks.skeleton.nq()];
        tracks.pose_at(arrives, &mut q);
        for (dof, e) in all() {
            dof.write(&tracks.skeleton, &mut q, &e.end);
        }
        q
    }
}

/// The selected elements by pose, in order of time.
pub fn groups(tracks: &Tracks, selection: &Selection) -> Vec<PoseGroup> {
    type Key = (Arc<str>, usize, Option<usize>, usize);
    let mut by_pose: BTreeMap<Key, PoseGroup> = BTreeMap::new();
    for (dof, e) in tracks.elements() {
        let l = &e.label;
        let group = by_pose.entry((l.action.clone(), l.cycle, l.repetition, l.pose)).or_default();
        let list = if selection.contains(l) { &mut group.elements } else { &mut group.others };
        list.push((dof, e.clone()));
    }
    let mut groups: Vec<PoseGroup> = by_pose.into_values().filter(|g| !g.elements.is_empty()).collect();
    groups.sort_by(|a, b| a.start_s().total_cmp(&b.start_s()));
    groups
}

/// The selected elements, in order of tracks.
pub fn selected<'a>(tracks: &'a Tracks, selection: &'a Selection) -> impl Iterator<Item = &'a Element> {
    tracks.elements().map(|(_, e)| e).filter(|e| selection.contains(&e.label))
}

/// Keeps a changed value within the limits of its joint, but never demands more than the value had
/// before: an edit may not push past a limit, and one that changes nothing may not pull either.
///
/// Returns the value, untouched to the bit where it is allowed, and whether it was cut.
pub fn within_limits(skeleton: &Skeleton, dof: Dof, before: &Value, after: &Value) -> (Value, bool) {
    let wider = |r: &Range, x: f64| Range::new(r.lo.min(x), r.hi.max(x));
    match (&skeleton.links()[dof.link()].limits, dof, before, after) {
        (Some(Limits::Axis(range)), Dof::Axis(_), Value::Scalar(b), Value::Scalar(a)) => {
            let range = wider(range, *b);
            if range.contains(*a) { (*after, false) } else { (Value::Scalar(range.clamp(*a)), true) }
        }
        (Some(Limits::Ball(limits)), Dof::Rotation(_), Value::Rotation(b), Value::Rotation(a)) => {
            let at: Vec3 = limits.coords(b);
            let ranges = std::array::from_fn(|i| wider(&limits.ranges[i], at[i]));
            let clamped = BallLimits { axes: limits.axes, ranges }.clamp(a);
            if clamped == *a { (*after, false) } else { (Value::Rotation(clamped), true) }
        }
        _ => (*after, false),
    }
}
