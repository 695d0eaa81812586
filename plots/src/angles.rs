//! Joint angles asked for against joint angles performed, as small multiples.
//!
//! In: a [`Trace`](dynamics::Trace). Out: a page with a panel per joint, degrees (slides in cm). Hinges show their
//! angle; limited balls their anatomical coordinates [`BallLimits::coords`]; other balls Euler angles
//! Y, Z, X. Of the many triples that name one rotation, each row shows the one nearest to the row
//! before (for the motion performed: nearest to the one asked for), so that curves do not jump by turns.

use std::f64::consts::{PI, TAU};

use motion::rotation::log;
use motion::{BallLimits, EulerOrder, Joint, Limits, Link, Range, Vec3};

use crate::columns::{TIME, WIDTH, axis_name, empty_page, mark_times, rows};
use crate::excerpt::Excerpt;
use crate::figure::Figure;
use crate::panel::{Clock, Guide, Key, Panel, Series, Stroke, page};
use crate::style::{self, Color, INK, REFERENCE};

/// Joints shown.
const MOST: usize = 12;
/// Distance within which a limit is shown, degrees or cm.
const NEAR: f64 = 12.0;
/// A change between rows that breaks a curve, degrees or cm: a pole of the coordinates, not a motion.
const JUMP: f64 = 60.0;

pub(crate) const COLORS: [Color; 3] = [style::BLUE, style::VERMILION, style::GREEN];

/// Angles of the joints that move most: asked for dashed, performed solid, limits in grey where near.
pub fn joint_angles<'a>(trace: impl Into<Excerpt<'a>>, note: &str) -> Figure {
    let trace = &trace.into();
    let [asked, performed] = trace.names();
    let title = &format!("Joint angles: {asked} and {performed}");
    let rows = rows(trace);
    let mut moving: Vec<(usize, f64)> =
        trace.joints().into_iter().map(|l| (l, travel(trace, l, rows))).collect();
    if rows == 0 || moving.is_empty() {
        let why = if rows == 0 { "the trace has no rows" } else { "the body has no joints" };
        return empty_page(title, note, why);
    }
    let all = moving.len();
    moving.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    moving.truncate(MOST);
    moving.sort_by_key(|m| m.0);
    let shown = match all {
        n if n > MOST => format!("{note} · the {MOST} of {n} joints that move most"),
        _ => note.to_owned(),
    };
    let mut keys = vec![
        Key::line(performed, INK),
        Key::dashed(asked, INK),
        Key::line("limit, in the tint of its curve", REFERENCE),
    ];
    let columns = if moving.len() > 4 { 3 } else { 2 };
    let mut panels: Vec<Panel> = moving.iter().map(|(link, _)| panel(trace, *link, rows)).collect();
    label_time(&mut panels, columns);
    mark_times(trace, &mut panels, &mut keys);
    page(title, &shown, &keys, &panels, columns, WIDTH, 150.0)
}

/// Writes the time's label under the last panel of each column.
pub(crate) fn label_time(panels: &mut [Panel], columns: usize) {
    let first = panels.len().saturating_sub(columns);
    panels[first..].iter_mut().for_each(|p| p.x_label = TIME.to_owned());
}

fn panel(trace: &Excerpt, link: usize, rows: usize) -> Panel {
    let l = &trace.character.skeleton.links()[link];
    let coordinates = Coordinates::of(l);
    let mut asked: Vec<Vec3> = Vec::with_capacity(rows);
    let mut reference = None;
    for row in 0..rows {
        let at = coordinates.nearest(trace, trace.target_pose(row), link, reference);
        if at.iter().all(|x| x.is_finite()) {
            reference = Some(at);
        }
        asked.push(at);
    }
    let performed: Vec<Vec3> =
        (0..rows).map(|row| coordinates.nearest(trace, trace.pose(row), link, Some(asked[row]))).collect();

    let scale = if matches!(l.joint, Joint::Prismatic(_)) { 100.0 } else { 1f64.to_degrees() };
    let names = coordinates.names();
    let mut panel = Panel {
        title: l.name.clone(),
        y_label: if matches!(l.joint, Joint::Prismatic(_)) { "cm" } else { "degrees" }.to_owned(),
        least_span: 6.0,
        degrees: !matches!(l.joint, Joint::Prismatic(_)),
        tags: names.iter().cloned().zip(COLORS).collect(),
        ..Panel::default()
    };
    for (k, color) in COLORS.iter().enumerate().take(names.len()) {
        let curve = |of: &[Vec3], color| {
            let values: Vec<f64> = of.iter().map(|v| v[k] * scale).collect();
            Series {
                points: broken_at_poles(trace.clock(), &values),
                ..Series::over_time(trace.clock(), [], color)
            }
        };
        panel.series.push(curve(&performed, *color));
        panel.series.push(curve(&asked, color.mix(INK, 0.5)).dashed().wide(1.3));
        let Some(range) = coordinates.range(k) else { continue };
        let seen = asked.iter().chain(&performed).map(|v| v[k] * scale);
        let (lo, hi) = seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        for (limit, near) in [(range.lo * scale, lo), (range.hi * scale, hi)] {
            if (near - limit).abs() < NEAR {
                let color = color.mix(REFERENCE, 0.6);
                panel.guides.push(Guide { y: limit, color, stroke: Stroke::Solid, always: true });
            }
        }
    }
    panel
}

/// Points over time, broken where a coordinate passes a pole.
fn broken_at_poles(clock: Clock, values: &[f64]) -> Vec<[f64; 2]> {
    let mut out = Vec::with_capacity(values.len());
    for (i, &y) in values.iter().enumerate() {
        if i > 0 && (y - values[i - 1]).abs() > JUMP {
            out.push([clock.at(i), f64::NAN]);
        }
        out.push([clock.at(i), y]);
    }
    out
}

/// Largest distance from the first pose asked for, rad or m.
fn travel(trace: &Excerpt, link: usize, rows: usize) -> f64 {
    let skeleton = &trace.character.skeleton;
    let at = skeleton.q_at(link);
    let distance = |a: &[f64], b: &[f64]| match skeleton.links()[link].joint {
        Joint::Spherical => log(&(skeleton.rotation(b, link) * skeleton.rotation(a, link).inverse())).norm(),
        _ => (b[at] - a[at]).abs(),
    };
    (0..rows)
        .flat_map(|row| [trace.pose(row), trace.target_pose(row)])
        .map(|pose| distance(trace.target_pose(0), pose))
        .fold(0.0, f64::max)
}

/// What a joint's numbers are called.
enum Coordinates<'a> {
    Hinge(Option<&'a Range>),
    Slide(Option<&'a Range>),
    Ball(&'a BallLimits),
    Euler,
}

impl<'a> Coordinates<'a> {
    fn of(link: &'a Link) -> Self {
        let range = match &link.limits {
            Some(Limits::Axis(r)) => Some(r),
            _ => None,
        };
        match (link.joint, &link.limits) {
            (Joint::Prismatic(_), _) => Self::Slide(range),
            (Joint::Revolute(_), _) => Self::Hinge(range),
            (_, Some(Limits::Ball(limits))) => Self::Ball(limits),
            _ => Self::Euler,
        }
    }

    fn names(&self) -> Vec<String> {
        match self {
            Self::Hinge(_) => vec!["hinge".into()],
            Self::Slide(_) => vec!["slide".into()],
            Self::Ball(limits) => ball_axes(limits),
            Self::Euler => ["Y", "Z", "X"].map(String::from).to_vec(),
        }
    }

    fn range(&self, k: usize) -> Option<Range> {
        match self {
            Self::Hinge(range) | Self::Slide(range) => range.copied(),
            Self::Ball(limits) => Some(limits.ranges[k]),
            Self::Euler => None,
        }
    }

    /// Coordinates of a pose, rad or m: of all that name the same pose, those nearest to `reference`.
    fn nearest(&self, trace: &Excerpt, q: &[f64], link: usize, reference: Option<Vec3>) -> Vec3 {
        let skeleton = &trace.character.skeleton;
        let (first, second) = match self {
            Self::Hinge(_) | Self::Slide(_) => {
                let x = Vec3::new(q[skeleton.q_at(link)], 0.0, 0.0);
                (x, x)
            }
            Self::Ball(limits) => {
                let c = limits.coords(&skeleton.rotation(q, link));
                // a swing by θ about an axis is the same rotation as one by θ − 2π about it: whichever is nearer to the reference is drawn
                let angle = c.x.hypot(c.y);
                let back = if angle > 1e-6 { 1.0 - TAU / angle } else { 1.0 };
                (c, Vec3::new(c.x * back, c.y * back, c.z))
            }
            Self::Euler => {
                let c = EulerOrder::YZX.from_quat(&skeleton.rotation(q, link));
                (c, Vec3::new(c.x + PI, PI - c.y, c.z + PI))
            }
        };
        let Some(reference) = reference.filter(|_| !matches!(self, Self::Slide(_))) else { return first };
        // the two swing coordinates repeat together (that is `second`); twists and single angles repeat by themselves, every 2π
        let turns = match self {
            Self::Ball(_) => [false, false, true],
            _ => [true; 3],
        };
        let close = |c: Vec3| {
            Vec3::from_fn(
                |k, _| if turns[k] { c[k] + TAU * ((reference[k] - c[k]) / TAU).round() } else { c[k] },
            )
        };
        let (a, b) = (close(first), close(second));
        if (b - reference).norm_squared() < (a - reference).norm_squared() { b } else { a }
    }
}

/// Names of the anatomical coordinates of a ball.
pub(crate) fn ball_axes(limits: &BallLimits) -> Vec<String> {
    let kinds = ["swing", "swing", "twist"].into_iter().zip(&limits.axes).enumerate();
    kinds.map(|(k, (kind, axis))| format!("{kind} {}", axis_name(axis, k))).collect()
}
