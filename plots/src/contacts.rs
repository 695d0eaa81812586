//! Contact forces per foot and in total, against body weight.
//!
//! In: a [`Trace`](dynamics::Trace). Out: a page with vertical force, horizontal force and friction used over time. Forces
//! are means over a control step; a foot is every link at or below the end of a leg.

use motion::Vec3;

use crate::angles::label_time;
use crate::columns::{WIDTH, empty_page, mark_times, rows, weight};
use crate::excerpt::Excerpt;
use crate::figure::Figure;
use crate::gains::zero;
use crate::panel::{Guide, Key, Panel, Series, Stroke, page};
use crate::style::{BLUE, Color, GREEN, INK, PURPLE, REFERENCE, VERMILION};

/// Share of body weight from which the friction of a foot is worth a number.
const LOADED: f64 = 0.05;

/// Vertical and horizontal ground forces per foot and in total.
pub fn contact_forces<'a>(trace: impl Into<Excerpt<'a>>, note: &str) -> Figure {
    let trace = &trace.into();
    let title = "Contact forces";
    let rows = rows(trace);
    if trace.ground_m.is_none() {
        let why = "this trace has no ground: nothing touches the body, the root is held from outside";
        return empty_page(title, note, why);
    }
    if rows == 0 || !trace.contacts.iter().any(|c| c.row < rows && c.against.is_world()) {
        return empty_page(title, note, "no contact in this trace: the body never touches the ground");
    }
    let weight = weight(trace);
    let parts = parts(trace, rows);
    let mut total = vec![Vec3::zeros(); rows];
    for c in trace.contacts.iter().filter(|c| c.row < rows && c.against.is_world()) {
        total[c.row] += c.force;
    }
    let all = |f: fn(&Vec3) -> f64, with_total: bool| -> Vec<Series> {
        let sum = with_total && parts.len() > 1;
        let of = |forces: &[Vec3], color| Series::over_time(trace.clock(), after_start(forces, f), color);
        let sum = sum.then(|| of(&total, INK).wide(1.3));
        sum.into_iter().chain(parts.iter().map(|p| of(&p.forces, p.color))).collect()
    };
    let horizontal = |f: &Vec3| f.x.hypot(f.z);
    let friction = parts.iter().map(|p| {
        let used = |(row, f): (usize, &Vec3)| {
            let up = trace.ground_up(row);
            let normal = f.dot(&up);
            if normal > LOADED * weight { (f - up * normal).norm() / normal } else { f64::NAN }
        };
        let all = std::iter::once(f64::NAN).chain(p.forces.iter().enumerate().skip(1).map(used));
        Series::over_time(trace.clock(), all, p.color)
    });
    let mean = total[1.min(rows)..].iter().map(|f| f.y).sum::<f64>() / rows.saturating_sub(1).max(1) as f64;
    let mut panels = [
        Panel {
            title: format!("vertical · mean {mean:.0} N, body weight {weight:.0} N"),
            y_label: "N".into(),
            series: all(|f| f.y, true),
            guides: vec![
                zero(true),
                Guide { y: weight, color: REFERENCE, stroke: Stroke::Dashed, always: true },
            ],
            least_span: 10.0,
            ..Panel::default()
        },
        Panel {
            title: "horizontal, magnitude".into(),
            y_label: "N".into(),
            series: all(horizontal, true),
            guides: vec![zero(true)],
            least_span: 10.0,
            ..Panel::default()
        },
        Panel {
            title: "friction used: along the ground over normal to it, while over 5 % of body weight".into(),
            y_label: "ratio".into(),
            series: friction.collect(),
            guides: vec![zero(true)],
            least_span: 0.1,
            ..Panel::default()
        },
    ];
    label_time(&mut panels, 1);
    let mut keys: Vec<Key> = parts.iter().map(|p| Key::line(&p.name, p.color)).collect();
    if parts.len() > 1 {
        keys.push(Key::line("total", INK));
    }
    keys.push(Key::dashed("body weight", REFERENCE));
    mark_times(trace, &mut panels, &mut keys);
    page(title, note, &keys, &panels, 1, WIDTH, 200.0)
}

/// One number per row; the first row is the start, before any force.
fn after_start<'a>(forces: &'a [Vec3], f: impl Fn(&Vec3) -> f64 + 'a) -> impl Iterator<Item = f64> + 'a {
    std::iter::once(f64::NAN).chain(forces.iter().skip(1).map(f))
}

/// What stands on the ground.
struct Part {
    name: String,
    color: Color,
    forces: Vec<Vec3>,
}

/// Feet first, then whatever else touched, most pressed first; the fourth on are one.
fn parts(trace: &Excerpt, rows: usize) -> Vec<Part> {
    let skeleton = &trace.character.skeleton;
    let links = skeleton.links();
    let owner: Vec<usize> = (0..links.len())
        .map(|link| {
            let foot = |&u: &usize| trace.character.legs().any(|leg| leg.end == u);
            skeleton.ancestors(link).find(foot).unwrap_or(link)
        })
        .collect();
    let mut pressed: Vec<(usize, f64)> = Vec::new();
    let loads = |c: &&dynamics::ContactSample| c.row < rows && c.link < links.len() && c.against.is_world();
    for c in trace.contacts.iter().filter(loads) {
        let part = owner[c.link];
        match pressed.iter_mut().find(|p| p.0 == part) {
            Some(p) => p.1 += c.force.y.abs(),
            None => pressed.push((part, c.force.y.abs())),
        }
    }
    let foot = |part: usize| trace.character.legs().any(|leg| leg.end == part);
    // feet first, in the order of the skeleton, so that each has the same colour in every run; other parts by their load
    pressed.sort_by(|a, b| match (foot(a.0), foot(b.0)) {
        (true, true) => a.0.cmp(&b.0),
        (false, false) => b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)),
        (x, y) => y.cmp(&x),
    });
    let colors = [BLUE, VERMILION, GREEN, PURPLE];
    let mut out: Vec<Part> = Vec::new();
    let mut index = vec![None; links.len()];
    for (i, (part, _)) in pressed.iter().enumerate() {
        let last = colors.len() - 1;
        if i > last {
            out[last].name = format!("{} other links", pressed.len() - last);
        } else {
            let (name, color) = (links[*part].name.clone(), colors[i]);
            out.push(Part { name, color, forces: vec![Vec3::zeros(); rows] });
        }
        index[*part] = Some(i.min(last));
    }
    let loads = |c: &&dynamics::ContactSample| c.row < rows && c.link < links.len() && c.against.is_world();
    for c in trace.contacts.iter().filter(loads) {
        if let Some(i) = index[owner[c.link]] {
            out[i].forces[c.row] += c.force;
        }
    }
    out
}
