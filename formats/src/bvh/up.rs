//! Which axis of a file is up.
//!
//! In: a [`Bvh`] and what the caller says. Out: an [`UpAxis`].
//!
//! Three witnesses, of which the file may contradict one:
//!
//! - *the motion*: the mean direction from feet to head over the frames, if it is clear (1.5 times as much along
//!   one axis as along any other);
//! - *the skeleton*: the same direction of the zero pose;
//! - *the heights*: files put the floor at zero. Of someone who stands the feet are there (between −0.03 and 0.1 of the
//!   body's height) and the root is 0.3 up or more; of someone who lies nine of ten joints are above such a floor, and
//!   the root is 0.03 to 0.25 up.
//!
//! Motion and skeleton agree: that axis. They differ: either the root stands a skeleton up in another axis than
//! its own (common in files with Z up), or someone lies; the heights decide where they fit one of the two only. Someone who lies is never more than *unsure*, nor is anything else that the witnesses leave open.

use std::fmt;
use std::ops::RangeInclusive;

use motion::names::Word;
use motion::rotation::Vec3;

use super::Bvh;
use super::guess::Chosen;
use super::pose::{Landmarks, world};

/// A direction is clear if it has this many times as much along its axis as along any other.
const CLEAR: f64 = 1.5;
/// The floor lies at zero if what lies on it is between these parts of the body's height.
const FLOOR: RangeInclusive<f64> = -0.03..=0.1;
/// Heights of the root of someone who stands, in parts of the body's.
const STANDS: RangeInclusive<f64> = 0.3..=1.0;
/// Heights of the root of someone who lies: hips are as thick as a hand is long.
const LIES: RangeInclusive<f64> = 0.03..=0.25;
/// Frames looked at.
const FRAMES: usize = 64;

/// A vertical axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Y, as inside Contrapposto.
    Y,
    /// Z.
    Z,
}

impl Axis {
    fn index(self) -> usize {
        match self {
            Self::Y => 1,
            Self::Z => 2,
        }
    }
}

impl Word for Axis {
    const KIND: &'static str = "vertical axis";
    const WORDS: &'static [(Self, &'static str, &'static str)] =
        &[(Self::Y, "y", "Y up, as Contrapposto has it"), (Self::Z, "z", "Z up; the clip is turned")];
}

/// Where things are along X, Y and Z over the frames, in parts of the body's height.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Heights {
    /// Nine of ten joints are above.
    pub most: [f64; 3],
    /// The lowest foot.
    pub foot: [f64; 3],
    /// The root, mean.
    pub root: [f64; 3],
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
    /// The same of the zero pose.
    pub zero_pose: [f64; 3],
    /// Where things are along X, Y and Z.
    pub heights: Heights,
}

impl fmt::Display for UpAxis {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [x, y, z] = self.feet_to_head;
        write!(f, "up: {:?} (", self.axis)?;
        match self.chosen {
            Chosen::Stated => return write!(f, "stated)"),
            Chosen::Guessed => {
                return write!(f, "guessed from the mean direction from feet to head, {x:.2} {y:.2} {z:.2})");
            }
            Chosen::Unsure if x == 0.0 && y == 0.0 && z == 0.0 => {
                write!(f, "unsure, no joint is called head and foot")?;
            }
            Chosen::Unsure => {
                write!(f, "unsure, the mean direction from feet to head is {x:.2} {y:.2} {z:.2}")?;
                let [x, y, z] = self.zero_pose;
                write!(f, ", in the zero pose {x:.2} {y:.2} {z:.2}")?;
                let [_, y, z] = self.heights.root.map(|x| 100.0 * x);
                write!(f, "; the root lies {y:.0} % of the body's height up Y, {z:.0} % up Z")?;
            }
        }
        write!(f, "; state the axis if this is wrong)")
    }
}

/// The axis along which a direction is clear, and positive.
fn clear(v: &Vec3) -> Option<Axis> {
    [Axis::Y, Axis::Z].into_iter().find(|axis| {
        let along = v[axis.index()];
        (0..3).filter(|&k| k != axis.index()).all(|k| along > CLEAR * v[k].abs())
    })
}

/// The axis with more of a direction.
fn nearer(v: &Vec3) -> Axis {
    if v.z.abs() > v.y.abs() { Axis::Z } else { Axis::Y }
}

/// The vertical axis, and whether the zero pose stands along it too; `height` in file units.
pub(super) fn up(bvh: &Bvh, height: f64, stated: Option<Axis>) -> (UpAxis, bool) {
    let marks = Landmarks::find(bvh);
    let (mut mean, mut root, mut foot) = (Vec3::zeros(), Vec3::zeros(), Vec3::repeat(f64::INFINITY));
    let mut joints = [Vec::new(), Vec::new(), Vec::new()];
    let count = bvh.frames.min(FRAMES);
    for i in 0..count {
        let world = world(bvh, Some(bvh.frame(i * bvh.frames / count)));
        root += world[0].1 / count as f64;
        for (k, joints) in joints.iter_mut().enumerate() {
            joints.extend(world.iter().skip(1).map(|(_, at)| at[k]));
        }
        if let Some(marks) = &marks {
            mean += marks.feet_to_head(&world) / count as f64;
            marks.feet.iter().for_each(|&f| foot = foot.inf(&world[f].1));
        }
    }
    let height = height.max(1e-12);
    let most = joints.map(|mut of: Vec<f64>| {
        of.sort_by(f64::total_cmp);
        of.get(of.len() / 10).copied().unwrap_or(0.0)
    });
    let parts = |v: [f64; 3]| v.map(|x| x / height);
    let heights = Heights { most: parts(most), foot: parts(foot.into()), root: parts(root.into()) };
    let rest = marks.map_or_else(
        || {
            // Nothing is known by name: the zero pose is longest along its vertical axis.
            let at = world(bvh, None);
            let far = |k: usize| at.iter().map(|(_, p)| (p[k] - at[0].1[k]).abs()).fold(0.0, f64::max);
            Vec3::new(0.0, far(1), far(2))
        },
        |m| m.feet_to_head(&world(bvh, None)),
    );
    let (axis, sure) = decide(&mean, &rest, &heights);
    let chosen = match stated {
        Some(_) => Chosen::Stated,
        None if sure => Chosen::Guessed,
        None => Chosen::Unsure,
    };
    let axis = stated.unwrap_or(axis);
    let up = UpAxis { axis, chosen, feet_to_head: mean.into(), zero_pose: rest.into(), heights };
    (up, nearer(&rest) == axis)
}

/// The axis that is up and whether that is sure; the module header has the rule.
fn decide(mean: &Vec3, rest: &Vec3, heights: &Heights) -> (Axis, bool) {
    if *mean == Vec3::zeros() {
        return (nearer(rest), false);
    }
    match (clear(mean), clear(rest)) {
        (Some(posed), Some(rest)) if posed != rest => {
            let stands = |i: usize| FLOOR.contains(&heights.foot[i]) && STANDS.contains(&heights.root[i]);
            let lies = |i: usize| FLOOR.contains(&heights.most[i]) && LIES.contains(&heights.root[i]);
            match (stands(posed.index()), lies(rest.index())) {
                (true, false) => (posed, true),
                (false, true) => (rest, false),
                _ => (posed, false),
            }
        }
        (Some(posed), _) => (posed, true),
        (None, Some(rest)) => (rest, false),
        (None, None) => (nearer(mean), false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Motion and skeleton agree; a direction is clear from 1.5 times any other on.
    #[test]
    fn a_clear_direction_is_sure_on_one_side_of_its_threshold() {
        let of = |mean: [f64; 3], rest: Vec3| decide(&mean.into(), &rest, &Heights::default());
        let y = Vec3::y();
        assert_eq!(of([0.0, 0.76, 0.5], y), (Axis::Y, true));
        assert_eq!(of([0.0, 0.74, 0.5], y), (Axis::Y, false));
        assert_eq!(of([0.5, 0.02, 0.76], Vec3::z()), (Axis::Z, true));
        assert_eq!(of([0.52, 0.02, 0.76], Vec3::z()), (Axis::Z, false));
        // along X nobody stands: the skeleton's axis, unsure
        assert_eq!(of([0.98, 0.01, 0.1], y), (Axis::Y, false));
        assert_eq!(of([0.98, 0.1, 0.01], Vec3::z()), (Axis::Z, false));
        // upside down
        assert_eq!(of([0.0, -1.0, 0.0], y), (Axis::Y, false));
    }

    /// Where motion and skeleton differ, the heights decide, from both sides of their thresholds.
    #[test]
    fn heights_tell_lying_from_another_axis() {
        // most joints and root along Y, feet and root along Z; the zero pose stands along Y, the motion along Z
        let of = |y: [f64; 2], z: [f64; 2]| {
            let heights =
                Heights { most: [0.0, y[0], 0.3], foot: [0.0, -0.2, z[0]], root: [0.0, y[1], z[1]] };
            decide(&Vec3::z(), &Vec3::y(), &heights)
        };
        let (off, stands, lies) = ([-0.5, 0.0], [0.02, 0.5], [0.06, 0.07]);
        assert_eq!(of(off, stands), (Axis::Z, true));
        assert_eq!(of(lies, off), (Axis::Y, false)); // never sure
        assert_eq!(of(lies, stands), (Axis::Z, false)); // both would do
        assert_eq!(of(off, off), (Axis::Z, false)); // neither
        assert_eq!(of(off, [0.11, 0.5]), (Axis::Z, false));
        assert_eq!(of(off, [0.09, 0.31]), (Axis::Z, true));
        assert_eq!(of(off, [0.09, 0.29]), (Axis::Z, false));
        assert_eq!(of([-0.04, 0.1], stands), (Axis::Z, true)); // the back of someone who stands is below y = 0
        assert_eq!(of([-0.02, 0.24], off), (Axis::Y, false));
        assert_eq!(of([-0.02, 0.26], off), (Axis::Z, false));
        assert_eq!(of([-0.02, 0.02], off), (Axis::Z, false));
        // the zero pose is no figure: the motion alone
        let rest = Vec3::new(0.6, 0.5, 0.6);
        assert_eq!(decide(&Vec3::z(), &rest, &Heights::default()), (Axis::Z, true));
    }
}
