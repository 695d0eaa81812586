//! Centre of mass over the support.
//!
//! In: a [`Trace`](dynamics::Trace). Out: a page with the paths of the centre of mass and of the centre of pressure seen
//! from above, over the hull of the points that carry the body at the start; beside it the margin of the
//! centre of mass in the support of each moment, and its height.
//!
//! Seen from above with forward (+z) up, the character's left (+x) is on the left: the horizontal axis
//! is −x. The margin is that of [`motion::Support`]: positive inside, negative outside.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use motion::support::{Vec2, ground};
use motion::{Kinematics, Support, Vec3};

use crate::columns::{TIME, WIDTH, empty_page, mark_times, rows, vectors, weight};
use crate::excerpt::Excerpt;
use crate::figure::Figure;
use crate::gains::zero;
use crate::panel::{Key, Panel, Series, Stroke, header, place};
use crate::style::{self, BLUE, Color, GRID, INK, MARGIN, VERMILION};

/// Share of body weight from which the centre of pressure is worth a point.
const LOADED: f64 = 0.05;
/// Height over the ground up to which a contact point counts as standing when no force tells, m.
const STANDING: f64 = 0.03;
/// Footprints drawn.
const MOST_PRINTS: usize = 200;
const SOLE: Color = Color(202, 209, 217);

/// Centre of mass and centre of pressure over the support, margin and height over time.
pub fn center_of_mass<'a>(trace: impl Into<Excerpt<'a>>, note: &str) -> Figure {
    let trace = &trace.into();
    let title = "Centre of mass and support";
    let com = vectors(&trace.com, 3, 0);
    let rows = rows(trace).min(com.len());
    if rows == 0 {
        return empty_page(title, note, "the trace has no rows");
    }
    let supports = supports(trace, rows);
    let mut keys = vec![
        Key::line("centre of mass", BLUE),
        Key::line("centre of pressure", VERMILION),
        Key::area("support at the start", GRID),
        Key::area("each foot, each time it stands", SOLE),
        Key::dot("start", INK),
    ];
    let mut over_time = [margin(trace, &com[..rows], &supports), com_height(trace, &com[..rows])];
    mark_times(trace, &mut over_time, &mut keys);
    let (width, height, gap) = (WIDTH, 620.0, 24.0);
    let top = header(&mut Figure::new(width, 100.0), title, note, &keys);
    let mut figure = Figure::new(width, top + height + 0.6 * MARGIN);
    header(&mut figure, title, note, &keys);
    let left = 0.46 * (width - 2.0 * MARGIN);
    place(&mut figure, &from_above(trace, &com[..rows]), [MARGIN, top], [left, height]);
    let x = MARGIN + left + gap;
    let half = 0.5 * (height - 12.0);
    let size = [width - MARGIN - x, half];
    place(&mut figure, &over_time[0], [x, top], size);
    place(&mut figure, &over_time[1], [x, top + half + 12.0], size);
    figure
}

/// On the page: right is −x, up is z, cm.
fn seen(p: &Vec2) -> [f64; 2] {
    [-100.0 * p.x, 100.0 * p.y]
}

fn from_above(trace: &Excerpt, com: &[Vec3]) -> Panel {
    let path: Vec<[f64; 2]> = com.iter().map(|p| seen(&ground(p))).collect();
    let weight = weight(trace);
    let mut load = vec![0.0; com.len()];
    for c in trace.contacts.iter().filter(|c| c.row < com.len() && c.against.is_world()) {
        load[c.row] += c.force.y;
    }
    let pressure: Vec<[f64; 2]> = (0..com.len())
        .map(|row| match trace.cop(row) {
            Some(p) if load[row] > LOADED * weight => seen(&ground(&p)),
            _ => [f64::NAN; 2],
        })
        .collect();
    let (whole, feet) = supports_and_footprints(trace);
    let corners = |s: &Support| -> Vec<[f64; 2]> { s.corners().iter().map(seen).collect() };
    let mut areas = vec![(corners(&whole), GRID)];
    areas.extend(feet.iter().map(|f| (corners(f), SOLE)));
    areas.retain(|a| a.0.len() > 2);
    let mut dots = Vec::new();
    if let Some(first) = pressure.iter().find(|p| p[0].is_finite()) {
        dots.push((*first, 4.0, VERMILION.mix(INK, 0.35)));
    }
    dots.push((path[0], 4.5, BLUE.mix(INK, 0.35)));
    dots.retain(|d| d.0[0].is_finite() && d.0[1].is_finite());
    let curve = |points, color| Series { points, color, width: style::LINE, stroke: Stroke::Solid };
    Panel {
        title: "from above, forward is up".into(),
        x_label: "to the right, \u{2212}x (cm)".into(),
        y_label: "forward, z (cm)".into(),
        areas,
        series: vec![curve(pressure, VERMILION).wide(1.3), curve(path, BLUE).wide(2.0)],
        dots,
        least_span: 10.0,
        equal: true,
        ..Panel::default()
    }
}

/// Hull of all points that carry the body at the start, and the footprints: of each link that stands, and
/// each time it does, the hull of its points when most of them are down.
fn supports_and_footprints(trace: &Excerpt) -> (Support, Vec<Support>) {
    let Some(first) = trace.contacts.first() else { return standing(trace) };
    let start = trace.contacts.iter().take_while(|c| c.row == first.row).map(|c| &c.point);
    let whole = Support::of(start);
    let mut by_link: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (i, c) in trace.contacts.iter().enumerate() {
        by_link.entry(c.link).or_default().push(i);
    }
    let mut prints = Vec::new();
    for contacts in by_link.values() {
        for stance in contacts.chunk_by(|a, b| trace.contacts[*b].row <= trace.contacts[*a].row + 1) {
            let middle = trace.contacts[stance[stance.len() / 2]].row;
            let rows = stance.chunk_by(|a, b| trace.contacts[*a].row == trace.contacts[*b].row);
            // the row with most points (the whole sole is down); of several the one nearest to the middle of the stance
            let flat = rows.max_by_key(|points| {
                let row = trace.contacts[points[0]].row;
                (points.len(), Reverse(row.abs_diff(middle)))
            });
            let print = flat.unwrap_or_default().iter().map(|i| &trace.contacts[*i]);
            prints.push(Support::of(print.map(|c| &c.point)));
        }
    }
    prints.truncate(MOST_PRINTS);
    (whole, prints)
}

/// Support and footprints of the first pose, where no force tells.
fn standing(trace: &Excerpt) -> (Support, Vec<Support>) {
    let mut points: Vec<(usize, Vec3)> = Vec::new();
    if let Some(level) = trace.ground_m {
        let skeleton = &trace.character.skeleton;
        let kinematics = Kinematics::new(skeleton, trace.pose(0));
        let sites = trace.character.contacts.iter().map(|&c| &skeleton.sites()[c]);
        points.extend(sites.map(|s| (s.link, kinematics.point(s.link, &s.at))));
        points.retain(|p| p.1.y < level + STANDING);
    }
    let mut links: Vec<usize> = points.iter().map(|p| p.0).collect();
    links.sort_unstable();
    links.dedup();
    let of = |link: usize| Support::of(points.iter().filter(|p| p.0 == link).map(|p| &p.1));
    (Support::of(points.iter().map(|p| &p.1)), links.into_iter().map(of).collect())
}

/// Support of each row: the hull of its contacts.
fn supports(trace: &Excerpt, rows: usize) -> Vec<Support> {
    let mut points: Vec<Vec<Vec2>> = vec![Vec::new(); rows];
    for c in trace.contacts.iter().filter(|c| c.row < rows && c.against.is_world()) {
        points[c.row].push(ground(&c.point));
    }
    points.into_iter().map(Support::of_plane).collect()
}

fn margin(trace: &Excerpt, com: &[Vec3], supports: &[Support]) -> Panel {
    let inside = |(p, s): (&Vec3, &Support)| 1e3 * s.margin(&ground(p));
    // without contacts the margin is −∞, and the curve has a gap there
    let values: Vec<f64> = com.iter().zip(supports).map(inside).collect();
    let least = values.iter().copied().filter(|m| m.is_finite()).fold(f64::INFINITY, f64::min);
    let mut panel = Panel {
        title: format!("margin of the centre of mass inside the support · least {} mm", minus(least)),
        y_label: "mm".into(),
        guides: vec![zero(true)],
        least_span: 20.0,
        ..Panel::default()
    };
    if least.is_finite() {
        panel.series = vec![Series::over_time(trace.clock(), values, BLUE)];
    } else {
        panel.title = "margin of the centre of mass inside the support".into();
        panel.message = match trace.ground_m {
            None => "this trace has no ground, so there is no support".into(),
            Some(_) => "nothing touches the ground".into(),
        };
    }
    panel
}

/// Whole millimetres with a true minus sign.
fn minus(mm: f64) -> String {
    format!("{mm:.0}").replace('-', "\u{2212}")
}

fn com_height(trace: &Excerpt, com: &[Vec3]) -> Panel {
    let level = trace.ground_m.unwrap_or(0.0);
    let over = if trace.ground_m.is_some() { "over the ground" } else { "over y = 0" };
    Panel {
        title: format!("height of the centre of mass {over}"),
        x_label: TIME.into(),
        y_label: "cm".into(),
        series: vec![Series::over_time(trace.clock(), com.iter().map(|p| 100.0 * (p.y - level)), BLUE)],
        least_span: 2.0,
        ..Panel::default()
    }
}
