//! Where a track edit acts on the elements that a clip was fitted by.

use motion::{Kinematics, Skeleton, Track, Tracks, Value};

use crate::Selection;

/// Samples of a fitted track per second, where a mean over time is taken.
const MEAN_HZ: f64 = 120.0;

/// Where an edit acts on a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FitPlace {
    /// Elements that arrive within the span, of the DOFs that may be changed.
    pub selection: Selection,
    /// First time, s.
    pub from_s: f64,
    /// Last time, s.
    pub to_s: f64,
    /// Length of the clip, s.
    pub end_s: f64,
}

impl FitPlace {
    /// Mean over the span of a number that the pose says.
    pub fn mean_of(&self, tracks: &Tracks, number: impl Fn(&Kinematics) -> f64) -> f64 {
        let n = ((self.to_s - self.from_s) * MEAN_HZ).ceil().max(1.0);
        let mut q = vec![0.0; tracks.skeleton.nq()];
        let of = |i: usize| {
            tracks.pose_at(self.from_s + (self.to_s - self.from_s) * i as f64 / n, &mut q);
            number(&Kinematics::new(&tracks.skeleton, &q))
        };
        (0..=n as usize).map(of).sum::<f64>() / (n + 1.0)
    }

    /// Mean of a track over the span; `None` where it has nothing selected.
    pub fn mean(&self, skeleton: &Skeleton, track: &Track) -> Option<Value> {
        if !track.elements.iter().any(|e| self.selection.contains(&e.label)) {
            return None;
        }
        let n = ((self.to_s - self.from_s) * MEAN_HZ).ceil().max(1.0);
        let base = track.dof.read(skeleton, &skeleton.zero_pose()); // never read: an element places the DOF at 0 s
        let at = |i: usize| track.value_at(self.from_s + (self.to_s - self.from_s) * i as f64 / n, &base);
        Value::mean(&(0..=n as usize).map(at).collect::<Vec<_>>())
    }
}
