//! What a BVH file does not say: its unit of length.
//!
//! In: a [`Bvh`]. Out: an answer, and on what it rests, so that a person can overrule it.
//!
//! The length from the ankle's floor to the crown *along the bones* (it does not depend on the pose) must be
//! that of a person, 1.25 m to 2.15 m. The units in use differ by more than that range, so at most one of
//! them fits.

use std::fmt;

use motion::rotation::Vec3;

use super::Bvh;
use super::pose::{Landmarks, of_joint, origin, world};

/// Metres per unit: metres, centimetres, millimetres, inches, and the CMU files' unit, (1/0.45) inch.
const UNITS: [f64; 5] = [1.0, 0.01, 0.001, 0.0254, 2.54 / 45.0];
/// Heights of people, m.
const HEIGHTS: std::ops::RangeInclusive<f64> = 1.25..=2.15;
/// The height looked for where none is in the range, m.
const HEIGHT: f64 = 1.7;

/// Where an answer comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chosen {
    /// The caller said so.
    Stated,
    /// The file tells clearly.
    Guessed,
    /// The file tells little; the answer is the nearest one.
    Unsure,
}

/// A unit and the body it would make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Metres per file unit.
    pub metres_per_unit: f64,
    /// Height of the skeleton along its bones, m.
    pub height_m: f64,
}

/// The unit of length.
#[derive(Clone, Debug, PartialEq)]
pub struct Units {
    /// The unit taken.
    pub metres_per_unit: f64,
    /// Where it comes from.
    pub chosen: Chosen,
    /// Whether a head and a foot were found by name; else the largest extent stands for the height.
    pub human: bool,
    /// Every unit considered, the most plausible first.
    pub candidates: Vec<Candidate>,
}

impl Units {
    /// Height of the skeleton along its bones (its largest extent where no head and feet are known) in the unit
    /// taken, m.
    pub fn height_m(&self) -> f64 {
        self.candidates.first().map_or(0.0, |c| c.height_m / c.metres_per_unit) * self.metres_per_unit
    }
}

impl fmt::Display for Units {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "units: {} m (", short(self.metres_per_unit))?;
        let is = if self.human { "tall" } else { "across" };
        let height_m = self.height_m();
        match self.chosen {
            Chosen::Stated => write!(f, "stated: the skeleton is {height_m:.2} m {is})"),
            Chosen::Guessed => write!(f, "guessed: the skeleton is {height_m:.2} m {is})"),
            Chosen::Unsure => {
                if self.human {
                    write!(f, "unsure, no common unit makes a body of 1.25 to 2.15 m:")?;
                } else {
                    write!(f, "unsure, no joint is called head and foot:")?;
                }
                write!(f, " {height_m:.2} m {is}")?;
                if let Some(c) = self.candidates.get(1) {
                    write!(f, ", or {:.2} m with units of {} m", c.height_m, short(c.metres_per_unit))?;
                }
                write!(f, "; state the units if this is wrong)")
            }
        }
    }
}

/// Six significant digits.
pub(super) fn short(x: f64) -> String {
    let digits = (5 - x.abs().log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Length from the sole to the crown along the bones, file units, and whether head and foot were found.
fn height(bvh: &Bvh) -> (f64, bool) {
    let bones: Vec<Vec3> = bvh
        .joints
        .iter()
        .map(|joint| match (joint.parent, bvh.frames) {
            (Some(_), 1..) => origin(joint, of_joint(joint, bvh.frame(0))),
            _ => Vec3::from(joint.offset),
        })
        .collect();
    let Some(marks) = Landmarks::find(bvh) else {
        let at = world(bvh, None);
        let extent = |k: usize| {
            let (lo, hi) = at
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), (_, p)| (lo.min(p[k]), hi.max(p[k])));
            hi - lo
        };
        return (extent(0).max(extent(1)).max(extent(2)), false);
    };
    let chain = |mut j: usize| {
        let mut path = vec![j];
        while let Some(p) = bvh.joints[j].parent {
            path.push(p);
            j = p;
        }
        path
    };
    let (head, foot) = (marks.head, marks.feet[0]);
    let (to_head, to_foot) = (chain(head), chain(foot));
    let shared = to_head.iter().rev().zip(to_foot.iter().rev()).take_while(|(a, b)| a == b).count();
    let length = |path: &[usize]| path[..path.len() - shared].iter().map(|&j| bones[j].norm()).sum::<f64>();

    // Beyond the head joint: the longest way to a leaf. Below the ankle: the farthest along the shin, in the
    // first frame, because bones of some files point along X whatever they are.
    let pose = world(bvh, (bvh.frames > 0).then(|| bvh.frame(0)));
    let ankle = pose[foot].1;
    let knee = bvh.joints[foot].parent.map_or(ankle, |p| pose[p].1);
    let shin = (ankle - knee).try_normalize(1e-12).unwrap_or_else(Vec3::zeros);
    let (mut crown, mut sole) = (0.0f64, 0.0f64);
    let mut beyond_head: Vec<Option<f64>> = vec![None; bones.len()];
    let mut beyond_foot = vec![false; bones.len()];
    for (j, joint) in bvh.joints.iter().enumerate() {
        let parent = joint.parent;
        beyond_head[j] = if j == head {
            Some(0.0)
        } else {
            parent.and_then(|p| beyond_head[p]).map(|far| far + bones[j].norm())
        };
        beyond_foot[j] = j == foot || parent.is_some_and(|p| beyond_foot[p]);
        for end in joint.ends.iter().map(|&e| Vec3::from(e)).chain([Vec3::zeros()]) {
            if let Some(far) = beyond_head[j] {
                crown = crown.max(far + end.norm());
            }
            if beyond_foot[j] {
                let (turn, at) = &pose[j];
                sole = sole.max((at + turn * end - ankle).dot(&shin));
            }
        }
    }
    (length(&to_head) + length(&to_foot) + crown + sole, true)
}

/// The unit of length; `stated` wins.
pub(super) fn units(bvh: &Bvh, stated: Option<f64>) -> Units {
    let (height, human) = height(bvh);
    let mut candidates = UNITS
        .map(|metres_per_unit| Candidate { metres_per_unit, height_m: height * metres_per_unit })
        .to_vec();
    let off = |c: &Candidate| (c.height_m / HEIGHT).ln().abs();
    candidates.sort_by(|a, b| off(a).total_cmp(&off(b)));
    let best = candidates.iter().find(|c| HEIGHTS.contains(&c.height_m)).unwrap_or(&candidates[0]);
    let chosen = match stated {
        Some(_) => Chosen::Stated,
        None if human && HEIGHTS.contains(&best.height_m) => Chosen::Guessed,
        None => Chosen::Unsure,
    };
    Units { metres_per_unit: stated.unwrap_or(best.metres_per_unit), chosen, human, candidates }
}
