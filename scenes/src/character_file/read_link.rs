//! Reading of one link: joint, limits, mass, shapes.
//!
//! In: a link as written, in metres, kilograms and degrees. Out: [`Link`] and [`Body`], or an error at the very value.

use bodies::Body;
use motion::{BallLimits, Joint, Limits, Link, Range, Shape, Transform, Vec3};
use nalgebra::{Matrix3, Translation3};

use super::read::{Reader, vec3};
use super::schema::{JointRon, LimitsRon, ShapeRon, V3};
use crate::angle::quat_from_deg;
use crate::error::SceneError;

impl Reader<'_> {
    /// Link `i` as written, whose parent has index `parent`.
    pub(super) fn link(&self, i: usize, parent: Option<usize>) -> Result<Link, SceneError> {
        let (s, l) = (self.source, &self.ron.links[i]);
        let at = |field: &str| format!("links[{i}].{field}");
        let axis = |x, y, z| -> Result<Vec3, SceneError> {
            let v = self.finite(&at("joint"), (x, y, z))?;
            match v.norm() {
                n if n > 1e-6 => Ok(v / n),
                _ => Err(s.error(
                    &at("joint"),
                    format!("the joint axis of `{}` is zero; it needs a direction", l.name),
                )),
            }
        };
        let joint = match l.joint {
            JointRon::Free => Joint::Free,
            JointRon::Ball => Joint::Spherical,
            JointRon::Hinge(x, y, z) => Joint::Revolute(axis(x, y, z)?),
            JointRon::Slide(x, y, z) => Joint::Prismatic(axis(x, y, z)?),
            JointRon::Fixed => Joint::Fixed,
        };
        let turn = self.finite(&at("rotation_deg"), l.rotation_deg)?;
        let mut link = Link::new(&l.name, parent, self.finite(&at("offset_m"), l.offset_m)?, joint);
        if turn != Vec3::zeros() {
            let t = link.parent_from_zero.translation.vector;
            link.parent_from_zero = Transform::from_parts(Translation3::from(t), quat_from_deg(turn.into()));
        }
        link.end = l.end_m.map(|e| self.finite(&at("end_m"), e)).transpose()?;
        link.limits = self.limits(i, joint)?;
        Ok(link)
    }

    fn limits(&self, i: usize, joint: Joint) -> Result<Option<Limits>, SceneError> {
        let (s, l) = (self.source, &self.ron.links[i]);
        let range = |field: &str, (lo, hi): (f64, f64), unit: &str, bound: f64| {
            if lo < hi && lo >= -bound && hi <= bound {
                Ok(Range::new(lo, hi))
            } else {
                let e = format!(
                    "the limits of `{}` run from {lo}{unit} to {hi}{unit}; the lower must be below the upper, both within ±{bound}{unit}",
                    l.name
                );
                Err(s.error(&format!("links[{i}].{field}"), e))
            }
        };
        let deg = |r: Range| Range::new(r.lo.to_radians(), r.hi.to_radians());
        Ok(match (&l.limits_deg, l.limits_m, joint) {
            (None, None, _) => None,
            (Some(LimitsRon::Hinge(lo, hi)), None, Joint::Revolute(_)) => {
                Some(Limits::Axis(deg(range("limits_deg", (*lo, *hi), "°", 36000.0)?)))
            }
            (None, Some(r), Joint::Prismatic(_)) => Some(Limits::Axis(range("limits_m", r, " m", 1000.0)?)),
            (Some(LimitsRon::Ball { axes, swing_1, swing_2, twist }), None, Joint::Spherical) => {
                let at = |f: &str| format!("limits_deg.{f}");
                Some(Limits::Ball(BallLimits {
                    axes: self.axes(i, axes)?,
                    ranges: [
                        deg(range(&at("swing_1"), *swing_1, "°", 180.0)?),
                        deg(range(&at("swing_2"), *swing_2, "°", 180.0)?),
                        deg(range(&at("twist"), *twist, "°", 180.0)?),
                    ],
                }))
            }
            _ => {
                let field = if l.limits_m.is_some() { "limits_m" } else { "limits_deg" };
                let e = format!(
                    "the limits of `{}` do not fit its joint: a Hinge takes limits_deg: Hinge(lo, hi), a Ball takes limits_deg: Ball(…), a Slide takes limits_m: (lo, hi), others none",
                    l.name
                );
                return Err(s.error(&format!("links[{i}].{field}"), e));
            }
        })
    }

    /// Orthonormal axes; what rounding left in the text is taken out, the twist axis staying.
    fn axes(&self, i: usize, axes: &(V3, V3, V3)) -> Result<[Vec3; 3], SceneError> {
        let at = format!("links[{i}].limits_deg.axes");
        let mut a = [Vec3::zeros(); 3];
        for (k, v) in [axes.0, axes.1, axes.2].into_iter().enumerate() {
            a[k] = self.finite(&format!("{at}[{k}]"), v)?;
        }
        let off = (0..3)
            .flat_map(|j| (0..3).map(move |k| (j, k)))
            .map(|(j, k)| (a[j].dot(&a[k]) - if j == k { 1.0 } else { 0.0 }).abs());
        if off.fold(0.0, f64::max) > 1e-3 {
            let name = &self.ron.links[i].name;
            let e = format!("the limit axes of `{name}` are not three unit vectors at right angles");
            return Err(self.source.error(&at, e));
        }
        let z = a[2].normalize();
        let x = (a[0] - z * a[0].dot(&z)).normalize();
        let y = z.cross(&x);
        Ok([x, if y.dot(&a[1]) < 0.0 { -y } else { y }, z])
    }

    /// Mass and shapes of link `i` as written.
    pub(super) fn body(&self, i: usize) -> Result<Body, SceneError> {
        let (s, l) = (self.source, &self.ron.links[i]);
        let at = |field: &str| format!("links[{i}].{field}");
        let mut shapes = Vec::new();
        for (k, shape) in l.shapes.iter().enumerate() {
            shapes.push(self.shape(&at(&format!("shapes[{k}]")), *shape)?);
        }
        if let Some(density) = l.density_kg_m3 {
            return self.weighed(i, shapes, density);
        }
        let mass = l.mass_kg.unwrap_or_default();
        if !(mass >= 0.0 && mass.is_finite()) {
            let e = format!("link `{}` has a mass of {mass} kg; it must be positive and finite", l.name);
            return Err(s.error(&at("mass_kg"), e));
        }
        let (xx, yy, zz, xy, xz, yz) = l.inertia_kg_m2.unwrap_or_default();
        if ![xx, yy, zz, xy, xz, yz].iter().all(|x| x.is_finite()) {
            let e = format!("the inertia of `{}` is not finite", l.name);
            return Err(s.error(&at("inertia_kg_m2"), e));
        }
        Ok(Body {
            mass,
            com: self.finite(&at("com_m"), l.com_m.unwrap_or_default())?,
            inertia: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            shapes,
        })
    }

    /// The body that solids of one density make.
    fn weighed(&self, i: usize, shapes: Vec<Shape>, density: f64) -> Result<Body, SceneError> {
        let l = &self.ron.links[i];
        let at = |field: &str| format!("links[{i}].{field}");
        let given = [
            ("mass_kg", l.mass_kg.is_some()),
            ("com_m", l.com_m.is_some()),
            ("inertia_kg_m2", l.inertia_kg_m2.is_some()),
        ];
        if let Some((field, _)) = given.into_iter().find(|(_, is)| *is) {
            let e = format!(
                "link `{}` has both density_kg_m3 and {field}; mass, centre and inertia follow from the density and the shapes",
                l.name
            );
            return Err(self.source.error(&at(field), e));
        }
        if !(1e-3..=1e6).contains(&density) {
            let e = format!("link `{}` has a density of {density} kg/m³; allowed: 0.001 to 1000000", l.name);
            return Err(self.source.error(&at("density_kg_m3"), e));
        }
        if shapes.is_empty() {
            let e = format!("link `{}` has a density but no shapes to fill with it", l.name);
            return Err(self.source.error(&at("density_kg_m3"), e));
        }
        Ok(bodies::density::body(shapes, density))
    }

    fn shape(&self, at: &str, shape: ShapeRon) -> Result<Shape, SceneError> {
        let size = |field: &str, x: f64| {
            if x > 0.0 && x.is_finite() {
                return Ok(x);
            }
            let e = format!("a {field} of {x} m; sizes must be positive and finite");
            Err(self.source.error(&format!("{at}.{field}"), e))
        };
        let point = |field: &str, v: V3| self.finite(&format!("{at}.{field}"), v);
        Ok(match shape {
            ShapeRon::Capsule { a_m, b_m, radius_m } => Shape::Capsule {
                a: point("a_m", a_m)?,
                b: point("b_m", b_m)?,
                radius: size("radius_m", radius_m)?,
            },
            ShapeRon::Box { center_m, half_m, rotation_deg } => {
                for x in [half_m.0, half_m.1, half_m.2] {
                    size("half_m", x)?;
                }
                let turn = point("rotation_deg", rotation_deg)?;
                Shape::Box {
                    center: point("center_m", center_m)?,
                    half: vec3(half_m),
                    rotation: quat_from_deg(turn.into()),
                }
            }
            ShapeRon::Cone { a_m, b_m, radius_a_m, radius_b_m } => {
                let (a, b) = (point("a_m", a_m)?, point("b_m", b_m)?);
                if (b - a).norm() < 1e-6 {
                    let e = "the ends of a cone are at one place; it needs a length";
                    return Err(self.source.error(&format!("{at}.b_m"), e));
                }
                Shape::Cone {
                    a,
                    b,
                    radius_a: size("radius_a_m", radius_a_m)?,
                    radius_b: size("radius_b_m", radius_b_m)?,
                }
            }
            ShapeRon::Sphere { center_m, radius_m } => {
                Shape::Sphere { center: point("center_m", center_m)?, radius: size("radius_m", radius_m)? }
            }
        })
    }
}
