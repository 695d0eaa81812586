//! Mass and inertia of simple solids of even density.
//!
//! In: a shape and its density or mass. Out: mass, and principal inertias along the shape's own axes about
//! its centre (where its centre of mass is). Units: m, kg, kg/m³, kg·m².

use std::f64::consts::PI;

use crate::model_file::{FileShape, Weight};
use motion::Vec3;

/// Volume, m³; `None` for shapes without end and for meshes.
pub fn volume(shape: &FileShape) -> Option<f64> {
    Some(match *shape {
        FileShape::Sphere { radius: r } => 4.0 / 3.0 * PI * r * r * r,
        FileShape::Capsule { radius: r, half } => PI * r * r * (2.0 * half + 4.0 / 3.0 * r),
        FileShape::Cylinder { radius: r, half } => PI * r * r * 2.0 * half,
        FileShape::Box { half } => 8.0 * half.x * half.y * half.z,
        FileShape::Ellipsoid { half } => 4.0 / 3.0 * PI * half.x * half.y * half.z,
        FileShape::Plane | FileShape::HeightField | FileShape::Mesh => return None,
    })
}

/// Mass, kg; `None` where the volume would be needed and is not known.
pub fn mass(shape: &FileShape, weight: &Weight) -> Option<f64> {
    match *weight {
        Weight::Mass(mass) => Some(mass),
        Weight::Density(0.0) => Some(0.0),
        Weight::Density(density) => volume(shape).map(|v| v * density),
    }
}

/// Principal inertias about the centre along x, y, z of the shape, per kilogram, m².
///
/// Capsule: cylinder of length h and two half balls, masses by volume. A half ball of mass m/2 has
/// inertia 83/320 · m/2 · r² across its axis about its own centre of mass, which lies h/2 + 3r/8 from the
/// middle; together m (2r²/5 + h²/4 + 3hr/8).
pub fn inertia_per_mass(shape: &FileShape) -> Option<Vec3> {
    let sphere = |r: f64| 2.0 / 5.0 * r * r;
    Some(match *shape {
        FileShape::Sphere { radius } => Vec3::repeat(sphere(radius)),
        FileShape::Capsule { radius: r, half } => {
            let h = 2.0 * half;
            let ball = 4.0 * r / (4.0 * r + 3.0 * h); // share of the mass in the two half balls
            let cylinder = 1.0 - ball;
            let along = cylinder * r * r / 2.0 + ball * sphere(r);
            let across = cylinder * (3.0 * r * r + h * h) / 12.0
                + ball * (sphere(r) + h * h / 4.0 + 3.0 * h * r / 8.0);
            Vec3::new(across, across, along)
        }
        FileShape::Cylinder { radius: r, half } => {
            let across = (3.0 * r * r + 4.0 * half * half) / 12.0;
            Vec3::new(across, across, r * r / 2.0)
        }
        FileShape::Box { half } => {
            let s = half.component_mul(&half);
            Vec3::new(s.y + s.z, s.x + s.z, s.x + s.y) / 3.0
        }
        FileShape::Ellipsoid { half } => {
            let s = half.component_mul(&half);
            Vec3::new(s.y + s.z, s.x + s.z, s.x + s.y) / 5.0
        }
        FileShape::Plane | FileShape::HeightField | FileShape::Mesh => return None,
    })
}
