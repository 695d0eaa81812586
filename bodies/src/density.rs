//! Mass and inertia of solids of even density.
//!
//! In: [`Shape`]s of one link and their density. Out: a [`Body`]. Units: m, kg/m³, kg, kg·m². Where shapes
//! overlap, the overlap counts once for each: shapes that are weighed should touch rather than overlap.
//!
//! Each solid gives volume V, centre c and inertia about c; they are summed by the parallel-axis theorem,
//! `I = Σ Iᵢ + mᵢ (|dᵢ|² 1 − dᵢ dᵢᵀ)`, dᵢ from the common centre of mass.

use std::f64::consts::PI;

use motion::rotation::between;
use motion::{Quat, Shape, Vec3};
use nalgebra::Matrix3;

use crate::Body;

/// Volume (m³), centre of mass (m) and inertia about it per kilogram (m²), along the link's axes.
pub fn solid_properties(shape: &Shape) -> (f64, Vec3, Matrix3<f64>) {
    let turned = |turn: Quat, diagonal: Vec3| {
        let r = turn.to_rotation_matrix();
        r.matrix() * Matrix3::from_diagonal(&diagonal) * r.matrix().transpose()
    };
    let ball = |r: f64| (4.0 / 3.0 * PI * r.powi(3), 0.4 * r * r);
    match *shape {
        Shape::Sphere { center, radius } => {
            let (volume, i) = ball(radius);
            (volume, center, Matrix3::from_diagonal_element(i))
        }
        Shape::Box { center, half, rotation } => {
            let s = half.component_mul(&half);
            let i = Vec3::new(s.y + s.z, s.x + s.z, s.x + s.y) / 3.0;
            (8.0 * half.x * half.y * half.z, center, turned(rotation, i))
        }
        Shape::Capsule { a, b, radius: r } => {
            // a cylinder of length h and two half balls, whose centres lie 3r/8 beyond its ends
            let (h, (balls, i)) = ((b - a).norm(), ball(r));
            let tube = PI * r * r * h;
            let volume = tube + balls;
            let along = (tube * r * r / 2.0 + balls * i) / volume;
            let across = (tube * (3.0 * r * r + h * h) / 12.0
                + balls * (i + h * h / 4.0 + 3.0 * h * r / 8.0))
                / volume;
            let turn = if h > 0.0 { between(&Vec3::y(), &(b - a)) } else { Quat::identity() };
            (volume, 0.5 * (a + b), turned(turn, Vec3::new(across, along, across)))
        }
        Shape::Cone { a, b, radius_a: p, radius_b: q } => {
            // r(u) = p + (q − p) u/h; ∫ r² , ∫ u r², ∫ u² r², ∫ r⁴ over 0..h, all divided by π
            let (h, axis) = ((b - a).norm(), b - a);
            let r2 = h * (p * p + p * q + q * q) / 3.0;
            let ur2 = h * h * (p * p + 2.0 * p * q + 3.0 * q * q) / 12.0;
            let u2r2 = h.powi(3) * (p * p + 3.0 * p * q + 6.0 * q * q) / 30.0;
            let r4 = h * (p.powi(4) + p.powi(3) * q + p * p * q * q + p * q.powi(3) + q.powi(4)) / 5.0;
            let middle = ur2 / r2;
            let along = 0.5 * r4 / r2;
            let across = 0.25 * r4 / r2 + u2r2 / r2 - middle * middle;
            let turn = between(&Vec3::y(), &axis);
            (PI * r2, a + axis * (middle / h), turned(turn, Vec3::new(across, along, across)))
        }
    }
}

/// The body made of these solids at this density (kg/m³). Without solids it has no mass.
pub fn body(shapes: Vec<Shape>, density: f64) -> Body {
    let parts: Vec<_> = shapes.iter().map(solid_properties).collect();
    let volume: f64 = parts.iter().map(|p| p.0).sum();
    let com = match volume > 0.0 {
        true => parts.iter().map(|(v, c, _)| c * *v).sum::<Vec3>() / volume,
        false => Vec3::zeros(),
    };
    let mut inertia = Matrix3::zeros();
    for (v, c, i) in &parts {
        let d = c - com;
        inertia += (i + Matrix3::from_diagonal_element(d.norm_squared()) - d * d.transpose()) * (v * density);
    }
    Body { mass: volume * density, com, inertia, shapes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::rotation::exp;

    /// The same by summing small cubes, with none of the formulas.
    fn by_cubes(inside: impl Fn(&Vec3) -> bool, low: Vec3, high: Vec3) -> (f64, Vec3, Matrix3<f64>) {
        let n = 120;
        let edge = (high - low) / f64::from(n);
        let points: Vec<Vec3> = (0..n * n * n)
            .map(|i| {
                let k = Vec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n));
                low + (k + Vec3::repeat(0.5)).component_mul(&edge)
            })
            .filter(|p| inside(p))
            .collect();
        let count = points.len() as f64;
        let com = points.iter().sum::<Vec3>() / count;
        let spread = points.iter().map(|p| p - com);
        let inertia = spread.map(|d| Matrix3::from_diagonal_element(d.norm_squared()) - d * d.transpose());
        (count * edge.x * edge.y * edge.z, com, inertia.sum::<Matrix3<f64>>() / count)
    }

    #[test]
    fn formulas_agree_with_small_cubes() {
        // an axis along no plane of the cubes, which would all be cut by a flat end at once
        let (a, b) = (Vec3::new(0.113, -0.207, 0.0519), Vec3::new(-0.2171, 0.2931, 0.2613));
        let along = |p: &Vec3| (p - a).dot(&(b - a)) / (b - a).norm_squared();
        let off_axis = move |p: &Vec3, u: f64| (p - a - (b - a) * u).norm();
        let turn = exp(&Vec3::new(0.4, -0.7, 0.2));
        let half = Vec3::new(0.1, 0.25, 0.15);
        type Inside<'a> = Box<dyn Fn(&Vec3) -> bool + 'a>;
        let cases: [(Shape, Inside); 4] = [
            (
                Shape::Cone { a, b, radius_a: 0.25, radius_b: 0.1 },
                Box::new(|p| {
                    let u = along(p);
                    (0.0..=1.0).contains(&u) && off_axis(p, u) < 0.25 - 0.15 * u
                }),
            ),
            (
                Shape::Capsule { a, b, radius: 0.15 },
                Box::new(|p| off_axis(p, along(p).clamp(0.0, 1.0)) < 0.15),
            ),
            (Shape::Sphere { center: b, radius: 0.2 }, Box::new(|p| (p - b).norm() < 0.2)),
            (
                Shape::Box { center: a, half, rotation: turn },
                Box::new(|p| (0..3).all(|k| (turn.inverse() * (p - a))[k].abs() < half[k])),
            ),
        ];
        for (shape, inside) in &cases {
            let (volume, com, inertia) = solid_properties(shape);
            let cubes = by_cubes(inside, Vec3::repeat(-0.6), Vec3::repeat(0.6));
            // 0.05 %, 0.06 mm and 0.12 % seen
            assert!((volume / cubes.0 - 1.0).abs() < 3e-3, "{shape:?}: {volume} {}", cubes.0);
            assert!((com - cubes.1).norm() < 3e-4, "{shape:?}: {com} {}", cubes.1);
            assert!((inertia - cubes.2).norm() < 5e-3 * inertia.norm(), "{shape:?}: {inertia} {}", cubes.2);
        }
    }

    /// A rod cut in two weighs as the whole one, wherever it is cut.
    #[test]
    fn a_solid_is_the_sum_of_its_parts() {
        let (a, b) = (Vec3::new(0.3, 0.0, -0.1), Vec3::new(0.0, 0.4, 0.2));
        let cone = |from: f64, to: f64| {
            let (at, radius) = (|u: f64| a + (b - a) * u, |u: f64| 0.2 - 0.15 * u);
            Shape::Cone { a: at(from), b: at(to), radius_a: radius(from), radius_b: radius(to) }
        };
        let whole = body(vec![cone(0.0, 1.0)], 700.0);
        let parts = body(vec![cone(0.0, 0.3), cone(0.3, 1.0)], 700.0);
        assert!((whole.mass - parts.mass).abs() < 1e-12, "{} {}", whole.mass, parts.mass); // 0 seen
        assert!((whole.com - parts.com).norm() < 1e-14);
        assert!((whole.inertia - parts.inertia).norm() < 1e-14 * 100.0); // 3e-16 seen
    }
}
