//! Simple solids that stand for flesh: what is drawn, exported and collides.
//!
//! In a link's frame, metres. Volume and surface only; mass is a character's business.

use crate::Transform;
use crate::rotation::{Quat, Vec3, between};

/// A convex solid fixed to a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// All points within `radius` of the segment from `a` to `b`.
    Capsule {
        /// One end of the segment, m.
        a: Vec3,
        /// The other end, m.
        b: Vec3,
        /// Radius, m.
        radius: f64,
    },
    /// A box.
    Box {
        /// Centre, m.
        center: Vec3,
        /// Half edge lengths along its own axes, m.
        half: Vec3,
        /// Orientation: `link_from_box`.
        rotation: Quat,
    },
    /// A ball.
    Sphere {
        /// Centre, m.
        center: Vec3,
        /// Radius, m.
        radius: f64,
    },
    /// A cone cut off flat at both ends; a cylinder where the radii are equal.
    Cone {
        /// Middle of one end, m.
        a: Vec3,
        /// Middle of the other end, m; not `a`.
        b: Vec3,
        /// Radius of the end at `a`, m, > 0.
        radius_a: f64,
        /// Radius of the end at `b`, m, > 0.
        radius_b: f64,
    },
}

/// Points on each rim where a cone is taken for a polyhedron.
const RIM: usize = 24;

impl Shape {
    /// How far the solid reaches along a direction, m: its support function.
    ///
    /// * `frame`: from the link's frame to that of the direction
    /// * `way`: unit length
    pub fn reach(&self, frame: &Transform, way: &Vec3) -> f64 {
        let at = |p: &Vec3| frame.transform_point(&(*p).into()).coords.dot(way);
        match self {
            Self::Capsule { a, b, radius } => at(a).max(at(b)) + radius,
            Self::Sphere { center, radius } => at(center) + radius,
            Self::Box { center, half, rotation } => {
                let local = (frame.rotation * rotation).inverse() * way;
                at(center) + half.dot(&local.abs())
            }
            Self::Cone { .. } => self.rims().iter().map(at).fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Corners of the polyhedron that stands for a cone in drawings and engines: 24 evenly on the rim about
    /// `a`, then 24 on the rim about `b`, in the link's frame, m. The rims go round the axis from `a` to
    /// `b` by the right hand. Empty for other shapes.
    pub fn rims(&self) -> Vec<Vec3> {
        let Self::Cone { a, b, radius_a, radius_b } = *self else { return Vec::new() };
        let turn = between(&Vec3::y(), &(b - a));
        let rim = |center: Vec3, radius: f64| {
            (0..RIM).map(move |i| {
                let (s, c) = (std::f64::consts::TAU * i as f64 / RIM as f64).sin_cos();
                center + turn * Vec3::new(s, 0.0, c) * radius
            })
        };
        rim(a, radius_a).chain(rim(b, radius_b)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::exp;

    /// Every solid reaches as far as the farthest of its points does, wherever it is turned.
    #[test]
    fn a_solid_reaches_as_far_as_its_points() {
        let frame = Transform::from_parts(Vec3::new(0.3, -0.2, 0.7).into(), exp(&Vec3::new(0.4, -0.9, 0.2)));
        let (a, b) = (Vec3::new(0.1, 0.2, -0.1), Vec3::new(-0.2, 0.5, 0.3));
        let rotation = exp(&Vec3::new(-0.3, 0.2, 0.8));
        let half = Vec3::new(0.1, 0.2, 0.4);
        let ball = |c: Vec3| {
            (0..4000).map(move |i| {
                let (z, t) = (1.0 - 2.0 * (f64::from(i) + 0.5) / 4000.0, f64::from(i) * 2.399_963);
                let r = (1.0 - z * z).sqrt();
                c + Vec3::new(r * t.cos(), r * t.sin(), z) * 0.05
            })
        };
        let corners = (0..8).map(|i| {
            let sign = |bit: i32| if i & bit == 0 { 1.0 } else { -1.0 };
            a + rotation * half.component_mul(&Vec3::new(sign(1), sign(2), sign(4)))
        });
        let cone = Shape::Cone { a, b, radius_a: 0.1, radius_b: 0.2 };
        let all: [(Shape, Vec<Vec3>); 4] = [
            (Shape::Sphere { center: a, radius: 0.05 }, ball(a).collect()),
            (Shape::Capsule { a, b, radius: 0.05 }, ball(a).chain(ball(b)).collect()),
            (Shape::Box { center: a, half, rotation }, corners.collect()),
            (cone, cone.rims()),
        ];
        for (shape, points) in all {
            for way in [Vec3::y(), -Vec3::y(), Vec3::new(0.6, 0.0, -0.8)] {
                let farthest = points.iter().map(|p| frame.transform_point(&(*p).into()).coords.dot(&way));
                let error = shape.reach(&frame, &way) - farthest.fold(f64::NEG_INFINITY, f64::max);
                assert!((-1e-12..1e-4).contains(&error), "{shape:?} {way}: {error}"); // a ball of points is 3e-5 short
            }
        }
    }
}
