//! Transition-element tracks: the editable form of a motion (NF03 §4.1).
//!
//! In: elements, one time-ordered track per degree of freedom, and the pose before them. Out: the pose
//! at any time, exactly, and a sampled [`Clip`].
//!
//! An element runs its DOF from *whatever the state is when it becomes active* to its end value, holds
//! it there, and leaves it there until the next element. A later element therefore supersedes one that
//! has not finished. Kinematic evaluation finds start values through the chain of superseded elements,
//! with no stepping, so it is exact at any time; a dynamic controller instead asks
//! [`Track::active`] and [`Element::progress`] and supplies the simulated state as the start.
//!
//! Units: seconds, radians, metres; tension is dimensionless, 1 = relaxed and natural.
//!
//! NF03: Neff, Fiume. Aesthetic edits for character animation. SCA 2003.

use std::fmt;
use std::sync::Arc;

use crate::curve::Curve;
use crate::dof::{Dof, Value};
use crate::{Clip, Skeleton, Timing};

/// Where an element comes from: its place in the script.
///
/// Printed as `wave_0_1_23`: action, cycle, pose, index of the DOF in [`Dof::all`]; a cycle that is
/// repeated appends the repetition, `wave_0_1_23_2`. All count from 0.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Label {
    /// Name of the action, or of a directly inserted element.
    pub action: Arc<str>,
    /// Cycle of the action.
    pub cycle: usize,
    /// Repetition of the cycle; `None` if the cycle runs only once.
    pub repetition: Option<usize>,
    /// Pose of the cycle.
    pub pose: usize,
    /// Index of the DOF in [`Dof::all`].
    pub dof: usize,
}

impl Label {
    /// The label with the DOF's name in place of its index: `wave_0_1_elbow_r_2`.
    pub fn named(&self, skeleton: &Skeleton) -> String {
        match Dof::all(skeleton).get(self.dof) {
            Some(dof) => self.with_dof(&dof.name(skeleton)),
            None => self.to_string(),
        }
    }

    /// Whether two labels belong to one pose of one repetition.
    pub fn same_pose(&self, other: &Label) -> bool {
        self.action == other.action
            && (self.cycle, self.repetition, self.pose) == (other.cycle, other.repetition, other.pose)
    }

    /// Number of the repetition, 0 for a cycle that runs once.
    pub fn round(&self) -> usize {
        self.repetition.unwrap_or(0)
    }

    /// The label with this text in place of the DOF's index.
    pub fn with_dof(&self, dof: &str) -> String {
        let tail = self.repetition.map(|r| format!("_{r}")).unwrap_or_default();
        format!("{}_{}_{}_{dof}{tail}", self.action, self.cycle, self.pose)
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.with_dof(&self.dof.to_string()))
    }
}

/// One transition of one DOF.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Its place in the script.
    pub label: Label,
    /// When it becomes active, s.
    pub start_s: f64,
    /// How long the transition takes, s; 0 jumps.
    pub duration_s: f64,
    /// How long the end value is held, s.
    pub hold_s: f64,
    /// The value it ends at.
    pub end: Value,
    /// Shape of the transition.
    pub curve: Curve,
    /// Tension, dimensionless; 1 is relaxed and natural.
    pub tension: f64,
    /// What its muscles know of the motion.
    pub timing: Timing,
}

impl Element {
    /// When the transition is complete, s.
    pub fn arrives_s(&self) -> f64 {
        self.start_s + self.duration_s
    }

    /// When the hold ends, s.
    pub fn ends_s(&self) -> f64 {
        self.start_s + self.duration_s + self.hold_s
    }

    /// Fraction of the duration gone at `t_s`, in [0, 1].
    pub fn fraction(&self, t_s: f64) -> f64 {
        if t_s < self.start_s {
            0.0
        } else if t_s >= self.arrives_s() {
            // also for a duration of zero
            1.0
        } else {
            ((t_s - self.start_s) / self.duration_s).clamp(0.0, 1.0)
        }
    }

    /// Fraction of the way at `t_s`: 0 until the start, 1 from the arrival on; an overshooting curve
    /// leaves [0, 1] in between.
    pub fn progress(&self, t_s: f64) -> f64 {
        self.curve.at(self.fraction(t_s))
    }

    /// Rate of [`Element::progress`], 1/s; zero before the start and from the arrival on.
    pub fn progress_rate(&self, t_s: f64) -> f64 {
        if t_s < self.start_s || t_s >= self.arrives_s() {
            return 0.0;
        }
        self.curve.slope(self.fraction(t_s)) / self.duration_s
    }

    /// Value at `t_s` if the DOF was at `start` when the element became active.
    pub fn value_at(&self, t_s: f64, start: &Value) -> Value {
        Value::between(start, &self.end, self.progress(t_s))
    }
}

/// The time-ordered elements of one DOF.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// What it moves.
    pub dof: Dof,
    /// By start time; at equal times the later in the list rules.
    pub elements: Vec<Element>,
}

impl Track {
    /// Adds an element after those that start no later.
    pub fn insert(&mut self, element: Element) {
        let at = self.elements.partition_point(|e| e.start_s <= element.start_s);
        self.elements.insert(at, element);
    }

    /// Restores time order after start times were changed; elements that start together keep theirs.
    pub fn sort(&mut self) {
        self.elements.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    }

    /// Index of the element that governs the DOF at `t_s`: the last that has become active. `None`
    /// before the first.
    pub fn active(&self, t_s: f64) -> Option<usize> {
        self.elements.partition_point(|e| e.start_s <= t_s).checked_sub(1)
    }

    /// State of the DOF when element `index` becomes active, kinematically.
    pub fn start_value(&self, index: usize, base: &Value) -> Value {
        let e = &self.elements;
        // go back to the last element that had ended when the next one began: its value there is its end value
        let mut from = index;
        let mut value = *base;
        while from > 0 {
            let before = &e[from - 1];
            if before.arrives_s() <= e[from].start_s {
                value = before.end;
                break;
            }
            from -= 1;
        }
        // then forward through the elements that were cut off, each from where the one before it was
        for i in from..index {
            value = e[i].value_at(e[i + 1].start_s, &value);
        }
        value
    }

    /// Value at `t_s`; `base` is the state before any element.
    pub fn value_at(&self, t_s: f64, base: &Value) -> Value {
        match self.active(t_s) {
            None => *base,
            Some(i) if self.elements[i].arrives_s() <= t_s => self.elements[i].end,
            Some(i) => self.elements[i].value_at(t_s, &self.start_value(i, base)),
        }
    }
}

/// Two elements of one DOF of which the later took over before the earlier was done.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlap {
    /// The DOF both move.
    pub dof: Dof,
    /// The element cut short.
    pub earlier: Label,
    /// The element that took over.
    pub later: Label,
    /// When it took over, s.
    pub at_s: f64,
    /// Transition time the earlier one lost, s; 0 if it only lost hold.
    pub cut_s: f64,
}

/// All tracks of a motion. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracks {
    /// Whose motion it is.
    pub skeleton: Arc<Skeleton>,
    /// Pose before any element, length `nq`.
    pub base: Vec<f64>,
    /// Tension of each link's joint before any element; 1 is relaxed and natural.
    pub base_tension: Vec<f64>,
    /// In the order of [`Dof::all`], at most one for each DOF.
    pub tracks: Vec<Track>,
    /// Length of the motion, s.
    pub duration_s: f64,
}

impl Tracks {
    /// Tracks without any element: the base pose, at natural tension.
    ///
    /// # Panics
    /// If `base` does not have length `nq`.
    pub fn new(skeleton: Arc<Skeleton>, base: Vec<f64>) -> Self {
        assert_eq!(base.len(), skeleton.nq(), "length of the base pose");
        let base_tension = vec![1.0; skeleton.links().len()];
        Self { skeleton, base, base_tension, tracks: Vec::new(), duration_s: 0.0 }
    }

    /// The track of a DOF, if it has one.
    pub fn track(&self, dof: Dof) -> Option<&Track> {
        self.tracks.iter().find(|t| t.dof == dof)
    }

    /// The track of a DOF, made if it is missing; `None` if the skeleton has no such DOF.
    pub fn track_mut(&mut self, dof: Dof) -> Option<&mut Track> {
        if let Some(i) = self.tracks.iter().position(|t| t.dof == dof) {
            return self.tracks.get_mut(i);
        }
        let index = dof.index(&self.skeleton)?;
        let all = Dof::all(&self.skeleton);
        let at = self.tracks.partition_point(|t| all.iter().position(|d| *d == t.dof) < Some(index));
        self.tracks.insert(at, Track { dof, elements: Vec::new() });
        self.tracks.get_mut(at)
    }

    /// All elements, track by track, in time order.
    pub fn elements(&self) -> impl Iterator<Item = (Dof, &Element)> {
        self.tracks.iter().flat_map(|t| t.elements.iter().map(|e| (t.dof, e)))
    }

    /// All elements, to be changed. Call [`Track::sort`] and [`Tracks::extend_duration`] after changing
    /// times.
    pub fn elements_mut(&mut self) -> impl Iterator<Item = (Dof, &mut Element)> {
        self.tracks.iter_mut().flat_map(|t| {
            let dof = t.dof;
            t.elements.iter_mut().map(move |e| (dof, e))
        })
    }

    /// The element with this label.
    pub fn element(&self, label: &Label) -> Option<&Element> {
        self.elements().find(|(_, e)| e.label == *label).map(|(_, e)| e)
    }

    /// Lengthens the motion, if need be, to where the last hold ends.
    pub fn extend_duration(&mut self) {
        self.duration_s = self.elements().map(|(_, e)| e.ends_s()).fold(self.duration_s, f64::max);
    }

    /// Value of a DOF at `t_s`.
    pub fn value_at(&self, dof: Dof, t_s: f64) -> Value {
        let base = dof.read(&self.skeleton, &self.base);
        self.track(dof).map_or(base, |t| t.value_at(t_s, &base))
    }

    /// Writes the pose at `t_s` into `q` (length `nq`). Exact at any time; before the first element it is
    /// the base pose.
    pub fn pose_at(&self, t_s: f64, q: &mut [f64]) {
        q.copy_from_slice(&self.base);
        for track in &self.tracks {
            let base = track.dof.read(&self.skeleton, &self.base);
            track.dof.write(&self.skeleton, q, &track.value_at(t_s, &base));
        }
    }

    /// Samples the motion from 0 to at least its end (the last frame is at or after it).
    ///
    /// # Panics
    /// If the rate is not positive and finite.
    pub fn sample(&self, rate_hz: f64) -> Clip {
        assert!(rate_hz > 0.0 && rate_hz.is_finite(), "rate {rate_hz} Hz");
        // 1e-9 of a frame: an end that is a whole number of frames in text must be one here
        let frames = (self.duration_s * rate_hz - 1e-9).ceil().max(0.0) as usize + 1;
        let n = self.skeleton.nq();
        let mut q = vec![0.0; frames * n];
        for (i, pose) in q.chunks_exact_mut(n).enumerate() {
            self.pose_at(i as f64 / rate_hz, pose);
        }
        Clip::new(self.skeleton.clone(), rate_hz, q)
    }

    /// Tension of the joint of `link` at `t_s`: that of the element that governs it, else the base
    /// tension.
    ///
    /// A free link has several tracks; its rotation decides.
    pub fn tension_at(&self, link: usize, t_s: f64) -> f64 {
        Dof::of_link(&self.skeleton, link)
            .and_then(|dof| self.track(dof))
            .and_then(|t| t.active(t_s).map(|i| t.elements[i].tension))
            .unwrap_or(self.base_tension[link])
    }

    /// Elements that were superseded before their hold was over, in order of tracks and time.
    pub fn overlaps(&self) -> Vec<Overlap> {
        let mut found = Vec::new();
        for track in &self.tracks {
            for pair in track.elements.windows(2) {
                // below a nanosecond it is rounding of serial times
                if pair[0].ends_s() > pair[1].start_s + 1e-9 {
                    found.push(Overlap {
                        dof: track.dof,
                        earlier: pair[0].label.clone(),
                        later: pair[1].label.clone(),
                        at_s: pair[1].start_s,
                        cut_s: (pair[0].arrives_s() - pair[1].start_s).max(0.0),
                    });
                }
            }
        }
        found
    }
}
