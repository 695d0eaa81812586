//! What a BVH file does not say: its unit of length, which axis is up, its exact rate, whether its
//! first frame is an inserted T-pose.
//!
//! In: a [`Bvh`]. Out: an answer, and on what it rests, so that a person can overrule it.
//!
//! *Units*: the length from the ankle's floor to the crown *along the bones* (it does not depend on the
//! pose) must be that of a person, 1.25 m to 2.15 m. The units in use differ by more than that range, so
//! at most one of them fits.
//! *Up*: the mean direction from feet to head over the frames, since some files stand in an axis their
//! zero pose does not.
//! *Rate*: the well-known rate nearest to the printed frame time, if printing with as few digits explains
//! the difference.
//! *T-pose*: in the first frame nearly all angles that move in the clip are zero, and the step to the
//! second frame, of the limbs or of the root, is far beyond the steps that follow.

use std::fmt;

use super::{Bvh, BvhJoint, Channel};
use motion::names::Word;
use motion::rotation::{Quat, Vec3, log};

/// Metres per unit: metres, centimetres, millimetres, inches, and the CMU files' unit, (1/0.45) inch.
const UNITS: [f64; 5] = [1.0, 0.01, 0.001, 0.0254, 2.54 / 45.0];
/// Heights of people, m.
const HEIGHTS: std::ops::RangeInclusive<f64> = 1.25..=2.15;
/// The height looked for where none is in the range, m.
const HEIGHT: f64 = 1.7;

/// Rates that cameras, capture systems and films use, Hz.
const RATES: [f64; 29] = [
    10.0,
    12.0,
    12.5,
    15.0,
    20.0,
    23.976,
    24000.0 / 1001.0,
    24.0,
    25.0,
    30000.0 / 1001.0,
    30.0,
    48.0,
    50.0,
    60000.0 / 1001.0,
    60.0,
    72.0,
    75.0,
    80.0,
    90.0,
    100.0,
    120000.0 / 1001.0,
    120.0,
    144.0,
    180.0,
    200.0,
    240.0,
    250.0,
    480.0,
    1000.0,
];

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

impl fmt::Display for Units {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "units: {} m (", short(self.metres_per_unit))?;
        let is = if self.human { "tall" } else { "across" };
        let of = |m: f64| self.candidates.iter().find(|c| c.metres_per_unit == m).map_or(0.0, |c| c.height_m);
        match self.chosen {
            Chosen::Stated => {
                let units = self.candidates.first().map_or(0.0, |c| c.height_m / c.metres_per_unit);
                write!(f, "stated: the skeleton is {:.2} m {is})", units * self.metres_per_unit)
            }
            Chosen::Guessed => {
                write!(f, "guessed: the skeleton is {:.2} m {is})", of(self.metres_per_unit))
            }
            Chosen::Unsure => {
                if self.human {
                    write!(f, "unsure, no common unit makes a body of 1.25 to 2.15 m:")?;
                } else {
                    write!(f, "unsure, no joint is called head and foot:")?;
                }
                write!(f, " {:.2} m {is}", of(self.metres_per_unit))?;
                if let Some(c) = self.candidates.get(1) {
                    write!(f, ", or {:.2} m with units of {} m", c.height_m, short(c.metres_per_unit))?;
                }
                write!(f, "; state the units if this is wrong)")
            }
        }
    }
}

/// Six significant digits.
fn short(x: f64) -> String {
    let digits = (5 - x.abs().log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A vertical axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Y, as inside Contrapposto.
    Y,
    /// Z.
    Z,
}

impl Word for Axis {
    const KIND: &'static str = "vertical axis";
    const WORDS: &'static [(Self, &'static str, &'static str)] =
        &[(Self::Y, "y", "Y up, as Contrapposto has it"), (Self::Z, "z", "Z up; the clip is turned")];
}

/// The file's vertical axis.
#[derive(Clone, Debug, PartialEq)]
pub struct UpAxis {
    /// The axis; a file with Z up is turned by −90° about X.
    pub axis: Axis,
    /// Where it comes from.
    pub chosen: Chosen,
    /// Mean direction from feet to head over the frames, file axes; zero if unknown.
    pub feet_to_head: [f64; 3],
}

impl fmt::Display for UpAxis {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [x, y, z] = self.feet_to_head;
        write!(f, "up: {:?} (", self.axis)?;
        match self.chosen {
            Chosen::Stated => write!(f, "stated)"),
            Chosen::Guessed => {
                write!(f, "guessed from the mean direction from feet to head, {x:.2} {y:.2} {z:.2})")
            }
            Chosen::Unsure if x == 0.0 && y == 0.0 && z == 0.0 => {
                write!(f, "unsure, no joint is called head and foot; state the axis if this is wrong)")
            }
            Chosen::Unsure => write!(
                f,
                "unsure, the mean direction from feet to head is {x:.2} {y:.2} {z:.2}; state the axis if this is wrong)"
            ),
        }
    }
}

/// The frame rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRate {
    /// The rate taken, Hz.
    pub rate_hz: f64,
    /// What the file says, s.
    pub frame_time_s: f64,
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (rate, stated) = (self.rate_hz, 1.0 / self.frame_time_s);
        write!(f, "rate: {} Hz (frame time {} s", short(rate), self.frame_time_s)?;
        if (rate / stated - 1.0).abs() > 1e-9 {
            write!(f, ", {stated:.4} Hz, within the rounding of its digits")?;
        }
        write!(f, ")")
    }
}

/// The product of a joint's rotation channels, left to right.
pub(super) fn rotation(joint: &BvhJoint, values: &[f64]) -> Quat {
    let mut product = Quat::identity();
    for (channel, &value) in joint.channels.iter().zip(values) {
        if let Channel::Rotation(axis) = *channel {
            let (sin, cos) = (0.5 * value.to_radians()).sin_cos();
            let mut q = [0.0; 3];
            q[axis] = sin;
            product *= Quat::new_unchecked(nalgebra::Quaternion::new(cos, q[0], q[1], q[2]));
        }
    }
    product
}

/// A joint's origin in its parent's frame, file units: position channels replace the offset.
pub(super) fn origin(joint: &BvhJoint, values: &[f64]) -> Vec3 {
    let mut at = Vec3::from(joint.offset);
    for (channel, &value) in joint.channels.iter().zip(values) {
        if let Channel::Position(axis) = *channel {
            at[axis] = value;
        }
    }
    at
}

/// The values of a joint in a frame.
pub(super) fn of_joint<'a>(joint: &BvhJoint, frame: &'a [f64]) -> &'a [f64] {
    &frame[joint.channels_at..joint.channels_at + joint.channels.len()]
}

/// World rotations and origins of the joints in a frame; with `None` all channels are zero, and
/// positions offsets.
fn world(bvh: &Bvh, frame: Option<&[f64]>) -> Vec<(Quat, Vec3)> {
    let mut world: Vec<(Quat, Vec3)> = Vec::with_capacity(bvh.joints.len());
    for joint in &bvh.joints {
        let (turn, at) = match frame {
            Some(frame) => {
                let values = of_joint(joint, frame);
                (rotation(joint, values), origin(joint, values))
            }
            None => (Quat::identity(), Vec3::from(joint.offset)),
        };
        let (up, from) = joint.parent.map_or((Quat::identity(), Vec3::zeros()), |p| world[p]);
        world.push((up * turn, from + up * at));
    }
    world
}

/// The head and the feet (or ankles), by name.
struct Landmarks {
    head: usize,
    feet: Vec<usize>,
}

impl Landmarks {
    fn find(bvh: &Bvh) -> Option<Self> {
        let names: Vec<String> = bvh.joints.iter().map(|j| j.name.to_lowercase()).collect();
        let head = names.iter().position(|n| n.contains("head"))?;
        let is_foot = |n: &str| n.contains("foot") || n.contains("ankle");
        // In each leg the first one: a `FootEnd` hangs on a foot.
        let mut below = vec![false; names.len()];
        let mut feet = Vec::new();
        for (i, joint) in bvh.joints.iter().enumerate() {
            let inherited = joint.parent.is_some_and(|p| below[p]);
            below[i] = inherited || is_foot(&names[i]);
            if below[i] && !inherited {
                feet.push(i);
            }
        }
        (!feet.is_empty()).then_some(Self { head, feet })
    }

    /// From the mean of the feet to the head, unit length (zero if they coincide).
    fn feet_to_head(&self, world: &[(Quat, Vec3)]) -> Vec3 {
        let feet: Vec3 = self.feet.iter().map(|&f| world[f].1).sum::<Vec3>() / self.feet.len() as f64;
        (world[self.head].1 - feet).try_normalize(1e-12).unwrap_or_else(Vec3::zeros)
    }
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

/// The vertical axis, and whether the zero pose stands along it too.
pub(super) fn up(bvh: &Bvh, stated: Option<Axis>) -> (UpAxis, bool) {
    const FRAMES: usize = 64;
    let marks = Landmarks::find(bvh);
    let mut mean = Vec3::zeros();
    if let Some(marks) = &marks {
        let count = bvh.frames.min(FRAMES);
        for i in 0..count {
            mean += marks.feet_to_head(&world(bvh, Some(bvh.frame(i * bvh.frames / count)))) / count as f64;
        }
    }
    let rest = marks.map_or_else(
        || {
            // Nothing is known by name: the zero pose is longest along its vertical axis.
            let at = world(bvh, None);
            let far = |k: usize| at.iter().map(|(_, p)| (p[k] - at[0].1[k]).abs()).fold(0.0, f64::max);
            Vec3::new(0.0, far(1), far(2))
        },
        |m| m.feet_to_head(&world(bvh, None)),
    );
    let axis_of = |v: &Vec3| if v.z.abs() > v.y.abs() { Axis::Z } else { Axis::Y };
    let (axis, clear) = if mean == Vec3::zeros() {
        (axis_of(&rest), false)
    } else {
        let axis = axis_of(&mean);
        let (along, across) = if axis == Axis::Y { (mean.y, mean.z) } else { (mean.z, mean.y) };
        (axis, along > 1.5 * across.abs().max(mean.x.abs()))
    };
    let chosen = match stated {
        Some(_) => Chosen::Stated,
        None if clear => Chosen::Guessed,
        None => Chosen::Unsure,
    };
    let axis = stated.unwrap_or(axis);
    (UpAxis { axis, chosen, feet_to_head: mean.into() }, axis_of(&rest) == axis)
}

/// The rate nearest to the printed frame time, if the lost digits explain the difference.
pub(super) fn rate(bvh: &Bvh) -> FrameRate {
    let time = bvh.frame_time_s;
    let off = |rate: &f64| (1.0 / rate - time).abs();
    // A whole digit, not half a one: some programs cut instead of rounding.
    let within = |rate: &&f64| off(rate) <= bvh.frame_time_digit_s * (1.0 + 1e-9) + 1e-12 * time;
    let known = RATES.iter().filter(within).min_by(|a, b| off(a).total_cmp(&off(b)));
    let stated = 1.0 / time;
    // A rate of few decimals survives the way through its reciprocal.
    let decimal = (stated * 1e6).round() / 1e6;
    let plain = if (decimal / stated - 1.0).abs() < 1e-12 { decimal } else { stated };
    FrameRate { rate_hz: known.copied().unwrap_or(plain), frame_time_s: time }
}

/// Whether the first frame is an inserted T-pose.
pub(super) fn t_pose(bvh: &Bvh) -> bool {
    /// Frames whose steps are compared with the first.
    const LATER: usize = 12;
    if bvh.frames < 3 || bvh.joints.len() < 4 {
        return false;
    }
    let moving: Vec<usize> = bvh
        .joints
        .iter()
        .skip(1)
        .flat_map(|joint| joint.channels.iter().zip(joint.channels_at..))
        .filter(|(channel, _)| matches!(channel, Channel::Rotation(_)))
        .map(|(_, at)| at)
        .filter(|&at| {
            let values = (0..bvh.frames).map(|f| bvh.frame(f)[at]);
            let (lo, hi) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
            hi - lo > 1.0
        })
        .collect();
    let at_zero = moving.iter().filter(|&&at| bvh.frame(0)[at].abs() < 1.0).count();
    if moving.is_empty() || 4 * at_zero < 3 * moving.len() {
        return false;
    }
    // Some programs smooth the limbs into the T-pose but not the root, so either step tells.
    let root = |frame: usize| rotation(&bvh.joints[0], of_joint(&bvh.joints[0], bvh.frame(frame)));
    let turn = |frame: usize| log(&(root(frame + 1) * root(frame).inverse())).norm().to_degrees();
    let step = |frame: usize| {
        let (a, b) = (bvh.frame(frame), bvh.frame(frame + 1));
        moving.iter().map(|&at| (a[at] - b[at]).abs().min(360.0)).sum::<f64>() / moving.len() as f64
    };
    let later = |step: &dyn Fn(usize) -> f64| (1..bvh.frames.min(LATER) - 1).map(step).fold(0.0, f64::max);
    let limbs_jump = step(0) > (3.0 * later(&step)).max(1.0);
    let root_jumps = log(&root(0)).norm() < 1e-3 && turn(0) > (3.0 * later(&turn)).max(10.0);
    limbs_jump || root_jumps
}
