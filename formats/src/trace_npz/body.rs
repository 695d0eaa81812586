//! The body of a trace as arrays: what of a character is not already in its masses and offsets.
//!
//! In: a [`Character`]. Out: the arrays of the lower half of the table in [`super`], as flat numbers;
//! and back. Units: m, rad, kg.

use motion::{BallLimits, Joint, LimbKind, Limits, Link, Quat, Range, Shape, Vec3};
use nalgebra::Quaternion;

use bodies::{Character, JointClass};

/// Joint classes and their names.
pub const CLASSES: &[(&str, JointClass)] = &[
    ("root", JointClass::Root),
    ("spine", JointClass::Spine),
    ("neck", JointClass::Neck),
    ("clavicle", JointClass::Clavicle),
    ("shoulder", JointClass::Shoulder),
    ("elbow", JointClass::Elbow),
    ("wrist", JointClass::Wrist),
    ("hip", JointClass::Hip),
    ("knee", JointClass::Knee),
    ("ankle", JointClass::Ankle),
    ("other", JointClass::Other),
];

/// Limb kinds and their names.
pub const LIMBS: &[(&str, LimbKind)] = &[("arm", LimbKind::Arm), ("leg", LimbKind::Leg)];

/// Joint types.
pub const JOINTS: &[&str] = &["free", "spherical", "revolute", "prismatic", "fixed"];

/// Kinds of shapes.
pub const SHAPES: &[&str] = &["capsule", "box", "sphere", "cone"];

/// Numbers of a shape.
pub const SHAPE: usize = 10;

/// Name of a joint's type, of [`JOINTS`].
pub fn joint_type(joint: &Joint) -> &'static str {
    match joint {
        Joint::Free => "free",
        Joint::Spherical => "spherical",
        Joint::Revolute(_) => "revolute",
        Joint::Prismatic(_) => "prismatic",
        Joint::Fixed => "fixed",
    }
}

/// The joint of a type of [`JOINTS`] and an axis.
pub fn joint(kind: &str, axis: Vec3) -> Joint {
    match kind {
        "free" => Joint::Free,
        "spherical" => Joint::Spherical,
        "revolute" => Joint::Revolute(axis),
        "prismatic" => Joint::Prismatic(axis),
        _ => Joint::Fixed,
    }
}

/// Axes (9) and ranges (6) of a link's limits.
pub fn limits_out(link: &Link) -> ([f64; 9], [f64; 6]) {
    let (mut axes, mut ranges) = ([f64::NAN; 9], [f64::NAN; 6]);
    match &link.limits {
        None => {}
        Some(Limits::Axis(r)) => ranges[..2].copy_from_slice(&[r.lo, r.hi]),
        Some(Limits::Ball(b)) => {
            for k in 0..3 {
                axes[3 * k..3 * k + 3].copy_from_slice(b.axes[k].as_slice());
                ranges[2 * k..2 * k + 2].copy_from_slice(&[b.ranges[k].lo, b.ranges[k].hi]);
            }
        }
    }
    (axes, ranges)
}

/// Limits of axes (9) and ranges (6); `None` where the first range is NaN.
pub fn limits_in(axes: &[f64], ranges: &[f64]) -> Option<Limits> {
    let range = |k: usize| Range::new(ranges[2 * k], ranges[2 * k + 1]);
    if ranges[0].is_nan() {
        return None;
    }
    if axes[0].is_nan() {
        return Some(Limits::Axis(range(0)));
    }
    let axis = |k: usize| Vec3::new(axes[3 * k], axes[3 * k + 1], axes[3 * k + 2]);
    Some(Limits::Ball(BallLimits {
        axes: [axis(0), axis(1), axis(2)],
        ranges: [range(0), range(1), range(2)],
    }))
}

/// Whether the axes of a ball's limits are orthonormal.
pub fn orthonormal(limits: &BallLimits) -> bool {
    let dot = |i: usize, j: usize| limits.axes[i].dot(&limits.axes[j]) - f64::from(u8::from(i == j));
    (0..3).all(|i| (0..3).all(|j| dot(i, j).abs() < 1e-6))
}

/// All shapes: link, kind, numbers.
pub fn shapes_out(character: &Character) -> Vec<(usize, &'static str, [f64; SHAPE])> {
    let all = character.bodies.iter().enumerate();
    all.flat_map(|(link, body)| body.shapes.iter().map(move |s| (link, s)))
        .map(|(link, shape)| {
            let mut n = [0.0; SHAPE];
            let kind = match shape {
                Shape::Capsule { a, b, radius } => {
                    n[..3].copy_from_slice(a.as_slice());
                    n[3..6].copy_from_slice(b.as_slice());
                    n[6] = *radius;
                    "capsule"
                }
                Shape::Box { center, half, rotation: r } => {
                    n[..3].copy_from_slice(center.as_slice());
                    n[3..6].copy_from_slice(half.as_slice());
                    n[6..].copy_from_slice(&[r.w, r.i, r.j, r.k]);
                    "box"
                }
                Shape::Sphere { center, radius } => {
                    n[..3].copy_from_slice(center.as_slice());
                    n[3] = *radius;
                    "sphere"
                }
                Shape::Cone { a, b, radius_a, radius_b } => {
                    n[..3].copy_from_slice(a.as_slice());
                    n[3..6].copy_from_slice(b.as_slice());
                    n[6..8].copy_from_slice(&[*radius_a, *radius_b]);
                    "cone"
                }
            };
            (link, kind, n)
        })
        .collect()
}

/// A shape of a kind of [`SHAPES`]; `None` if a number is not finite, a length not positive or a
/// quaternion not of length 1.
pub fn shape_in(kind: &str, n: &[f64]) -> Option<Shape> {
    let v = |at: usize| Vec3::new(n[at], n[at + 1], n[at + 2]);
    let ok = n.iter().all(|x| x.is_finite());
    match kind {
        "capsule" if ok && n[6] > 0.0 => Some(Shape::Capsule { a: v(0), b: v(3), radius: n[6] }),
        "box" if ok && v(3).min() > 0.0 => {
            Some(Shape::Box { center: v(0), half: v(3), rotation: quaternion(&n[6..])? })
        }
        "cone" if ok && n[6] > 0.0 && n[7] > 0.0 && v(0) != v(3) => {
            Some(Shape::Cone { a: v(0), b: v(3), radius_a: n[6], radius_b: n[7] })
        }
        "sphere" if ok && n[3] > 0.0 => Some(Shape::Sphere { center: v(0), radius: n[3] }),
        _ => None,
    }
}

/// The quaternion `w x y z`, kept to the bit; `None` if its length is not 1.
pub fn quaternion(n: &[f64]) -> Option<Quat> {
    let q = Quaternion::new(n[0], n[1], n[2], n[3]);
    ((q.norm() - 1.0).abs() < 1e-6).then(|| Quat::new_unchecked(q))
}
