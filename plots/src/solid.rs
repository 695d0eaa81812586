//! Solids as flat polygons: silhouettes of capsules, boxes and balls, shaded a little, and their shadows.
//!
//! In: a [`Shape`], where its link is, a [`Camera`]. Out: polygons in picture coordinates (m, right and
//! up), back to front. Light comes from above, over the viewer's left shoulder.

use motion::support::Vec2;
use motion::{Floor, Shape, Support, Transform, Vec3};

use crate::camera::Camera;
use crate::style::{Color, INK, WHITE};

/// A polygon on the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Facet {
    /// Corners, m.
    pub points: Vec<Vec2>,
    /// Colour.
    pub color: Color,
}

/// A drawn solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Silhouette, m.
    pub outline: Vec<Vec2>,
    /// Shaded facets on it, back to front; the bands of a round solid, [`BANDS`] of them, from its dark
    /// edge to its highlight.
    pub facets: Vec<Facet>,
    /// Whether it is round: a ball or a capsule.
    pub round: bool,
    /// Distance of its middle towards the viewer, m.
    pub near: f64,
}

/// Corners of a pictured circle.
const ROUND: usize = 28;
/// Steps of brightness on a round solid.
pub const BANDS: usize = 6;

/// Draws one shape of a link in the colour `tint`.
pub fn solid(shape: &Shape, world_from_link: &Transform, camera: &Camera, tint: Color) -> Solid {
    match *shape {
        Shape::Capsule { a, b, radius } => {
            round(&[place(world_from_link, &a), place(world_from_link, &b)], radius, camera, tint)
        }
        Shape::Sphere { center, radius } => round(&[place(world_from_link, &center)], radius, camera, tint),
        Shape::Box { .. } => cuboid(shape, world_from_link, camera, tint),
        Shape::Cone { .. } => cone(shape, world_from_link, camera, tint),
    }
}

/// Skin over two round solids: the hull of both, band by band; `None` unless both are round.
pub fn skin(a: &Solid, b: &Solid) -> Option<Solid> {
    let over = |p: &[Vec2], q: &[Vec2]| Support::of_plane([p, q].concat()).corners().to_vec();
    let band = |(f, g): (&Facet, &Facet)| Facet { points: over(&f.points, &g.points), color: f.color };
    (a.round && b.round).then(|| Solid {
        outline: over(&a.outline, &b.outline),
        facets: a.facets.iter().zip(&b.facets).map(band).collect(),
        round: true,
        near: 0.5 * (a.near + b.near),
    })
}

/// World points whose hull is the shape (round ones sampled).
pub fn hull_points(shape: &Shape, world_from_link: &Transform) -> Vec<Vec3> {
    let around = |center: Vec3, radius: f64, out: &mut Vec<Vec3>| {
        for i in 0..12 {
            let (s, c) = (f64::from(i) * std::f64::consts::TAU / 12.0).sin_cos();
            for tilt in [-1.0f64, -0.5, 0.0, 0.5, 1.0] {
                let (st, ct) = (tilt * std::f64::consts::FRAC_PI_2).sin_cos();
                out.push(center + Vec3::new(c * ct, st, s * ct) * radius);
            }
        }
    };
    let mut out = Vec::new();
    match *shape {
        Shape::Capsule { a, b, radius } => {
            around(place(world_from_link, &a), radius, &mut out);
            around(place(world_from_link, &b), radius, &mut out);
        }
        Shape::Sphere { center, radius } => around(place(world_from_link, &center), radius, &mut out),
        Shape::Box { center, half, rotation } => {
            for i in 0..8 {
                let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let corner = Vec3::new(sign(0) * half.x, sign(1) * half.y, sign(2) * half.z);
                out.push(place(world_from_link, &(center + rotation * corner)));
            }
        }
        Shape::Cone { .. } => out.extend(shape.rims().iter().map(|p| place(world_from_link, p))),
    }
    out
}

/// Shadow of a shape on a floor, pictured.
pub fn shadow(shape: &Shape, world_from_link: &Transform, camera: &Camera, floor: &Floor) -> Vec<Vec2> {
    // light comes down from the viewer's upper left: shadows fall a little to the right and back
    let side = camera.near().cross(&Vec3::y()).normalize();
    let back = Vec3::y().cross(&side).normalize();
    let slope = -side * 0.16 + back * 0.10;
    let fallen = hull_points(shape, world_from_link).into_iter().map(|p| {
        let height = (p.y - floor.under(&p).y).max(0.0);
        flat(&camera.project(&floor.under(&(p + slope * height))))
    });
    Support::of_plane(fallen.collect()).corners().to_vec()
}

/// Convex hull of discs of one radius about `centers`: a ball or a capsule.
fn round(centers: &[Vec3], radius: f64, camera: &Camera, tint: Color) -> Solid {
    let seen: Vec<Vec3> = centers.iter().map(|c| camera.project(c)).collect();
    let near = seen.iter().map(|c| c.z).sum::<f64>() / seen.len() as f64;
    let disc = |radius: f64, shift: Vec2| {
        let points = seen.iter().flat_map(|c| {
            (0..ROUND).map(move |i| {
                let (s, co) = (i as f64 * std::f64::consts::TAU / ROUND as f64).sin_cos();
                flat(c) + shift + Vec2::new(co, s) * radius
            })
        });
        Support::of_plane(points.collect()).corners().to_vec()
    };
    let light = Vec2::new(-0.55, 0.65);
    // Bands of equal brightness of a lit cylinder, nested towards the light.
    let bands: [_; BANDS] = [
        (1.0, 0.0, tint.mix(INK, 0.20)),
        (0.92, 0.06, tint.mix(INK, 0.10)),
        (0.80, 0.14, tint),
        (0.62, 0.26, tint.mix(WHITE, 0.08)),
        (0.42, 0.38, tint.mix(WHITE, 0.16)),
        (0.22, 0.48, tint.mix(WHITE, 0.24)),
    ];
    let facets = bands
        .into_iter()
        .map(|(size, shift, color)| Facet { points: disc(radius * size, light * (radius * shift)), color })
        .collect();
    Solid { outline: disc(radius, Vec2::zeros()), facets, round: true, near }
}

/// The side in flat strips and the end that faces the viewer.
fn cone(shape: &Shape, world_from_link: &Transform, camera: &Camera, tint: Color) -> Solid {
    let corners: Vec<Vec3> = hull_points(shape, world_from_link).iter().map(|p| camera.project(p)).collect();
    let near = corners.iter().map(|c| c.z).sum::<f64>() / corners.len() as f64;
    let count = corners.len() / 2;
    let (a, b) = corners.split_at(count);
    let middle = |rim: &[Vec3]| rim.iter().sum::<Vec3>() / count as f64;
    let axis = middle(b) - middle(a);
    let mut facets = Vec::new();
    let mut face = |points: Vec<Vec3>, normal: Vec3| {
        if normal.z > 0.0 {
            facets.push(Facet { points: points.iter().map(flat).collect(), color: lit(&normal, tint) });
        }
    };
    for k in 0..count {
        let next = (k + 1) % count;
        // the longer rim edge: the other may shrink to a point
        let edge =
            if (a[next] - a[k]).norm() > (b[next] - b[k]).norm() { a[next] - a[k] } else { b[next] - b[k] };
        face(vec![a[k], a[next], b[next], b[k]], edge.cross(&(b[k] - a[k])));
    }
    face(a.to_vec(), -axis);
    face(b.to_vec(), axis);
    let outline = Support::of_plane(corners.iter().map(flat).collect()).corners().to_vec();
    Solid { outline, facets, round: false, near }
}

/// The colour of a flat face with this outward normal, in picture coordinates.
fn lit(normal: &Vec3, tint: Color) -> Color {
    let bright = normal.normalize().dot(&Vec3::new(-0.45, 0.75, 0.5).normalize());
    match bright > 0.5 {
        true => tint.mix(WHITE, 0.4 * (bright - 0.5)),
        false => tint.mix(INK, 0.4 * (0.5 - bright)),
    }
}

fn cuboid(shape: &Shape, world_from_link: &Transform, camera: &Camera, tint: Color) -> Solid {
    let corners: Vec<Vec3> = hull_points(shape, world_from_link).iter().map(|p| camera.project(p)).collect();
    let near = corners.iter().map(|c| c.z).sum::<f64>() / 8.0;
    let mut facets = Vec::new();
    for axis in 0..3 {
        for side in 0..2 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let at = |a: usize, b: usize| corners[side << axis | a << u | b << v];
            let face = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            let opposite = corners[(1 - side) << axis];
            let mut normal = (face[1] - face[0]).cross(&(face[3] - face[0]));
            if normal.dot(&(face[0] - opposite)) < 0.0 {
                normal = -normal;
            }
            if normal.z <= 0.0 {
                continue;
            }
            facets.push(Facet { points: face.iter().map(flat).collect(), color: lit(&normal, tint) });
        }
    }
    let outline = Support::of_plane(corners.iter().map(flat).collect()).corners().to_vec();
    Solid { outline, facets, round: false, near }
}

/// The polygon grown by `by` on all sides; for convex outlines.
pub fn grown(outline: &[Vec2], by: f64) -> Vec<Vec2> {
    let around = |p: &Vec2| {
        let p = *p;
        (0..12).map(move |i| {
            let (s, c) = (f64::from(i) * std::f64::consts::TAU / 12.0).sin_cos();
            p + Vec2::new(c, s) * by
        })
    };
    Support::of_plane(outline.iter().flat_map(around).collect()).corners().to_vec()
}

fn place(world_from_link: &Transform, p: &Vec3) -> Vec3 {
    (world_from_link * nalgebra::Point3::from(*p)).coords
}

/// A point seen, without its distance.
pub fn flat(p: &Vec3) -> Vec2 {
    Vec2::new(p.x, p.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::rotation::exp;

    fn samples() -> Vec<Shape> {
        vec![
            Shape::Capsule { a: Vec3::new(0.1, 0.0, 0.2), b: Vec3::new(-0.1, 0.5, 0.0), radius: 0.07 },
            Shape::Sphere { center: Vec3::new(0.0, 0.1, 0.3), radius: 0.12 },
            Shape::Box {
                center: Vec3::new(0.05, -0.1, 0.0),
                half: Vec3::new(0.05, 0.03, 0.13),
                rotation: exp(&Vec3::new(0.3, -0.2, 0.5)),
            },
            Shape::Cone {
                a: Vec3::new(0.1, -0.1, 0.0),
                b: Vec3::new(0.0, 0.2, 0.1),
                radius_a: 0.12,
                radius_b: 0.04,
            },
        ]
    }

    /// No point of the solid is drawn outside its silhouette. The silhouette is a polygon of 28 corners
    /// per circle, 0.63 % of the radius inside it at worst.
    #[test]
    fn silhouette_contains_the_solid() {
        let world = Transform::from_parts([0.4, 1.0, -0.3].into(), exp(&Vec3::new(0.2, 1.1, -0.4)));
        for yaw in [0.0, 0.7, 1.57, 3.9] {
            let camera = Camera::new(yaw, 0.17);
            for shape in samples() {
                let drawn = solid(&shape, &world, &camera, INK);
                let outline = Support::of_plane(drawn.outline.clone());
                for p in hull_points(&shape, &world) {
                    let margin = outline.margin(&flat(&camera.project(&p)));
                    assert!(margin > -0.0063 * 0.12, "{shape:?}: {margin}");
                }
                for facet in &drawn.facets {
                    for p in &facet.points {
                        assert!(outline.margin(p) > -0.0063 * 0.12, "{shape:?}");
                    }
                }
            }
        }
    }

    /// A silhouette without its radius does not contain the solid: the test above can fail.
    #[test]
    fn bare_bones_do_not_contain_the_solid() {
        let camera = Camera::new(0.3, 0.1);
        let world = Transform::identity();
        let Shape::Capsule { a, b, .. } = samples()[0] else { unreachable!() };
        let bone = Support::of_plane(vec![flat(&camera.project(&a)), flat(&camera.project(&b))]);
        let points = hull_points(&samples()[0], &world);
        assert!(points.iter().any(|p| bone.margin(&flat(&camera.project(p))) < -0.06));
    }

    /// The shadow of a body on the ground is under it: a ball of radius 0.1 that rests on the plane has a
    /// shadow on the plane.
    #[test]
    fn shadow_lies_on_the_ground() {
        let camera = Camera::new(0.5, 0.2);
        let ball = Shape::Sphere { center: Vec3::new(1.0, 0.1, 2.0), radius: 0.1 };
        let shade =
            Support::of_plane(shadow(&ball, &Transform::identity(), &camera, &Floor::level(0.0, 0.0)));
        let touch = flat(&camera.project(&Vec3::new(1.0, 0.0, 2.0)));
        assert!(shade.contains(&touch));
        // on a slope too
        let slope = Floor { up: Vec3::new(0.1, 1.0, -0.2).normalize(), ..Floor::level(0.3, 0.0) };
        let touch = slope.under(&Vec3::new(1.0, 0.0, 2.0));
        assert!((touch - Vec3::y() * 0.3).dot(&slope.up).abs() < 1e-12);
        let ball = Shape::Sphere { center: touch + slope.up * 0.1, radius: 0.1 };
        let shade = Support::of_plane(shadow(&ball, &Transform::identity(), &camera, &slope));
        assert!(shade.contains(&flat(&camera.project(&touch))));
    }
}
