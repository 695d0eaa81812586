//! Gains and torques of the joints that work hardest.
//!
//! In: a [`Trace`](dynamics::Trace). Out: a page with two panels per joint: the gains of the springs towards the lower
//! and the upper set point (N·m/rad), and the torque (N·m), both about the axis that bears the largest
//! torque.
//!
//! A trace holds the torque of a ball along its zero frame and its gains along its anatomical axes; here
//! both are about the anatomical ones: the two swing axes, and the twist axis turned by the swing. A ball
//! without limits has x, y and z for them.

use motion::rotation::exp;
use motion::{BallLimits, Joint, Limits, Range, Vec3};

use crate::angles::{ball_axes, label_time};
use crate::columns::{empty_page, mark_times, rows};
use crate::excerpt::Excerpt;
use crate::figure::Figure;
use crate::panel::{Guide, Key, Panel, Series, Stroke, page};
use crate::style::{BLUE, INK, REFERENCE, VERMILION};

/// Joints shown.
const MOST: usize = 8;
/// Panels side by side: gains and torque of two joints.
const COLUMNS: usize = 4;

/// Torques of a joint over time, with what each axis is called: of a ball about its two swing axes and its twist axis.
///
/// * `torque`: as the trace has it, `rows × nv`, N·m (N for a slide)
pub(crate) fn about_axes(
    trace: &Excerpt,
    torque: &[f64],
    link: usize,
    rows: usize,
) -> Vec<(String, Vec<f64>)> {
    let skeleton = &trace.character.skeleton;
    let l = &skeleton.links()[link];
    let (nv, at) = (skeleton.nv(), skeleton.v_at(link));
    let cell = |row: usize, k: usize| torque[row * nv + at + k];
    let one = |name: &str| vec![(name.to_owned(), (0..rows).map(|r| cell(r, 0)).collect())];
    match l.joint {
        Joint::Spherical => {
            let limits = anatomy(l.limits.as_ref());
            let along = |row: usize| {
                let t = Vec3::new(cell(row, 0), cell(row, 1), cell(row, 2));
                let phi = limits.coords(&skeleton.rotation(trace.pose(row), link));
                let swing = exp(&(limits.axes[0] * phi.x + limits.axes[1] * phi.y));
                [t.dot(&limits.axes[0]), t.dot(&limits.axes[1]), t.dot(&(swing * limits.axes[2]))]
            };
            let rows: Vec<[f64; 3]> = (0..rows).map(along).collect();
            let column = |(k, name): (usize, String)| (name, rows.iter().map(|r| r[k]).collect());
            ball_axes(&limits).into_iter().enumerate().map(column).collect()
        }
        Joint::Prismatic(_) => one("slide"),
        _ => one("hinge"),
    }
}

/// Largest size of what is finite.
pub(crate) fn peak(values: &[f64]) -> f64 {
    values.iter().filter(|x| x.is_finite()).fold(0.0, |p: f64, x| p.max(x.abs()))
}

/// Gains and torque over time of the joints with the largest torques.
pub fn gains_and_torques<'a>(trace: impl Into<Excerpt<'a>>, note: &str) -> Figure {
    let trace = &trace.into();
    let title = "Gains and torques";
    let skeleton = &trace.character.skeleton;
    let cells = [&trace.torque, &trace.k_lo, &trace.k_hi].into_iter().map(Vec::len).min().unwrap_or(0);
    let rows = rows(trace).min(cells / skeleton.nv().max(1));
    let mut working: Vec<Working> = trace.joints().into_iter().map(|l| Working::of(trace, l, rows)).collect();
    if rows == 0 || working.is_empty() {
        let why = if rows == 0 { "the trace has no rows" } else { "the body has no joints" };
        return empty_page(title, note, why);
    }
    let all = working.len();
    working.sort_by(|a, b| b.peak.total_cmp(&a.peak).then(a.link.cmp(&b.link)));
    working.truncate(MOST);
    working.sort_by_key(|w| w.link);
    let shown = match all {
        n if n > MOST => format!("{note} · the {MOST} of {n} joints with the largest torques"),
        _ => note.to_owned(),
    };
    let mut keys = vec![
        Key::line("k_lo: gain towards the lower set point", BLUE),
        Key::line("k_hi: gain towards the upper set point", VERMILION),
        Key::line("torque of both springs and the damper", INK),
    ];
    let mut panels: Vec<Panel> = working.iter().flat_map(|w| w.panels(trace)).collect();
    label_time(&mut panels, COLUMNS.min(2 * working.len()));
    mark_times(trace, &mut panels, &mut keys);
    page(title, &shown, &keys, &panels, COLUMNS, 1600.0, 150.0)
}

/// A joint about the axis of its largest torque.
struct Working {
    link: usize,
    /// 0, 1 or 2 for a ball.
    axis: usize,
    /// What the axis is called.
    name: String,
    /// N·m (N for a slide).
    torque: Vec<f64>,
    peak: f64,
}

impl Working {
    fn of(trace: &Excerpt, link: usize, rows: usize) -> Self {
        let torques = about_axes(trace, &trace.torque, link, rows);
        let mut axis = 0;
        for k in 1..torques.len() {
            if peak(&torques[k].1) > peak(&torques[axis].1) {
                axis = k;
            }
        }
        let (name, torque) = torques[axis].clone();
        Self { link, axis, name, peak: peak(&torque), torque }
    }

    fn panels(&self, trace: &Excerpt) -> [Panel; 2] {
        let skeleton = &trace.character.skeleton;
        let link = &skeleton.links()[self.link];
        let (nv, cell) = (skeleton.nv(), skeleton.v_at(self.link) + self.axis);
        let column = |data: &[f64]| -> Vec<f64> {
            // row 0 is the start: nothing has acted yet
            let later = data.chunks_exact(nv).take(self.torque.len()).skip(1).map(|row| row[cell]);
            std::iter::once(f64::NAN).chain(later).collect()
        };
        let torque = std::iter::once(f64::NAN).chain(self.torque.iter().skip(1).copied());
        let slide = matches!(link.joint, Joint::Prismatic(_));
        let gains = Panel {
            title: link.name.clone(),
            y_label: if slide { "N/m" } else { "N·m/rad" }.into(),
            series: vec![
                Series::over_time(trace.clock(), column(&trace.k_lo), BLUE),
                Series::over_time(trace.clock(), column(&trace.k_hi), VERMILION),
            ],
            guides: vec![zero(true)],
            least_span: 10.0,
            tags: vec![("k_lo".into(), BLUE), ("k_hi".into(), VERMILION)],
            ..Panel::default()
        };
        let torque = Panel {
            title: link.name.clone(),
            y_label: if slide { "N" } else { "N·m" }.into(),
            series: vec![Series::over_time(trace.clock(), torque, INK)],
            guides: vec![zero(true)],
            least_span: 2.0,
            tags: vec![(format!("about {}", self.name), INK)],
            ..Panel::default()
        };
        [gains, torque]
    }
}

/// A line at zero.
pub(crate) fn zero(always: bool) -> Guide {
    Guide { y: 0.0, color: REFERENCE, stroke: Stroke::Solid, always }
}

fn anatomy(limits: Option<&Limits>) -> BallLimits {
    match limits {
        Some(Limits::Ball(limits)) => *limits,
        _ => BallLimits { axes: [Vec3::x(), Vec3::y(), Vec3::z()], ranges: [Range::new(-3.2, 3.2); 3] },
    }
}
