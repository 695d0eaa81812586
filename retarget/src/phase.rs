//! When and where contact points rest: the values that all of contact adjustment works with.

use motion::Vec3;

/// A time in which a point of the character stays where it is on the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    /// The site's name.
    pub point: String,
    /// First time of contact, s.
    pub from_s: f64,
    /// Last time of contact, s.
    pub to_s: f64,
}

/// World positions of a point, one per frame, m.
pub type Path = Vec<Vec3>;

/// Frames of a phase, ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhaseFrames {
    /// First frame in contact.
    pub first: usize,
    /// Last frame in contact.
    pub last: usize,
}

/// Whether a frame lies in one of a point's phases.
pub fn rests(spans: &[PhaseFrames], frame: usize) -> bool {
    spans.iter().any(|s| (s.first..=s.last).contains(&frame))
}

/// Runs of frames that are `of` a kind, in order.
pub fn runs(frames: std::ops::Range<usize>, of: impl Fn(usize) -> bool) -> Vec<PhaseFrames> {
    motion::runs(frames, of)
        .into_iter()
        .map(|run| PhaseFrames { first: run.start, last: run.end - 1 })
        .collect()
}
