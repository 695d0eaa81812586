//! Simple solids that stand for flesh: what is drawn, exported and collides.
//!
//! In a link's frame, metres. Volume and surface only; mass is a character's business.

use crate::rotation::{Quat, Vec3};

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
}
