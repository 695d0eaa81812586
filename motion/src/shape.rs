//! Simple solids that stand for flesh: what is drawn, exported and collides.
//!
//! In a link's frame, metres. Volume and surface only; mass is a character's business.

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
