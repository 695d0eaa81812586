//! Joint offsets that move: position channels below the root.
//!
//! In: a [`Bvh`]. Out: for every joint whether its positions are an offset that stands still, an offset that
//! is held at its mean, or a slide.
//!
//! Many programs write six channels for every joint, and their solvers or their rounding let the offsets tremble.
//! Bones are as long as they are: movements up to 1.2 % of the height (2 cm of a person of 1.70 m) are held at
//! their mean. What moves farther is a *slide*: it is kept in the motion, but no muscle makes it, so a body with one
//! is not performed.
//! Two kinds are slides however little they move: joints between the root and the pelvis, which place the whole
//! body, and joints that have one position channel and no rotation, which can mean nothing else.

use std::fmt;

use super::pose::{Landmarks, of_joint, origin};
use super::{Bvh, BvhJoint, Channel};
use motion::names::Word;
use motion::rotation::Vec3;

/// Most that an offset that is held moves, in parts of the height.
pub(super) const HELD: f64 = 0.012;
/// Positions that vary less than this (m) do not move.
const STILL_M: f64 = 1e-6;

/// What the caller wants of joint offsets that move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OffsetRule {
    /// All are held at their mean.
    Hold,
    /// All are slides.
    Keep,
}

impl Word for OffsetRule {
    const KIND: &'static str = "rule for joint offsets";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Hold, "hold", "held at their mean, however far they move"),
        (Self::Keep, "keep", "kept in the motion; a body with joints that slide is not performed"),
    ];
}

/// A joint whose offset moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// The joint.
    pub joint: String,
    /// Its parent.
    pub parent: String,
    /// Largest distance from its mean, m.
    pub by_m: f64,
}

/// Joints whose offsets move. `Display` prints a line for each kind there is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Offsets {
    /// Held at their mean.
    pub held: Vec<Moved>,
    /// Kept in the motion.
    pub slides: Vec<Moved>,
    /// Position channels that do not move at all.
    pub still: Vec<String>,
}

impl fmt::Display for Offsets {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let mut lines = Vec::new();
        if !self.still.is_empty() {
            let (count, names) = (self.still.len(), names(self.still.iter()));
            lines.push(format!("positions that do not move are taken as offsets: {count} joints ({names})"));
        }
        let most = |moved: &[Moved]| moved.iter().map(|m| m.by_m).fold(0.0, f64::max);
        let of = |moved: &[Moved]| names(moved.iter().map(|m| &m.joint));
        if !self.held.is_empty() {
            lines.push(format!(
                "joint offsets move by up to {}: held at their mean, {} joints ({})",
                millimetres(most(&self.held)),
                self.held.len(),
                of(&self.held)
            ));
        }
        if !self.slides.is_empty() {
            lines.push(format!(
                "joints slide by up to {}, kept in the motion, cannot be performed: {} joints ({}); state that \
                 offsets are held if this is wrong",
                millimetres(most(&self.slides)),
                self.slides.len(),
                of(&self.slides)
            ));
        }
        f.write_str(&lines.join("\n"))
    }
}

/// Two significant digits of millimetres, whole ones from 10 on.
pub fn millimetres(m: f64) -> String {
    let mm = 1000.0 * m;
    let digits = if mm > 0.0 { (1 - mm.log10().floor() as i32).clamp(0, 6) as usize } else { 0 };
    format!("{mm:.digits$} mm")
}

fn names<'a>(all: impl ExactSizeIterator<Item = &'a String>) -> String {
    let more = if all.len() > 3 { ", …" } else { "" };
    format!("{}{more}", all.take(3).map(String::as_str).collect::<Vec<_>>().join(", "))
}

/// How the positions of a joint below the root are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Positions {
    /// There are none.
    None,
    /// An offset, file units.
    Offset(Vec3),
    /// They move.
    Slide,
}

/// How the positions of every joint are taken, the root's left out (`None`); from frame `first` on. `height_m` is the
/// skeleton's, `metres` the unit.
pub(super) fn offsets(
    bvh: &Bvh,
    first: usize,
    metres: f64,
    height_m: f64,
    rule: Option<OffsetRule>,
) -> (Vec<Positions>, Offsets) {
    let above = above_pelvis(bvh);
    let mut report = Offsets::default();
    let take = |(j, joint): (usize, &BvhJoint)| {
        let count = joint.channels.iter().filter(|c| matches!(c, Channel::Position(_))).count();
        let Some(parent) = joint.parent.filter(|_| count > 0) else { return Positions::None };
        let at = |frame: usize| origin(joint, of_joint(joint, bvh.frame(frame)));
        let from = at(first);
        if (first..bvh.frames).all(|f| (at(f) - from).amax() * metres <= STILL_M) {
            report.still.push(joint.name.clone());
            return Positions::Offset(from);
        }
        let frames = (bvh.frames - first) as f64;
        let mean = (first..bvh.frames).map(at).sum::<Vec3>() / frames;
        let by_m = (first..bvh.frames).map(|f| (at(f) - mean).norm()).fold(0.0, f64::max) * metres;
        let moved = Moved { joint: joint.name.clone(), parent: bvh.joints[parent].name.clone(), by_m };
        let only_slides = count == 1 && joint.channels.len() == 1;
        let held = match rule {
            None => by_m <= HELD * height_m && !only_slides,
            Some(OffsetRule::Hold) => true,
            Some(OffsetRule::Keep) => false,
        };
        if held && !above[j] {
            report.held.push(moved);
            Positions::Offset(mean)
        } else {
            // what places the whole body is no slide of a joint
            if !above[j] {
                report.slides.push(moved);
            }
            Positions::Slide
        }
    };
    let positions = bvh.joints.iter().enumerate().map(take).collect();
    (positions, report)
}

/// Joints from the root down to the pelvis, where the ways to both feet part; without feet by name the unbranched
/// beginning of the tree.
fn above_pelvis(bvh: &Bvh) -> Vec<bool> {
    let mut above = vec![false; bvh.joints.len()];
    let way = |mut j: usize| {
        let mut way = vec![j];
        while let Some(p) = bvh.joints[j].parent {
            way.push(p);
            j = p;
        }
        way.reverse();
        way
    };
    match Landmarks::find(bvh).as_ref().map(|m| m.feet.as_slice()) {
        Some([a, b, ..]) => {
            for (a, b) in way(*a).into_iter().zip(way(*b)).take_while(|(a, b)| a == b) {
                above[a.min(b)] = true;
            }
        }
        _ => {
            let mut j = 0;
            loop {
                above[j] = true;
                let mut below = (0..bvh.joints.len()).filter(|&i| bvh.joints[i].parent == Some(j));
                match (below.next(), below.next()) {
                    (Some(only), None) if bvh.joints[only].channels.len() > 3 => j = only,
                    _ => break,
                }
            }
        }
    }
    above
}
