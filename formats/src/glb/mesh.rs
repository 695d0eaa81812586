//! Solids to triangles with normals: modest, closed, counter-clockwise seen from outside.
//!
//! In: a [`Shape`] in its link's frame, m. Out: vertices, normals, indices. Vertices lie on the surface, so
//! the enclosed volume is a little less than the solid's (3 % for a ball).

use motion::Shape;
use motion::rotation::{Vec3, between};

/// Vertices around an axis.
const SEGMENTS: usize = 24;
/// Steps from an equator to its pole.
const RINGS: usize = 6;

/// Triangles of a surface.
#[derive(Default)]
pub(super) struct Mesh {
    /// Points, m.
    pub points: Vec<Vec3>,
    /// Outward unit normals.
    pub normals: Vec<Vec3>,
    /// Corners of triangles.
    pub indices: Vec<u32>,
}

/// The surface of a solid.
pub(super) fn mesh(shape: &Shape) -> Mesh {
    match *shape {
        Shape::Sphere { center, radius } => capsule(&center, &center, radius),
        Shape::Capsule { a, b, radius } => capsule(&a, &b, radius),
        Shape::Cone { a, b, radius_a, radius_b } => cone(shape, &a, &b, [radius_a, radius_b]),
        Shape::Box { center, half, rotation } => {
            let mut mesh = Mesh::default();
            for axis in 0..3 {
                for sign in [1.0, -1.0] {
                    let normal = Vec3::ith(axis, sign);
                    // u × v = normal
                    let (u, v) = (Vec3::ith((axis + 1) % 3, 1.0), Vec3::ith((axis + 2) % 3, sign));
                    let first = mesh.points.len() as u32;
                    for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                        let corner = (normal + u * s + v * t).component_mul(&half);
                        mesh.points.push(center + rotation * corner);
                        mesh.normals.push(rotation * normal);
                    }
                    mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
                }
            }
            mesh
        }
    }
}

/// Two flat ends and the side between them.
fn cone(shape: &Shape, a: &Vec3, b: &Vec3, [radius_a, radius_b]: [f64; 2]) -> Mesh {
    let mut mesh = Mesh::default();
    let rims = shape.rims();
    let count = rims.len() / 2;
    let axis = (b - a).normalize();
    // outward normals of the side lean by the slope
    let slope = axis * ((radius_a - radius_b) / (b - a).norm());
    for (k, p) in rims.iter().enumerate() {
        let out = if k < count { (p - a) / radius_a } else { (p - b) / radius_b };
        mesh.points.push(*p);
        mesh.normals.push((out + slope).normalize());
    }
    let next = |k: usize| (k + 1) % count;
    for k in 0..count {
        let (p, q, r, s) = (k, next(k), count + k, count + next(k));
        mesh.indices.extend([p, q, s, p, s, r].map(|i| i as u32));
    }
    for (end, center, normal) in [(0, a, -axis), (1, b, axis)] {
        let first = mesh.points.len();
        mesh.points.push(*center);
        mesh.points.extend(&rims[end * count..(end + 1) * count]);
        mesh.normals.resize(mesh.points.len(), normal);
        for k in 0..count {
            let (p, q) = (first + 1 + k, first + 1 + next(k));
            let corners = if end == 0 { [first, q, p] } else { [first, p, q] };
            mesh.indices.extend(corners.map(|i| i as u32));
        }
    }
    mesh
}

/// All points within `radius` of a segment: half a ball about `a`, a tube, half a ball about `b`.
fn capsule(a: &Vec3, b: &Vec3, radius: f64) -> Mesh {
    let axis = b - a;
    let is_ball = axis.norm() <= 1e-9 * radius;
    let turn = if is_ball { motion::Quat::identity() } else { between(&Vec3::y(), &axis) };
    // Latitudes from pole to pole; a tube needs the equator twice, once for each half.
    let lower = (0..=RINGS).map(|i| (i, a));
    let upper = (RINGS..=2 * RINGS).skip(usize::from(is_ball)).map(|i| (i, b));
    let rings: Vec<(usize, &Vec3)> = lower.chain(upper).collect();
    let mut mesh = Mesh::default();
    let mut starts = Vec::with_capacity(rings.len());
    for &(i, center) in &rings {
        starts.push(mesh.points.len() as u32);
        let latitude = std::f64::consts::FRAC_PI_2 * (i as f64 / RINGS as f64 - 1.0);
        let around = if i == 0 || i == 2 * RINGS { 1 } else { SEGMENTS };
        for k in 0..around {
            let longitude = std::f64::consts::TAU * k as f64 / SEGMENTS as f64;
            let flat = if around == 1 { 0.0 } else { latitude.cos() };
            let normal = turn * Vec3::new(flat * longitude.sin(), latitude.sin(), flat * longitude.cos());
            mesh.points.push(center + normal * radius);
            mesh.normals.push(normal);
        }
    }
    let (last, count) = (rings.len() - 1, SEGMENTS as u32);
    for ring in 0..last {
        let (low, high) = (starts[ring], starts[ring + 1]);
        for k in 0..count {
            let next = (k + 1) % count;
            if ring == 0 {
                mesh.indices.extend([low, high + next, high + k]);
            } else if ring + 1 == last {
                mesh.indices.extend([low + k, low + next, high]);
            } else {
                mesh.indices.extend([low + k, low + next, high + next, low + k, high + next, high + k]);
            }
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Divergence theorem: V = ⅙ Σ p·(q × r) is positive only if all triangles face outwards and the surface
    /// is closed.
    fn volume(mesh: &Mesh) -> f64 {
        let corner = |i: u32| mesh.points[i as usize];
        mesh.indices.chunks(3).map(|t| corner(t[0]).dot(&corner(t[1]).cross(&corner(t[2]))) / 6.0).sum()
    }

    #[test]
    fn meshes_are_closed_outward_and_have_the_volume() {
        let off = Vec3::new(3.0, -2.0, 5.0);
        let turn = motion::rotation::exp(&Vec3::new(0.3, 1.1, -0.4));
        let ball = Shape::Sphere { center: off, radius: 0.4 };
        let boxed = Shape::Box { center: off, half: Vec3::new(0.1, 0.2, 0.3), rotation: turn };
        let b = off + Vec3::new(0.2, -0.9, 0.4);
        let capsule = Shape::Capsule { a: off, b, radius: 0.1 };
        let down = Shape::Capsule { a: off, b: off - Vec3::y(), radius: 0.1 };
        let (axis, [ra, rb]) = (b - off, [0.3, 0.1]);
        let cone = Shape::Cone { a: off, b, radius_a: ra, radius_b: rb };
        let frustum = PI * axis.norm() * (ra * ra + ra * rb + rb * rb) / 3.0;
        let sphere = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
        let tube = |r: f64, l: f64| sphere(r) + PI * r * r * l;
        for (shape, expected) in [
            (ball, sphere(0.4)),
            (boxed, 8.0 * 0.006),
            (capsule, tube(0.1, (b - off).norm())),
            (down, tube(0.1, 1.0)),
            (cone, frustum),
        ] {
            let mesh = mesh(&shape);
            let ratio = volume(&mesh) / expected; // 0.972, 1, 0.987, 0.987, 0.989 seen
            assert!(ratio > 0.97 && ratio < 1.0 + 1e-12, "{shape:?}: {ratio}");
            for triangle in mesh.indices.chunks(3) {
                let [p, q, r] = [0, 1, 2].map(|k| mesh.points[triangle[k] as usize]);
                let face = (q - p).cross(&(r - p)).normalize();
                for &k in triangle {
                    let n = mesh.normals[k as usize];
                    assert!((n.norm() - 1.0).abs() < 1e-12 && n.dot(&face) > 0.9, "{shape:?}");
                }
            }
        }
    }
}
