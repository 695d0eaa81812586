//! Glitches of a capture: joints that accelerate as no muscle could make them, and how the gap is filled.
//!
//! In: a [`Clip`]. Out: [`Glitch`]es, and the clip with the frames between them interpolated.
//!
//! The fastest joint of people is the shoulder of a pitcher, which turns inward at some 7000°/s after about 30 ms:
//! 4000 rad/s² \[DFA93\]. A joint whose rate changes within one frame by more than 40 rad/s, or beyond 5000 rad/s² where
//! frames are shorter than that takes, has not moved so: a marker was lost or swapped, or a solver flipped. The same for
//! the place of a free root: 8 m/s or 1000 m/s² (a hundred times its weight). Changes that are no larger than the
//! rounding of a step at high rates (3°, 2 cm) do not count.
//!
//! 1. *Jumps*: steps from frame to frame that stand out by more than half of that from the steps around.
//! 2. *Glitches*: a jump away and a jump back within 0.25 s: the frames between them are wrong. A jump that does not
//!    come back is a glitch without frames to repair: a cut, or an inserted pose.
//!
//! *Repair*: the frames of a glitch follow the cubic between the good frames around it, with the rates that these have.
//!
//! \[DFA93\] Dillman, Fleisig, Andrews. Biomechanics of pitching with emphasis upon shoulder kinematics. J. Orthop.
//! Sports Phys. Ther. 18, 402–408, 1993.

use std::ops::Range;

use crate::rotation::{Vec3, exp, log};
use crate::{Clip, Joint, Skeleton};

/// Bounds of one kind of motion: rad or m.
struct Bounds {
    /// Most that a rate changes within a frame, 1/s.
    rate: f64,
    /// Most acceleration, 1/s².
    acceleration: f64,
    /// Second differences below it are rounding.
    rounding: f64,
}

const TURNS: Bounds = Bounds { rate: 40.0, acceleration: 5000.0, rounding: 0.05 };
const PLACES: Bounds = Bounds { rate: 8.0, acceleration: 1000.0, rounding: 0.02 };
/// Longest time between a jump away and the jump back, s.
const LONGEST_S: f64 = 0.25;

impl Bounds {
    /// Most that the rate may change from frame to frame, 1/s.
    fn most(&self, rate_hz: f64) -> f64 {
        self.rate.min(self.acceleration / rate_hz).max(self.rounding * rate_hz)
    }
}

/// What of a joint jumps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Its rotation.
    Turn,
    /// The place of a free joint.
    Place,
}

/// A joint that jumps. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Glitch {
    /// The link whose joint it is.
    pub link: usize,
    /// What of it jumps.
    pub part: Part,
    /// Frames that are wrong; empty at the frame after a jump that does not come back.
    pub frames: Range<usize>,
    /// Largest acceleration there, rad/s² or m/s².
    pub acceleration: f64,
}

/// All glitches of a clip, link by link, in order of frames.
pub fn glitches(clip: &Clip) -> Vec<Glitch> {
    let mut out = Vec::new();
    for (link, l) in clip.skeleton.links().iter().enumerate() {
        if matches!(l.joint, Joint::Free | Joint::Spherical | Joint::Revolute(_)) {
            of_part(clip, link, Part::Turn, &mut out);
        }
        if l.joint == Joint::Free {
            of_part(clip, link, Part::Place, &mut out);
        }
    }
    out
}

/// The clip with its glitches repaired, and all that were found. Where glitches follow one another closely, one hides
/// the next: it is looked again, at most a few times.
pub fn mended(clip: &Clip) -> (Clip, Vec<Glitch>) {
    let mut all = glitches(clip);
    let mut found = all.clone();
    let mut out = clip.clone();
    for _ in 0..ROUNDS {
        if found.iter().all(|g| g.frames.is_empty()) {
            break;
        }
        out = repaired(&out, &found);
        found = glitches(&out);
        all.extend(found.iter().filter(|g| !g.frames.is_empty()).cloned());
    }
    (out, all)
}

/// Rounds of repair.
const ROUNDS: usize = 4;

/// The clip with the frames of its glitches interpolated.
pub fn repaired(clip: &Clip, glitches: &[Glitch]) -> Clip {
    let mut out = clip.clone();
    for glitch in glitches.iter().filter(|g| !g.frames.is_empty()) {
        fill(clip, &mut out, glitch);
    }
    out
}

/// From one frame to another, rad or m.
fn way(skeleton: &Skeleton, link: usize, part: Part, from: &[f64], to: &[f64]) -> Vec3 {
    match (part, skeleton.links()[link].joint) {
        (Part::Place, _) => skeleton.position(to, link) - skeleton.position(from, link),
        (Part::Turn, Joint::Revolute(axis)) => axis * (to[skeleton.q_at(link)] - from[skeleton.q_at(link)]),
        (Part::Turn, _) => log(&(skeleton.rotation(to, link) * skeleton.rotation(from, link).inverse())),
    }
}

fn of_part(clip: &Clip, link: usize, part: Part, out: &mut Vec<Glitch>) {
    let (frames, rate) = (clip.frames(), clip.rate_hz);
    if frames < 3 {
        return;
    }
    let between = |a: usize, b: usize| way(&clip.skeleton, link, part, clip.pose(a), clip.pose(b));
    let bounds = if part == Part::Turn { TURNS } else { PLACES };
    let most = bounds.most(rate);
    let steps: Vec<Vec3> = (1..frames).map(|k| between(k - 1, k) * rate).collect();
    // the change of rate at frame k + 1
    let changes: Vec<f64> = steps.windows(2).map(|w| (w[1] - w[0]).norm()).collect();
    let mut jumps: Vec<usize> = Vec::new(); // steps, from frame k to k + 1
    let mut k = 0;
    while k < changes.len() {
        if changes[k] <= most {
            k += 1;
            continue;
        }
        let first = k;
        while k < changes.len() && (changes[k] > most || changes.get(k + 1).is_some_and(|c| *c > most)) {
            k += 1;
        }
        // steps first ..= k took part; those beside them are as the motion goes
        let beside = [first.checked_sub(1), Some(k + 1)].into_iter().flatten().filter_map(|i| steps.get(i));
        let (mut usual, mut count) = (Vec3::zeros(), 0.0);
        beside.for_each(|step| {
            usual += step;
            count += 1.0;
        });
        let usual = usual / f64::max(count, 1.0);
        jumps.extend((first..=k).filter(|&i| (steps[i] - usual).norm() > 0.5 * most));
    }
    let longest = (LONGEST_S * rate).max(1.0) as usize;
    let acceleration = |range: Range<usize>| {
        // frame f has the change f − 1
        range.filter_map(|f| changes.get(f.checked_sub(1)?)).fold(0.0f64, |m, c| m.max(*c)) * rate
    };
    let mut i = 0;
    while i < jumps.len() {
        let from = jumps[i];
        let back = (i + 1..jumps.len()).take_while(|&j| jumps[j] - from <= longest).find(|&j| {
            between(from, jumps[j] + 1).norm() * rate <= 0.5 * most * (jumps[j] + 1 - from) as f64
        });
        let (frames, next) = match back {
            Some(j) => (from + 1..jumps[j] + 1, j + 1),
            None => (from + 1..from + 1, i + 1),
        };
        let around = frames.start.saturating_sub(1)..frames.end + 1;
        out.push(Glitch { link, part, acceleration: acceleration(around), frames });
        i = next;
    }
}

/// Writes the cubic over the frames of a glitch.
fn fill(clip: &Clip, out: &mut Clip, glitch: &Glitch) {
    let Glitch { link, part, ref frames, .. } = *glitch;
    let (a, b) = (frames.start - 1, frames.end);
    let skeleton = clip.skeleton.clone();
    let span = (b - a) as f64;
    let between = |i: usize, j: usize| way(&skeleton, link, part, clip.pose(i), clip.pose(j));
    let whole = between(a, b);
    // rates at the good frames, per span; at most the way itself suggests, where the neighbours are wrong too
    let rate = |step: Option<Vec3>| {
        let rate = step.unwrap_or(whole / span) * span;
        if rate.norm() <= 3.0 * whole.norm() { rate } else { whole }
    };
    let before = rate(a.checked_sub(1).map(|k| between(k, a)));
    let after = rate((b + 1 < clip.frames()).then(|| between(b, b + 1)));
    for frame in frames.clone() {
        let s = (frame - a) as f64 / span;
        let (s2, s3) = (s * s, s * s * s);
        let at = whole * (3.0 * s2 - 2.0 * s3) + before * (s3 - 2.0 * s2 + s) + after * (s3 - s2);
        let from = clip.pose(a);
        let q = out.pose_mut(frame);
        match (part, skeleton.links()[link].joint) {
            (Part::Place, _) => {
                let place = skeleton.position(from, link) + at;
                skeleton.set_position(q, link, &place);
            }
            (Part::Turn, Joint::Revolute(axis)) => {
                q[skeleton.q_at(link)] = from[skeleton.q_at(link)] + at.dot(&axis);
            }
            (Part::Turn, _) => {
                let turn = exp(&at) * skeleton.rotation(from, link);
                skeleton.set_rotation(q, link, &turn);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::Link;

    /// A root, an arm and an elbow that swing as people do, at a rate.
    fn swinging(rate_hz: f64) -> Clip {
        let skeleton = Skeleton::new(vec![
            Link::new("root", None, Vec3::zeros(), Joint::Free),
            Link::new("arm", Some(0), Vec3::x(), Joint::Spherical),
            Link::new("elbow", Some(1), Vec3::x(), Joint::Revolute(Vec3::y())),
        ])
        .unwrap();
        let frames = (2.0 * rate_hz) as usize;
        let mut q = Vec::new();
        for k in 0..frames {
            let t = k as f64 / rate_hz;
            let mut pose = skeleton.zero_pose();
            skeleton.set_position(&mut pose, 0, &Vec3::new(t, (3.0 * t).sin(), 0.0));
            skeleton.set_rotation(&mut pose, 0, &exp(&(Vec3::y() * (2.0 * t))));
            // 15 rad/s and 150 rad/s²: a fast throw
            skeleton.set_rotation(&mut pose, 1, &exp(&(Vec3::new(0.3, 1.0, 0.5) * (1.3 * (10.0 * t).sin()))));
            pose[skeleton.q_at(2)] = 1.0 + (9.0 * t).sin();
            q.extend(pose);
        }
        Clip::new(Arc::new(skeleton), rate_hz, q)
    }

    fn turned(clip: &mut Clip, link: usize, frames: Range<usize>, by: Vec3) {
        let s = clip.skeleton.clone();
        for frame in frames {
            let pose = clip.pose_mut(frame);
            match s.links()[link].joint {
                Joint::Revolute(axis) => pose[s.q_at(link)] += by.dot(&axis),
                _ => {
                    let turn = exp(&by) * s.rotation(pose, link);
                    s.set_rotation(pose, link, &turn);
                }
            }
        }
    }

    /// Fast motion at any rate has no glitch; repairing nothing changes nothing.
    #[test]
    fn fast_motion_is_no_glitch() {
        for rate in [24.0, 30.0, 60.0, 120.0, 240.0, 1000.0] {
            let clip = swinging(rate);
            assert_eq!(glitches(&clip), [], "{rate} Hz");
            assert_eq!(repaired(&clip, &[]), clip);
        }
    }

    /// An arm that turns 94° for one frame, a flip of half a turn for some: joint and frames are named, and the repair
    /// is near the motion that was there, with nothing left to find.
    #[test]
    fn a_turn_away_and_back_is_named_and_repaired() {
        for rate in [30.0, 60.0, 120.0] {
            for (link, frames, degrees) in
                [(1, 20..21, 94.0), (2, 31..32, 94.0), (1, 25..28, 180.0), (0, 9..11, 170.0)]
            {
                let good = swinging(rate);
                let mut bad = good.clone();
                turned(&mut bad, link, frames.clone(), Vec3::y() * f64::to_radians(degrees));
                let found = glitches(&bad);
                assert_eq!(found.len(), 1, "{rate} {link} {degrees}: {found:?}");
                assert_eq!((found[0].link, &found[0].frames), (link, &frames));
                assert!(found[0].acceleration > 1000.0, "{found:?}");
                let mended = repaired(&bad, &found);
                assert_eq!(glitches(&mended), []);
                assert_eq!(super::mended(&bad), (mended.clone(), found));
                for frame in frames {
                    let off =
                        way(&good.skeleton, link, Part::Turn, mended.pose(frame), good.pose(frame)).norm();
                    assert!(off < 0.35 * (30.0 / rate), "{rate} {link} {frame}: {off} rad"); // 0.29 seen at 30 Hz
                }
            }
        }
    }

    /// From both sides of the bound: a spike of one frame changes the rate by twice its height.
    #[test]
    fn a_spike_counts_from_its_bound_on() {
        for (degrees, found) in [(9.0, 0), (10.0, 1)] {
            let mut clip = swinging(120.0);
            let still = clip.pose(0).to_vec();
            (0..clip.frames()).for_each(|f| clip.pose_mut(f).copy_from_slice(&still));
            turned(&mut clip, 1, 50..51, Vec3::z() * f64::to_radians(degrees)); // 40 rad/s at 9.55°
            assert_eq!(glitches(&clip).len(), found, "{degrees}°");
        }
    }

    /// A root that is elsewhere for two frames; and a cut, which is named and left.
    #[test]
    fn places_jump_too_and_cuts_are_left() {
        let mut clip = swinging(120.0);
        let s = clip.skeleton.clone();
        for frame in 40..42 {
            let at = s.position(clip.pose(frame), 0) + Vec3::new(0.0, 0.3, 0.0);
            s.set_position(clip.pose_mut(frame), 0, &at);
        }
        let frames = clip.frames();
        turned(&mut clip, 1, 100..frames, Vec3::x() * 2.0);
        let found = glitches(&clip);
        let kinds: Vec<_> = found.iter().map(|g| (g.link, g.part, g.frames.clone())).collect();
        assert_eq!(kinds, [(0, Part::Place, 40..42), (1, Part::Turn, 100..100)]);
        let mended = repaired(&clip, &found);
        let left = glitches(&mended);
        assert_eq!(left.len(), 1, "{left:?}");
        assert_eq!(mended.pose(100), clip.pose(100));
    }
}
