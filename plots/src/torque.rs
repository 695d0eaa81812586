//! Torques of the joints that work hardest.
//!
//! In: a [`Trace`](dynamics::Trace), and the noise floor of each torque where it comes from inverse
//! dynamics. Out: a page with a panel per joint: the torque of its muscles and, dashed, of the stops at the ends of its range, of
//! a ball about each of its axes; a pale band up to twice the standard deviation of what is only noise.

use motion::Joint;

use crate::angles::label_time;
use crate::columns::{WIDTH, empty_page, rows, short};
use crate::excerpt::Excerpt;
use crate::figure::Figure;
use crate::gains::{about_axes, peak, zero};
use crate::panel::{Band, Key, Panel, Series, page};
use crate::style::{BLUE, Color, GREEN, VERMILION};

/// Joints shown.
const MOST: usize = 12;
const NOISE: Color = Color(236, 236, 236);
/// Of the axes of a joint.
const AXES: [Color; 3] = [BLUE, VERMILION, GREEN];

/// Torques of the joints with the largest ones; `noise` is the standard deviation of each entry of a row
/// (`nv`), empty when there is none.
pub fn joint_torques<'a>(trace: impl Into<Excerpt<'a>>, noise: &[f64], note: &str) -> Figure {
    let trace = &trace.into();
    let title = "Joint torques";
    let nv = trace.character.skeleton.nv();
    let rows = rows(trace).min(trace.torque.len() / nv.max(1));
    let joints = trace.joints();
    if rows == 0 || joints.is_empty() {
        let why = if rows == 0 { "the trace has no rows" } else { "the body has no joints" };
        return empty_page(title, note, why);
    }
    let mut working: Vec<(usize, f64)> = joints
        .into_iter()
        .map(|link| {
            let axes = about_axes(trace, &trace.torque, link, rows);
            (link, axes.iter().map(|(_, values)| peak(values)).fold(0.0, f64::max))
        })
        .collect();
    let all = working.len();
    working.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    working.truncate(MOST);
    let shown = match all {
        n if n > MOST => format!("{note} · the {MOST} of {n} joints with the largest torques"),
        _ => note.to_owned(),
    };
    let stops = trace.stop_torque.iter().any(|x| *x != 0.0);
    let mut keys = vec![Key::line("torque of the muscles, about each axis of a ball", BLUE)];
    if stops {
        keys.push(Key::dashed("of the stops at the ends of the range", BLUE));
    }
    if !noise.is_empty() {
        keys.push(Key::area("noise: up to two standard deviations", NOISE));
    }
    let shown = format!(
        "{shown}{}over each panel: peak, and per mass in N·m/kg",
        if shown.is_empty() { "" } else { " · " }
    );
    let columns = if working.len() > 4 { 3 } else { 2 };
    let mut panels: Vec<Panel> =
        working.iter().map(|(link, peak)| panel(trace, *link, *peak, rows, noise, stops)).collect();
    label_time(&mut panels, columns);
    page(title, &shown, &keys, &panels, columns, WIDTH, 140.0)
}

fn panel(trace: &Excerpt, link: usize, peak: f64, rows: usize, noise: &[f64], stops: bool) -> Panel {
    let skeleton = &trace.character.skeleton;
    let l = &skeleton.links()[link];
    let (at, n) = (skeleton.v_at(link), l.joint.nv());
    let unit = if matches!(l.joint, Joint::Prismatic(_)) { "N" } else { "N·m" };
    let floor = noise.get(at..at + n).map(|s| 2.0 * s.iter().copied().fold(0.0, f64::max));
    let curve = |(values, color)| Series::over_time(trace.clock(), values, color);
    let (names, torques): (Vec<String>, Vec<Vec<f64>>) =
        signed(trace, &trace.torque, link, rows).into_iter().unzip();
    let mut series: Vec<Series> = torques.into_iter().zip(AXES).map(curve).collect();
    if stops && trace.stop_torque.len() >= rows * skeleton.nv() {
        let of_stops = signed(trace, &trace.stop_torque, link, rows).into_iter().map(|(_, values)| values);
        let of_stops = of_stops.zip(AXES).map(curve);
        let acts = |s: &Series| s.points.iter().any(|p| p[1].abs() > 0.0);
        series.extend(of_stops.filter(acts).map(|s| s.dashed().wide(1.2)));
    }
    let tags = if n > 1 { names.into_iter().zip(AXES).collect() } else { Vec::new() };
    let per_mass = peak / trace.character.mass();
    Panel {
        title: format!("{} · {} {unit}, {}/kg", l.name, short(peak), short(per_mass)),
        y_label: unit.into(),
        series,
        tags,
        bands: floor
            .filter(|f| *f > 0.0)
            .map(|to| vec![Band { from: -to, to, color: NOISE }])
            .unwrap_or_default(),
        guides: vec![zero(true)],
        least_span: 1.0,
        ..Panel::default()
    }
}

/// Torques of a joint per axis and row.
fn signed(trace: &Excerpt, torque: &[f64], link: usize, rows: usize) -> Vec<(String, Vec<f64>)> {
    let mut axes = about_axes(trace, torque, link, rows);
    // at the start of a recorded run nothing has acted yet
    let nv = trace.character.skeleton.nv();
    if rows > 1 && torque[..nv].iter().all(|x| *x == 0.0) {
        axes.iter_mut().for_each(|(_, values)| values[0] = f64::NAN);
    }
    axes
}
