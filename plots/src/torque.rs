//! Torques of the joints that work hardest.
//!
//! In: a [`Trace`](dynamics::Trace), and the noise floor of each torque where it comes from inverse
//! dynamics. Out: a page with a panel per joint: the size of its torque (of a ball the length of the
//! vector), of its muscles and of the stops at the ends of its range; a pale band up to twice the
//! standard deviation of what is only noise.

use motion::{Joint, Vec3};

use crate::angles::label_time;
use crate::columns::{WIDTH, empty_page, rows, short};
use crate::excerpt::Excerpt;
use crate::figure::Figure;
use crate::gains::zero;
use crate::panel::{Band, Key, Panel, Series, page};
use crate::style::{BLUE, Color, VERMILION};

/// Joints shown.
const MOST: usize = 12;
const NOISE: Color = Color(236, 236, 236);

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
            let sizes = sizes(trace, &trace.torque, link, rows);
            (link, sizes.into_iter().filter(|x| x.is_finite()).fold(0.0, f64::max))
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
    let mut keys = vec![Key::line("torque", BLUE)];
    if stops {
        keys.push(Key::line("stops at the ends of the range", VERMILION));
    }
    if !noise.is_empty() {
        keys.push(Key::area("noise: up to two standard deviations", NOISE));
    }
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
    let floor = noise.get(at..at + n).map(|s| 2.0 * s.iter().map(|x| x * x).sum::<f64>().sqrt());
    let mut series = vec![Series::over_time(trace.clock(), sizes(trace, &trace.torque, link, rows), BLUE)];
    if stops && trace.stop_torque.len() >= rows * skeleton.nv() {
        let of_stops = sizes(trace, &trace.stop_torque, link, rows);
        series.push(Series::over_time(trace.clock(), of_stops, VERMILION));
    }
    let per_mass = peak / trace.character.mass();
    Panel {
        title: format!("{} · peak {} {unit}, {} {unit}/kg", l.name, short(peak), short(per_mass)),
        y_label: unit.into(),
        series,
        bands: floor
            .filter(|f| *f > 0.0)
            .map(|to| vec![Band { from: 0.0, to, color: NOISE }])
            .unwrap_or_default(),
        guides: vec![zero(true)],
        least_span: 1.0,
        ..Panel::default()
    }
}

/// Length of a joint's torque per row.
fn sizes(trace: &Excerpt, torque: &[f64], link: usize, rows: usize) -> Vec<f64> {
    let skeleton = &trace.character.skeleton;
    let (nv, at) = (skeleton.nv(), skeleton.v_at(link));
    let size = |row: usize| match skeleton.links()[link].joint {
        Joint::Spherical => Vec3::from_column_slice(&torque[row * nv + at..row * nv + at + 3]).norm(),
        _ => torque[row * nv + at].abs(),
    };
    // at the start of a recorded run nothing has acted yet
    let nothing = torque[..nv].iter().all(|x| *x == 0.0) && rows > 1;
    (0..rows).map(|row| if row == 0 && nothing { f64::NAN } else { size(row) }).collect()
}
