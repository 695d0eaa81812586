//! Rigid bodies taken as one: mass, centre of mass, inertia.
//!
//! In: two rigid bodies as (mass kg, centre of mass m, inertia about it kg·m²) along the same axes. Out: the body they
//! make together (parallel-axis theorem).

use motion::Vec3;
use nalgebra::Matrix3;

/// Mass, centre of mass and inertia of two rigid bodies taken as one (parallel-axis theorem).
pub fn fuse(a: (f64, Vec3, Matrix3<f64>), b: (f64, Vec3, Matrix3<f64>)) -> (f64, Vec3, Matrix3<f64>) {
    let mass = a.0 + b.0;
    if mass == 0.0 {
        return a;
    }
    let com = (a.1 * a.0 + b.1 * b.0) / mass;
    let inertia = a.2 + point_inertia(a.0, a.1 - com) + b.2 + point_inertia(b.0, b.1 - com);
    (mass, com, inertia)
}

/// Inertia of a point mass at `r` about the origin: m (|r|² 1 − r rᵀ).
pub fn point_inertia(mass: f64, r: Vec3) -> Matrix3<f64> {
    (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * mass
}
