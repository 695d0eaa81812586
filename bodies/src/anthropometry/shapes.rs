//! Capsules and boxes that look like a body.
//!
//! In: the neutral pose, stature. Out: [`Shape`]s in link frames. Radii are fractions of stature, chosen
//! so that the figure looks like an average man: they are for the eye and for rough collisions. Mass
//! and inertia come from [`segments`](super::segments) and do not depend on them.

use motion::{Kinematics, Shape, Skeleton, Vec3};

use super::aliases::Side;
use super::frame::{Neutral, UP, carried_points};

/// Radii in statures.
mod radius {
    pub const HEAD: f64 = 0.048;
    pub const NECK: f64 = 0.032;
    pub const SHOULDER: f64 = 0.034;
    pub const UPPER_ARM: f64 = 0.027;
    pub const FOREARM: f64 = 0.022;
    pub const HAND: f64 = 0.019;
    pub const THIGH: f64 = 0.046;
    pub const SHIN: f64 = 0.032;
}

/// Half width and half depth of the trunk (statures) at heights from the hips (0) to the top of the
/// breastbone (1).
const TRUNK: [(f64, f64, f64); 6] = [
    (-0.12, 0.085, 0.052),
    (0.06, 0.099, 0.060),
    (0.42, 0.079, 0.053),
    (0.70, 0.096, 0.064),
    (0.88, 0.101, 0.061),
    (1.02, 0.072, 0.040),
];

/// Half width and half depth of the trunk at height `s`, statures.
fn trunk_at(s: f64) -> (f64, f64) {
    let s = s.clamp(TRUNK[0].0, TRUNK[TRUNK.len() - 1].0);
    let i = TRUNK.windows(2).position(|w| s <= w[1].0).unwrap_or(TRUNK.len() - 2);
    let ((s0, w0, d0), (s1, w1, d1)) = (TRUNK[i], TRUNK[i + 1]);
    let t = (s - s0) / (s1 - s0);
    (w0 + (w1 - w0) * t, d0 + (d1 - d0) * t)
}

/// Capsules across a slice of the trunk: enough that their outline is round, not stepped.
///
/// * `lo`, `hi`: heights of the slice, 0 at the hips, 1 at the top of the breastbone
/// * `at`: the middle of the trunk at a height, world, m
pub fn trunk_slab(
    n: &Neutral,
    link: usize,
    stature: f64,
    lo: f64,
    hi: f64,
    at: impl Fn(f64) -> Vec3,
) -> Vec<Shape> {
    let height = (at(hi) - at(lo)).norm();
    let count = (height / (0.035 * stature)).round().max(1.0);
    (0..count as usize)
        .map(|i| {
            let s = lo + (hi - lo) * (i as f64 + 0.5) / count;
            let (w, d) = trunk_at(s);
            let half = (w - d) * stature;
            let middle = at(s);
            Shape::Capsule {
                a: n.to_link(link, &(middle + n.left * half)),
                b: n.to_link(link, &(middle - n.left * half)),
                radius: d * stature,
            }
        })
        .collect()
}

/// A capsule from the joint of a link along its bone.
fn along(n: &Neutral, link: usize, from: f64, to: f64, radius: f64) -> Vec<Shape> {
    vec![Shape::Capsule { a: n.bone[link] * from, b: n.bone[link] * to, radius }]
}

/// Upper arm.
pub fn upper_arm(n: &Neutral, link: usize, stature: f64) -> Vec<Shape> {
    along(n, link, 0.0, 1.0, radius::UPPER_ARM * stature)
}

/// Forearm.
pub fn forearm(n: &Neutral, link: usize, stature: f64) -> Vec<Shape> {
    along(n, link, 0.0, 1.0, radius::FOREARM * stature)
}

/// Hand with fingers, slightly curled.
pub fn hand(n: &Neutral, link: usize, stature: f64) -> Vec<Shape> {
    along(n, link, 0.15, 0.78, radius::HAND * stature)
}

/// Thigh.
pub fn thigh(n: &Neutral, link: usize, stature: f64) -> Vec<Shape> {
    along(n, link, 0.02, 0.97, radius::THIGH * stature)
}

/// Shin.
pub fn shin(n: &Neutral, link: usize, stature: f64) -> Vec<Shape> {
    along(n, link, 0.0, 0.97, radius::SHIN * stature)
}

/// Neck joint.
pub fn neck(n: &Neutral, link: usize, stature: f64) -> Vec<Shape> {
    along(n, link, 0.0, 1.0, radius::NECK * stature)
}

/// Collar bone with the muscle over it.
pub fn clavicle(n: &Neutral, link: usize, stature: f64) -> Vec<Shape> {
    along(n, link, 0.35, 0.97, radius::SHOULDER * stature)
}

/// Head: an upright capsule whose top is the crown and whose height is 0.13 statures.
pub fn head(n: &Neutral, link: usize, stature: f64, crown: &Vec3) -> Vec<Shape> {
    let r = radius::HEAD * stature;
    let top = n.offset(crown, 0.0, -r, 0.012 * stature);
    let bottom = top - UP * (0.13 * stature - 2.0 * r);
    vec![Shape::Capsule { a: n.to_link(link, &bottom), b: n.to_link(link, &top), radius: r }]
}

/// A foot as a box, flat on the ground in the neutral pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootBox {
    /// Below the ankle, world, at sole height.
    pub under_ankle: Vec3,
    /// From there forward to the toes, m.
    pub front: f64,
    /// From there backward to the heel, m.
    pub back: f64,
    /// Breadth, m.
    pub width: f64,
    /// Height of the box, m.
    pub height: f64,
}

/// Flesh between the deepest joint or end of a rig's foot and its sole, in statures suggested by the legs.
pub const FLESH_UNDER_FOOT: f64 = 0.007;

impl FootBox {
    /// The box of a foot in the neutral pose.
    ///
    /// Its depth below the ankle is the deepest point of the rig's foot with [`FLESH_UNDER_FOOT`] below, but
    /// at least 0.039 statures, the ankle height of \[Win09, Fig. 4.1\]; the toes end where the rig's do, if
    /// that is 0.09 to 0.115 statures ahead of the ankle.
    ///
    /// \[Win09\] D. A. Winter. Biomechanics and motor control of human movement, 4th ed., 2009.
    pub fn of_foot(s: &Skeleton, n: &Neutral, foot: usize) -> Self {
        let h = n.leg_stature;
        // toes are welded as they are in the zero pose
        let zero = Kinematics::new(s, &s.zero_pose());
        let points: Vec<Vec3> = carried_points(s, &zero, foot).iter().map(|p| n.rotation[foot] * p).collect();
        let deepest = points.iter().map(|p| -p.y).fold(0.0, f64::max);
        let reach = points.iter().map(|p| p.dot(&n.front)).fold(0.0, f64::max);
        let depth = (deepest + FLESH_UNDER_FOOT * h).clamp(0.039 * h, 0.075 * h);
        Self {
            under_ankle: n.origin[foot] - UP * depth,
            front: if reach > 0.0 { reach.clamp(0.09 * h, 0.115 * h) } else { 0.11 * h },
            back: 0.0,
            width: 0.055 * h,
            height: 0.8 * depth,
        }
    }

    /// The same foot with its heel where it makes the foot `length` long (m), or a little nearer: at most
    /// 0.35 of the length is behind the ankle, and at least 0.15.
    pub fn with_length(mut self, length: f64) -> Self {
        self.front = self.front.min(0.85 * length);
        self.back = (length - self.front).min(0.35 * length);
        self
    }

    /// The box in the frame of `link`.
    pub fn shape(&self, n: &Neutral, link: usize) -> Shape {
        let center = n.offset(&self.under_ankle, 0.0, 0.5 * self.height, 0.5 * (self.front - self.back));
        Shape::Box {
            center: n.to_link(link, &center),
            half: Vec3::new(self.width, self.height, self.front + self.back) * 0.5,
            rotation: n.rotation[link].inverse() * n.heading(),
        }
    }

    /// Corner points of its sole in the frame of `link` with the beginning of their names.
    pub fn corners(&self, n: &Neutral, link: usize, side: Side) -> [(String, Vec3); 4] {
        let at = |word: &str, inner: bool, front: f64| {
            let out = if inner { -1.0 } else { 1.0 } * side.sign() * 0.5 * self.width;
            let end = if inner { "in" } else { "out" };
            let p = n.offset(&self.under_ankle, out, 0.0, front);
            (format!("{word}_{}_{end}", side.letter()), n.to_link(link, &p))
        };
        [
            at("heel", true, -self.back),
            at("heel", false, -self.back),
            at("ball", true, self.front),
            at("ball", false, self.front),
        ]
    }
}
