//! Keys of a script that cannot act, and why.
//!
//! A key is an element of a track. Its joint may be set by something else: the legs of planted feet follow the pelvis by
//! IK; a root height above what planted legs reach is lowered; an element that starts together with a later one never
//! rules, unless it has no duration: then it says where the later one starts. Such keys are named, so that nobody looks for their effect.
//!
//! In: the tracks of a script, the limbs planted, how far the root was lowered. Out: [`Ignored`], in order of the script.
//! Units: m, s.

use std::fmt;

use motion::{Dof, Element, Label, Plant, Tracks};

/// A root lowered by less counts as where it was asked, m.
const LOWERED_M: f64 = 0.01;

/// Keys that do not act. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Ignored {
    /// Names of the joints and coordinates.
    pub keys: Vec<String>,
    /// The poses that set them, as labels: `kick_0_1`. A pose of repeated cycles counts once.
    pub poses: Vec<String>,
    /// Why they do not act.
    pub why: Why,
}

/// Why a key does not act.
#[derive(Clone, Debug, PartialEq)]
pub enum Why {
    /// Its joint belongs to a planted limb, which IK solves.
    Planted {
        /// The limb.
        limb: String,
    },
    /// The root is lower than asked: planted limbs are straight.
    Lowered {
        /// By this much where it is worst, m.
        by_m: f64,
    },
    /// A later element of the same joint starts at the same time.
    Superseded {
        /// Its pose.
        by: String,
    },
}

impl fmt::Display for Ignored {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quoted: Vec<String> = self.keys.iter().map(|key| format!("`{key}`")).collect();
        let of = if self.poses.len() == 1 { "pose" } else { "poses" };
        write!(f, "{} of {of} {} ", quoted.join(", "), self.poses.join(", "))?;
        let verb = if self.keys.len() == 1 { "is" } else { "are" };
        match &self.why {
            Why::Planted { limb } => write!(f, "{verb} ignored: {limb} is planted (see `planted`)"),
            Why::Lowered { by_m } => {
                write!(f, "{verb} not reached by {:.0} mm: planted legs are straight", 1e3 * by_m)
            }
            Why::Superseded { by } => write!(f, "{verb} ignored: {by} starts at the same time"),
        }
    }
}

/// The pose of a label, without repetition and joint: `kick_0_1`.
fn pose_of(label: &Label) -> String {
    format!("{}_{}_{}", label.action, label.cycle, label.pose)
}

/// All keys of `tracks` that do not act. `lowered_m`: how far the root of the motion asked for is below what the tracks
/// ask, m, in the span of time that a key rules, s.
pub(crate) fn ignored(
    tracks: &Tracks,
    plants: &[Plant],
    lowered_m: impl Fn(f64, f64) -> f64,
) -> Vec<Ignored> {
    let mut all = Vec::new();
    for track in &tracks.tracks {
        let limb = plants.iter().map(|p| &p.limb).find(|l| {
            let (Dof::Axis(link) | Dof::Rotation(link)) = track.dof else { return false };
            l.links().contains(&link)
        });
        for (i, e) in track.elements.iter().enumerate() {
            let next = track.elements.get(i + 1);
            if let Some(why) = why(track.dof, e, next, limb.map(|l| &l.name), &lowered_m) {
                let (key, pose) = (track.dof.name(&tracks.skeleton), pose_of(&e.label));
                all.push((e.start_s, key, pose, why));
            }
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    grouped(all)
}

/// Why one element does not act; `None` if it does.
fn why(
    dof: Dof,
    e: &Element,
    next: Option<&Element>,
    planted: Option<&String>,
    lowered_m: impl Fn(f64, f64) -> f64,
) -> Option<Why> {
    if let Some(limb) = planted {
        return Some(Why::Planted { limb: limb.clone() });
    }
    let until = next.map_or(e.ends_s(), |n| n.start_s.min(e.ends_s()));
    // one of no duration places the joint for the one that starts with it
    if next.is_some_and(|n| n.start_s <= e.start_s) && e.duration_s > 0.0 {
        return next.map(|n| Why::Superseded { by: pose_of(&n.label) });
    }
    if dof != Dof::Coordinate(0, 1) {
        return None;
    }
    let by_m = lowered_m(e.arrives_s().min(until), until);
    (by_m > LOWERED_M).then_some(Why::Lowered { by_m })
}

/// Joins what has the same reason: first the keys of one pose, then poses of the same keys.
fn grouped(all: Vec<(f64, String, String, Why)>) -> Vec<Ignored> {
    let mut by_pose: Vec<Ignored> = Vec::new();
    for (_, key, pose, why) in all {
        let same = |i: &&mut Ignored| i.poses[0] == pose && i.why.is_like(&why);
        match by_pose.iter_mut().find(same) {
            Some(i) => {
                i.why = i.why.worse(&why);
                if !i.keys.contains(&key) {
                    i.keys.push(key);
                }
            }
            None => by_pose.push(Ignored { keys: vec![key], poses: vec![pose], why }),
        }
    }
    let mut out: Vec<Ignored> = Vec::new();
    for one in by_pose {
        match out.iter_mut().find(|i| i.keys == one.keys && i.why.is_like(&one.why)) {
            Some(i) => {
                i.why = i.why.worse(&one.why);
                i.poses.extend(one.poses);
            }
            None => out.push(one),
        }
    }
    out
}

impl Why {
    /// Whether it is the same reason, up to how much.
    fn is_like(&self, other: &Self) -> bool {
        self == other || matches!((self, other), (Self::Lowered { .. }, Self::Lowered { .. }))
    }

    /// The same reason, as much as the larger of both.
    fn worse(&self, other: &Self) -> Self {
        match (self, other) {
            (Self::Lowered { by_m: a }, Self::Lowered { by_m: b }) => Self::Lowered { by_m: a.max(*b) },
            _ => self.clone(),
        }
    }
}
