//! Characters as RON.
//!
//! In: a `.ron` file in metres, kilograms and degrees. Out: a checked [`Character`], or a
//! [`SceneError`] at the very value that is wrong. [`write()`] is the inverse, to the digits written.
//!
//! Links may stand in any order and name their parents; inertia is `(xx, yy, zz, xy, xz, yz)` about
//! the centre of mass along the link's axes; rotations are Euler angles `(x, y, z)`, see
//! [`angle`](crate::angle).

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use dynamics::{Body, Character, JointClass};
use motion::{
    BallLimits, Joint, Limb, LimbKind, Limits, Link, Range, Shape, Site, Skeleton, Transform, Vec3,
};
use nalgebra::{Matrix3, Translation3};
use serde::Deserialize;

use crate::angle::{Angle, deg_from_quat, quat_from_deg};
use crate::error::{SceneError, Source};

type V3 = (f64, f64, f64);

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Character")]
struct CharacterRon {
    name: String,
    links: Vec<LinkRon>,
    #[serde(default)]
    sites: Vec<SiteRon>,
    #[serde(default)]
    contacts: Vec<String>,
    #[serde(default)]
    limbs: Vec<LimbRon>,
    #[serde(default)]
    parts: BTreeMap<String, Vec<String>>,
    #[serde(default)]
    rest: RestRon,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Link")]
struct LinkRon {
    name: String,
    parent: Option<String>,
    #[serde(default)]
    offset_m: V3,
    #[serde(default)]
    rotation_deg: V3,
    joint: JointRon,
    limits_deg: Option<LimitsRon>,
    limits_m: Option<(f64, f64)>,
    class: ClassRon,
    #[serde(default)]
    mass_kg: f64,
    #[serde(default)]
    com_m: V3,
    #[serde(default)]
    inertia_kg_m2: (f64, f64, f64, f64, f64, f64),
    #[serde(default)]
    shapes: Vec<ShapeRon>,
    end_m: Option<V3>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename = "joint")]
enum JointRon {
    Free,
    Ball,
    Hinge(f64, f64, f64),
    Slide(f64, f64, f64),
    Fixed,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "limits")]
enum LimitsRon {
    Hinge(f64, f64),
    Ball { axes: (V3, V3, V3), swing_1: (f64, f64), swing_2: (f64, f64), twist: (f64, f64) },
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename = "class")]
enum ClassRon {
    Root,
    Spine,
    Neck,
    Clavicle,
    Shoulder,
    Elbow,
    Wrist,
    Hip,
    Knee,
    Ankle,
    Other,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename = "shape")]
enum ShapeRon {
    Capsule {
        a_m: V3,
        b_m: V3,
        radius_m: f64,
    },
    Box {
        center_m: V3,
        half_m: V3,
        #[serde(default)]
        rotation_deg: V3,
    },
    Sphere {
        center_m: V3,
        radius_m: f64,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Site")]
struct SiteRon {
    name: String,
    link: String,
    at_m: V3,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename = "limb kind")]
enum KindRon {
    Arm,
    Leg,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Limb")]
struct LimbRon {
    name: String,
    kind: KindRon,
    upper: String,
    lower: String,
    end: String,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "Rest")]
struct RestRon {
    #[serde(default)]
    root_m: V3,
    #[serde(default)]
    joints_deg: BTreeMap<String, Angle>,
}

/// Reads a character.
///
/// # Errors
/// Anything wrong with the file, at its place.
pub fn read(path: &Path) -> Result<Character, SceneError> {
    parse(&Source::read(path)?)
}

/// Builds a character from a source.
///
/// # Errors
/// As [`read`].
pub fn parse(source: &Source) -> Result<Character, SceneError> {
    Reader { source, ron: source.parse()? }.character()
}

fn vec3(v: V3) -> Vec3 {
    Vec3::new(v.0, v.1, v.2)
}

struct Reader<'a> {
    source: &'a Source,
    ron: CharacterRon,
}

impl Reader<'_> {
    fn character(&self) -> Result<Character, SceneError> {
        let s = self.source;
        let order = self.order()?;
        let index = |name: &str| order.iter().position(|&i| self.ron.links[i].name == name);
        let find = |at: String, name: &str, within: String| {
            let names = self.ron.links.iter().map(|l| l.name.as_str());
            index(name).ok_or_else(|| s.unknown(&at, "link", name, &within, names))
        };
        let mut links = Vec::new();
        let mut bodies = Vec::new();
        let mut classes = Vec::new();
        for &i in &order {
            let parent = self.ron.links[i].parent.as_deref().and_then(index);
            links.push(self.link(i, parent)?);
            bodies.push(self.body(i)?);
            classes.push(class(self.ron.links[i].class));
        }
        let mut sites = Vec::new();
        for (i, site) in self.ron.sites.iter().enumerate() {
            let link = find(format!("sites[{i}].link"), &site.link, format!(" in Site \"{}\"", site.name))?;
            if self.ron.sites[..i].iter().any(|o| o.name == site.name) {
                let at = format!("sites[{i}].name");
                return Err(
                    s.error(&at, format!("two sites are called `{}`; names must be unique", site.name))
                );
            }
            sites.push(Site {
                name: site.name.clone(),
                link,
                at: self.finite(&format!("sites[{i}].at_m"), site.at_m)?,
            });
        }
        let mut contacts = Vec::new();
        for (i, name) in self.ron.contacts.iter().enumerate() {
            let names = sites.iter().map(|x| x.name.as_str());
            let at = sites.iter().position(|x| x.name == *name);
            contacts.push(
                at.ok_or_else(|| s.unknown(&format!("contacts[{i}]"), "site", name, " in contacts", names))?,
            );
        }
        let mut limbs = Vec::new();
        for (i, l) in self.ron.limbs.iter().enumerate() {
            let link = |what: &str, name: &str| {
                find(format!("limbs[{i}].{what}"), name, format!(" in Limb \"{}\"", l.name))
            };
            limbs.push(Limb {
                name: l.name.clone(),
                kind: match l.kind {
                    KindRon::Arm => LimbKind::Arm,
                    KindRon::Leg => LimbKind::Leg,
                },
                upper: link("upper", &l.upper)?,
                lower: link("lower", &l.lower)?,
                end: link("end", &l.end)?,
            });
        }
        let mut parts = BTreeMap::new();
        for (part, names) in &self.ron.parts {
            let mut members = Vec::new();
            for (k, name) in names.iter().enumerate() {
                members.push(find(
                    format!("parts{{\"{part}\"}}[{k}]"),
                    name,
                    format!(" in part \"{part}\""),
                )?);
            }
            members.sort_unstable();
            parts.insert(part.clone(), members);
        }
        let whole = |e: &dyn std::error::Error| s.error("links", e.to_string());
        let skeleton = Skeleton::new(links)
            .and_then(|x| x.with_sites(sites))
            .and_then(|x| x.with_limbs(limbs))
            .and_then(|x| x.with_parts(parts))
            .map_err(|e| whole(&e))?;
        let rest = self.rest(&skeleton)?;
        let root = &skeleton.links()[0];
        if root.joint == Joint::Free && root.parent_from_zero != Transform::identity() {
            let e = format!(
                "`{}` is a free root: its zero frame is the world's, without offset or rotation",
                root.name
            );
            let help = "place it with root_m and joints_deg in `rest`";
            return Err(s.error(&format!("links[{}]", order[0]), e).with_help(help));
        }
        Character {
            name: self.ron.name.clone(),
            skeleton: Arc::new(skeleton),
            bodies,
            classes,
            contacts,
            rest,
        }
        .check()
        .map_err(|e| self.place(&e))
    }

    /// Indices of the written links, parents first; otherwise in the order written.
    fn order(&self) -> Result<Vec<usize>, SceneError> {
        let (s, links) = (self.source, &self.ron.links);
        if links.is_empty() {
            return Err(s.error("links", "a character needs at least one link"));
        }
        let mut roots = Vec::new();
        for (i, link) in links.iter().enumerate() {
            if let Some(first) = links[..i].iter().position(|l| l.name == link.name) {
                let e = format!("two links are called `{}`; names must be unique", link.name);
                let (line, _) = s.error(&format!("links[{first}].name"), "").place.unwrap_or_default();
                return Err(s
                    .error(&format!("links[{i}].name"), e)
                    .with_help(format!("the first is on line {line}")));
            }
            match &link.parent {
                None => roots.push(i),
                Some(p) if !links.iter().any(|l| l.name == *p) => {
                    let names = links.iter().map(|l| l.name.as_str()).filter(|n| *n != link.name);
                    let within = format!(" in Link \"{}\"", link.name);
                    return Err(s.unknown(&format!("links[{i}].parent"), "parent", p, &within, names));
                }
                Some(_) => {}
            }
        }
        if let [first, second, ..] = roots[..] {
            let e = format!(
                "`{}` has no parent, but `{}` is the root already; only one link may be without a parent",
                links[second].name, links[first].name
            );
            return Err(s.error(&format!("links[{second}]"), e));
        }
        let (mut order, mut done) = (Vec::new(), HashSet::new());
        while order.len() < links.len() {
            let ready = |i: &usize| {
                !done.contains(&links[*i].name) && links[*i].parent.as_ref().is_none_or(|p| done.contains(p))
            };
            match (0..links.len()).find(ready) {
                Some(i) => {
                    done.insert(links[i].name.clone());
                    order.push(i);
                }
                None => return Err(self.cycle(&done)),
            }
        }
        Ok(order)
    }

    /// Names a cycle among the links that could not be placed.
    fn cycle(&self, done: &HashSet<String>) -> SceneError {
        let links = &self.ron.links;
        let parent = |i: usize| {
            links[i].parent.as_ref().and_then(|p| links.iter().position(|l| l.name == *p)).unwrap_or(i)
        };
        let mut i = links.iter().position(|l| !done.contains(&l.name)).unwrap_or(0);
        for _ in 0..links.len() {
            i = parent(i); // after as many steps we are on the cycle
        }
        let (start, mut names) = (i, vec![format!("`{}`", links[i].name)]);
        loop {
            i = parent(i);
            names.push(format!("`{}`", links[i].name));
            if i == start {
                break;
            }
        }
        let e =
            format!("the parents form a circle: {}; one link must be without a parent", names.join(" → "));
        self.source.error(&format!("links[{start}].parent"), e)
    }

    fn finite(&self, at: &str, v: V3) -> Result<Vec3, SceneError> {
        let v = vec3(v);
        match v.iter().position(|x| !x.is_finite()) {
            Some(k) => {
                Err(self.source.error(&format!("{at}[{k}]"), format!("{} is not a finite number", v[k])))
            }
            None => Ok(v),
        }
    }

    fn link(&self, i: usize, parent: Option<usize>) -> Result<Link, SceneError> {
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

    fn body(&self, i: usize) -> Result<Body, SceneError> {
        let (s, l) = (self.source, &self.ron.links[i]);
        let at = |field: &str| format!("links[{i}].{field}");
        if !(l.mass_kg >= 0.0 && l.mass_kg.is_finite()) {
            let e =
                format!("link `{}` has a mass of {} kg; it must be positive and finite", l.name, l.mass_kg);
            return Err(s.error(&at("mass_kg"), e));
        }
        let (xx, yy, zz, xy, xz, yz) = l.inertia_kg_m2;
        if ![xx, yy, zz, xy, xz, yz].iter().all(|x| x.is_finite()) {
            let e = format!("the inertia of `{}` is not finite", l.name);
            return Err(s.error(&at("inertia_kg_m2"), e));
        }
        let mut shapes = Vec::new();
        for (k, shape) in l.shapes.iter().enumerate() {
            shapes.push(self.shape(&at(&format!("shapes[{k}]")), *shape)?);
        }
        Ok(Body {
            mass: l.mass_kg,
            com: self.finite(&at("com_m"), l.com_m)?,
            inertia: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            shapes,
        })
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
            ShapeRon::Sphere { center_m, radius_m } => {
                Shape::Sphere { center: point("center_m", center_m)?, radius: size("radius_m", radius_m)? }
            }
        })
    }

    fn rest(&self, skeleton: &Skeleton) -> Result<Vec<f64>, SceneError> {
        let s = self.source;
        let mut q = skeleton.zero_pose();
        if skeleton.links()[0].joint == Joint::Free {
            skeleton.set_position(&mut q, 0, &self.finite("rest.root_m", self.ron.rest.root_m)?);
        }
        for (name, angle) in &self.ron.rest.joints_deg {
            let at = format!("rest.joints_deg{{\"{name}\"}}");
            let names = skeleton.links().iter().map(|l| l.name.as_str());
            let i = skeleton.link(name).ok_or_else(|| s.unknown(&at, "joint", name, " in rest", names))?;
            let numbers: &[f64] = match angle {
                Angle::One(x) => &[*x],
                Angle::Ball(xyz) => xyz,
            };
            if !numbers.iter().all(|x| x.is_finite()) {
                return Err(s.error(&at, format!("the rest value of `{name}` is not finite")));
            }
            match (angle, skeleton.links()[i].joint) {
                (Angle::One(x), Joint::Revolute(_)) => q[skeleton.q_at(i)] = x.to_radians(),
                (Angle::One(x), Joint::Prismatic(_)) => q[skeleton.q_at(i)] = *x,
                (Angle::Ball(xyz), Joint::Free | Joint::Spherical) => {
                    skeleton.set_rotation(&mut q, i, &quat_from_deg(*xyz));
                }
                (_, joint) => {
                    let wants = match joint {
                        Joint::Revolute(_) => "one angle in degrees",
                        Joint::Prismatic(_) => "one distance in metres",
                        Joint::Free | Joint::Spherical => "(x, y, z) in degrees",
                        Joint::Fixed => "nothing: it is welded",
                    };
                    return Err(s.error(
                        &at,
                        format!("the rest value of `{name}` does not fit its joint, which takes {wants}"),
                    ));
                }
            }
        }
        Ok(q)
    }

    /// Finds the place of a fault of the finished character.
    fn place(&self, e: &dynamics::CharacterError) -> SceneError {
        use dynamics::CharacterError as E;
        let (link, field) = match e {
            E::Mass { link, .. } => (link.as_str(), "mass_kg"),
            E::Inertia { link, .. } => (link.as_str(), "inertia_kg_m2"),
            _ => ("", ""),
        };
        let i = self.ron.links.iter().position(|l| l.name == link);
        let at = i.map_or("links".to_string(), |i| format!("links[{i}].{field}"));
        self.source.error(&at, e.to_string())
    }
}

fn class(c: ClassRon) -> JointClass {
    match c {
        ClassRon::Root => JointClass::Root,
        ClassRon::Spine => JointClass::Spine,
        ClassRon::Neck => JointClass::Neck,
        ClassRon::Clavicle => JointClass::Clavicle,
        ClassRon::Shoulder => JointClass::Shoulder,
        ClassRon::Elbow => JointClass::Elbow,
        ClassRon::Wrist => JointClass::Wrist,
        ClassRon::Hip => JointClass::Hip,
        ClassRon::Knee => JointClass::Knee,
        ClassRon::Ankle => JointClass::Ankle,
        ClassRon::Other => JointClass::Other,
    }
}

/// A number with at most `digits` decimals, without trailing zeros.
fn num(x: f64, digits: usize) -> String {
    let s = format!("{x:.digits$}");
    let s = if s.contains('.') { s.trim_end_matches('0').trim_end_matches('.') } else { &s };
    if s == "-0" { "0".into() } else { s.into() }
}

fn list(v: &[f64], digits: usize) -> String {
    let v: Vec<_> = v.iter().map(|&x| num(x, digits)).collect();
    format!("({})", v.join(", "))
}

/// The character as RON: metres to 1 µm, angles to 1e-6°, masses to 1 mg, inertias to 1e-8 kg·m².
///
/// `comment` lines go to the top, each behind `//`.
pub fn write(c: &Character, comment: &str) -> String {
    // Writing into a String cannot fail.
    let mut out = String::new();
    let links = c.skeleton.links();
    for line in comment.lines() {
        let _ = writeln!(out, "{}", format!("// {line}").trim_end());
    }
    let _ = writeln!(out, "Character(\n    name: {:?},\n    links: [", c.name);
    for (i, link) in links.iter().enumerate() {
        write_link(&mut out, c, i, link);
    }
    out += "    ],\n    sites: [\n";
    for s in c.skeleton.sites() {
        let at = list(s.at.as_slice(), 6);
        let _ =
            writeln!(out, "        Site(name: {:?}, link: {:?}, at_m: {at}),", s.name, links[s.link].name);
    }
    let names: Vec<_> =
        c.contacts.iter().map(|&i| format!("        {:?},\n", c.skeleton.sites()[i].name)).collect();
    let _ = writeln!(
        out,
        "    ],\n    // Points that may touch the ground.\n    contacts: [\n{}    ],\n    limbs: [",
        names.concat()
    );
    for l in c.skeleton.limbs() {
        let [upper, lower, end] = [l.upper, l.lower, l.end].map(|i| &links[i].name);
        let _ = writeln!(
            out,
            "        Limb(name: {:?}, kind: {:?}, upper: {upper:?}, lower: {lower:?}, end: {end:?}),",
            l.name, l.kind
        );
    }
    out += "    ],\n    // Sets of links; each limb is one of its own name.\n    parts: {\n";
    for (name, members) in c.skeleton.parts() {
        if c.skeleton.limb(name).is_none() {
            let members: Vec<_> = members.iter().map(|&i| format!("{:?}", links[i].name)).collect();
            let _ = writeln!(out, "        {name:?}: [{}],", members.join(", "));
        }
    }
    out += "    },\n    // Standing at ease.\n    rest: (\n";
    if links[0].joint == Joint::Free {
        let _ = writeln!(out, "        root_m: {},", list(c.skeleton.position(&c.rest, 0).as_slice(), 9));
    }
    out += "        joints_deg: {\n";
    for (i, link) in links.iter().enumerate() {
        let at = c.skeleton.q_at(i);
        let value = match link.joint {
            Joint::Free | Joint::Spherical => list(&deg_from_quat(&c.skeleton.rotation(&c.rest, i)), 6),
            Joint::Revolute(_) => num(c.rest[at].to_degrees(), 6),
            Joint::Prismatic(_) => num(c.rest[at], 6),
            Joint::Fixed => continue,
        };
        if value != "(0, 0, 0)" && value != "0" {
            let _ = writeln!(out, "            {:?}: {value},", link.name);
        }
    }
    out += "        },\n    ),\n)\n";
    out
}

fn write_link(out: &mut String, c: &Character, i: usize, link: &Link) {
    let (links, body) = (c.skeleton.links(), &c.bodies[i]);
    let mut line = |text: String| *out += &format!("            {text},\n");
    let mut head = format!("name: {:?}", link.name);
    if let Some(p) = link.parent {
        head += &format!(", parent: {:?}", links[p].name);
    }
    let axis = |name: &str, a: Vec3| format!("{name}{}", list(a.as_slice(), 9));
    let joint = match link.joint {
        Joint::Free => "Free".into(),
        Joint::Spherical => "Ball".into(),
        Joint::Revolute(a) => axis("Hinge", a),
        Joint::Prismatic(a) => axis("Slide", a),
        Joint::Fixed => "Fixed".into(),
    };
    line(format!("{head}, joint: {joint}, class: {:?}", c.classes[i]));
    let t = &link.parent_from_zero;
    line(format!("offset_m: {}", list(t.translation.vector.as_slice(), 6)));
    let turn = list(&deg_from_quat(&t.rotation), 6);
    if turn != "(0, 0, 0)" {
        line(format!("rotation_deg: {turn}"));
    }
    let deg = |r: &Range| list(&[r.lo.to_degrees(), r.hi.to_degrees()], 6);
    match &link.limits {
        Some(Limits::Axis(r)) if matches!(link.joint, Joint::Prismatic(_)) => {
            line(format!("limits_m: {}", list(&[r.lo, r.hi], 6)));
        }
        Some(Limits::Axis(r)) => line(format!("limits_deg: Hinge{}", deg(r))),
        Some(Limits::Ball(b)) => {
            let axes = b.axes.map(|a| list(a.as_slice(), 9)).join(", ");
            let [x, y, z] = [0, 1, 2].map(|k| deg(&b.ranges[k]));
            line(format!("limits_deg: Ball(axes: ({axes}), swing_1: {x}, swing_2: {y}, twist: {z})"));
        }
        None => {}
    }
    if body.mass > 0.0 {
        line(format!("mass_kg: {}, com_m: {}", num(body.mass, 6), list(body.com.as_slice(), 6)));
        let m = &body.inertia;
        let six = [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(0, 2)], m[(1, 2)]];
        line(format!("inertia_kg_m2: {}", list(&six, 8)));
    }
    if !body.shapes.is_empty() {
        let shapes: Vec<_> =
            body.shapes.iter().map(|s| format!("                {},\n", shape_text(s))).collect();
        line(format!("shapes: [\n{}            ]", shapes.concat()));
    }
    if let Some(e) = link.end {
        line(format!("end_m: {}", list(e.as_slice(), 6)));
    }
    let start = out.rfind("            name: ").unwrap_or(0);
    out.insert_str(start, "        Link(\n");
    *out += "        ),\n";
}

fn shape_text(shape: &Shape) -> String {
    let p = |v: &Vec3| list(v.as_slice(), 6);
    match shape {
        Shape::Capsule { a, b, radius } => {
            format!("Capsule(a_m: {}, b_m: {}, radius_m: {})", p(a), p(b), num(*radius, 6))
        }
        Shape::Box { center, half, rotation } => {
            let turn = list(&deg_from_quat(rotation), 6);
            let turn = if turn == "(0, 0, 0)" { String::new() } else { format!(", rotation_deg: {turn}") };
            format!("Box(center_m: {}, half_m: {}{turn})", p(center), p(half))
        }
        Shape::Sphere { center, radius } => {
            format!("Sphere(center_m: {}, radius_m: {})", p(center), num(*radius, 6))
        }
    }
}

/// The text of `characters/human.ron`.
pub fn human_text() -> String {
    let (character, _) = dynamics::anthropometry::human::human();
    let comment = "\
The standard figure: 1.75 m, 75 kg, 19 links, 52 degrees of freedom.

Zero pose: upright, facing +Z, arms straight out sideways, palms down, soles flat on height 0 when
the pelvis is at 0.9275 m; every zero frame is parallel to the world (+X is the figure's left, +Y up).
A link is named after its joint. Positive degrees bend elbows and knees.
Masses, centres and inertias: de Leva 1996, Table 4 (men). Lengths: Drillis & Contini 1966. Limits:
Boone & Azen 1979, AAOS 1965, Inman 1944, widened for dance; swing about two axes, twist about the bone.

Made by: cargo run --release -p scenes --example make_human
The rules are in dynamics/src/anthropometry: change them there, not here.";
    write(&character, comment)
}
