//! What neither gravity nor contacts explain.
//!
//! In: a [`Trace`](dynamics::Trace). Out: a page with `d(momentum)/dt − m g − Σ contacts` over time, N and % of body
//! weight, and the moment of that kind about the centre of mass. Of a free root it is the error of the
//! integrator. Of a held one it is what holds it: then the recorded wrench of the holder follows, and
//! what is left after it.

use dynamics::RootMode;
use motion::Vec3;
use motion::skeleton::vec_at;

use crate::angles::{COLORS, label_time};
use crate::columns::{WIDTH, empty_page, mark_times, rms, rows, short, vectors, weight};
use crate::excerpt::Excerpt;
use crate::figure::Figure;
use crate::gains::zero;
use crate::panel::{Key, Panel, Series, page};
use crate::style::INK;

/// Least height of the axes, share of body weight, so that rounding looks like rounding.
const LEAST: f64 = 0.01;

/// Rate of momentum that neither gravity nor contacts explain; with the root's wrench when it is held.
pub fn momentum_residual<'a>(trace: impl Into<Excerpt<'a>>, note: &str) -> Figure {
    let trace = &trace.into();
    let title = "Momentum not explained by gravity and contacts";
    let (force, moment) = unexplained(trace);
    if force.is_empty() {
        return empty_page(title, note, "the trace has fewer than two rows: nothing to differentiate");
    }
    let weight = weight(trace);
    let least = (LEAST * weight).max(1e-3);
    let what = match trace.root {
        RootMode::Free => "root free: this is the error of the integrator".to_owned(),
        RootMode::Assisted { force_n, moment_nm } => {
            format!("root assisted by at most {force_n:.0} N and {moment_nm:.0} N·m")
        }
        RootMode::Pinned => "root pinned: this is what the pin does".to_owned(),
    };
    let note = format!("{note} · {what}");
    let note = note.trim_start_matches(" · ");

    let mut panels = vec![curves(
        trace,
        &force,
        format!("d(momentum)/dt \u{2212} m g \u{2212} contacts · {}", sizes(&force, "N", weight)),
        "N",
        least,
    )];
    let share = if weight > 0.0 {
        let percent = force.iter().map(|f| 100.0 * f.norm() / weight);
        Panel {
            title: "its magnitude".into(),
            y_label: "% of body weight".into(),
            series: vec![Series::over_time(trace.clock(), from_first(percent), INK)],
            guides: vec![zero(true)],
            least_span: 100.0 * LEAST,
            ..Panel::default()
        }
    } else {
        Panel {
            title: "its magnitude".into(),
            message: "no weight: gravity is off".into(),
            ..Panel::default()
        }
    };
    panels.push(share);
    let about = format!("the moment of that kind, about the centre of mass · {}", sizes(&moment, "N·m", 0.0));
    panels.push(curves(trace, &moment, about, "N·m", 0.5 * least));
    if trace.root != RootMode::Free {
        panels.extend(root_wrench(trace, &force, weight, least));
    }
    let mut keys = vec![
        Key::line("x, to the left", COLORS[0]),
        Key::line("y, up", COLORS[1]),
        Key::line("z, forward", COLORS[2]),
        Key::line("magnitude", INK),
    ];
    label_time(&mut panels, 1);
    mark_times(trace, &mut panels, &mut keys);
    let height = if panels.len() > 3 { 130.0 } else { 180.0 };
    page(title, note, &keys, &panels, 1, WIDTH, height)
}

/// Panels of the wrench that holds the root.
fn root_wrench(trace: &Excerpt, force: &[Vec3], weight: f64, least: f64) -> Vec<Panel> {
    let wrench = vectors(&trace.root_wrench, 6, 0);
    let moment = vectors(&trace.root_wrench, 6, 3);
    let after = |v: &[Vec3]| v.get(1..).map(<[Vec3]>::to_vec).unwrap_or_default();
    let (wrench, moment) = (after(&wrench), after(&moment));
    let left: Vec<Vec3> = force.iter().zip(&wrench).map(|(f, w)| f - w).collect();
    vec![
        curves(trace, &wrench, format!("force on the root · {}", sizes(&wrench, "N", weight)), "N", least),
        curves(
            trace,
            &moment,
            format!("moment on the root, about its origin · {}", sizes(&moment, "N·m", 0.0)),
            "N·m",
            least,
        ),
        curves(
            trace,
            &left,
            format!("what is left after the force on the root · {}", sizes(&left, "N", weight)),
            "N",
            least,
        ),
    ]
}

/// Force, and moment about the centre of mass, that neither gravity, contacts, pushes nor what is handed over
/// explain, for the rows from 1 on.
pub fn unexplained(trace: &Excerpt) -> (Vec<Vec3>, Vec<Vec3>) {
    let (linear, angular) = (vectors(&trace.momentum, 6, 0), vectors(&trace.momentum, 6, 3));
    let com = vectors(&trace.com, 3, 0);
    let rows = rows(trace).min(linear.len()).min(com.len());
    let outside = &trace.disturbed.wrench;
    let mut force = Vec::with_capacity(rows);
    let mut moment = Vec::with_capacity(rows);
    for row in 1..rows {
        force.push((linear[row] - linear[row - 1]) * trace.rate_hz - trace.gravity * trace.mass_at(row));
        moment.push((angular[row] - angular[row - 1]) * trace.rate_hz);
        if let Some(w) = outside.get(6 * row..6 * row + 6) {
            let root = trace.character.skeleton.position(trace.pose(row), 0);
            let f = vec_at(w, 0);
            force[row - 1] -= f;
            moment[row - 1] -= vec_at(w, 3) + (root - com[row]).cross(&f);
        }
    }
    for c in trace.contacts.iter().filter(|c| c.row > 0 && c.row < rows) {
        force[c.row - 1] -= c.force;
        moment[c.row - 1] -= (c.point - com[c.row]).cross(&c.force);
    }
    (force, moment)
}

fn curves(trace: &Excerpt, of: &[Vec3], title: String, unit: &str, least_span: f64) -> Panel {
    let component =
        |k: usize| Series::over_time(trace.clock(), from_first(of.iter().map(|v| v[k])), COLORS[k]);
    Panel {
        title,
        y_label: unit.into(),
        series: (0..3).map(component).collect(),
        guides: vec![zero(true)],
        least_span,
        ..Panel::default()
    }
}

/// Values of the rows from 1 on, after a gap for row 0.
fn from_first(values: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
    std::iter::once(f64::NAN).chain(values)
}

fn sizes(of: &[Vec3], unit: &str, weight: f64) -> String {
    let peak = of.iter().map(|v| v.norm()).filter(|n| n.is_finite()).fold(0.0, f64::max);
    let rms = rms(of);
    let share = if weight > 0.0 {
        format!(" ({} % and {} % of body weight)", short(100.0 * rms / weight), short(100.0 * peak / weight))
    } else {
        String::new()
    };
    format!("RMS {} {unit}, peak {} {unit}{share}", short(rms), short(peak))
}
