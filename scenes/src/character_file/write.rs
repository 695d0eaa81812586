//! Writing: rounded numbers, one value per line where a person would change it.

use std::fmt::Write as _;

use bodies::Character;
use motion::names::Word;
use motion::{Joint, Limits, Link, Range, Shape, Vec3};

use crate::angle::deg_from_quat;

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
        let [upper, lower, end] = l.links().map(|i| &links[i].name);
        let _ = writeln!(
            out,
            "        Limb(name: {:?}, kind: {}, upper: {upper:?}, lower: {lower:?}, end: {end:?}),",
            l.name,
            l.kind.identifier()
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
    line(format!("{head}, joint: {joint}, class: {}", c.classes[i].identifier()));
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
        Shape::Cone { a, b, radius_a, radius_b } => {
            let [ra, rb] = [radius_a, radius_b].map(|r| num(*r, 6));
            format!("Cone(a_m: {}, b_m: {}, radius_a_m: {ra}, radius_b_m: {rb})", p(a), p(b))
        }
    }
}
