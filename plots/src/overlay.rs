//! Ground forces from several sources, laid over each other: [YAH10, Fig. 9], and more.
//!
//! In: [`GroundForces`] with who tells them. Out: a page with the total and each foot in rows, vertical
//! and horizontal force in columns, and over each panel the RMS of the difference to the reference: what
//! the engine measured, or what the motion requires when nothing was measured. The horizontal panel
//! shows the length of the force; its RMS is of the difference vector.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

use dynamics::GroundForces;
use motion::Vec3;

use crate::angles::label_time;
use crate::columns::{WIDTH, empty_page, short};
use crate::figure::Figure;
use crate::gains::zero;
use crate::panel::{Clock, Guide, Key, Panel, Sample, Series, Stroke, page};
use crate::style::{Color, GREEN, INK, REFERENCE, VERMILION};

/// Where a ground force is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ForceSourceKind {
    /// The engine of the dynamic pass.
    Measured,
    /// The penalty model.
    Given,
    /// The motion, by inverse dynamics.
    Required,
    /// MuJoCo.
    Mujoco,
}

impl ForceSourceKind {
    /// One word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Given => "penalty",
            Self::Required => "required",
            Self::Mujoco => "MuJoCo",
        }
    }

    /// Colour, width and stroke: wide and pale below, thin and dark on top, so that curves that agree are
    /// all seen.
    fn look(self) -> (Color, f64, Stroke) {
        match self {
            Self::Measured => (Color(150, 200, 235), 4.6, Stroke::Solid),
            Self::Given => (GREEN, 2.2, Stroke::Solid),
            Self::Required => (INK, 1.2, Stroke::Solid),
            Self::Mujoco => (VERMILION, 1.8, Stroke::Dashed),
        }
    }
}

/// The axis is cut where the penalty force is over this many times the peak of all others: a foot captured a centimetre
/// too low gives ten times the body's weight, and the other curves would be flat lines.
const OFF_SCALE: f64 = 1.6;

/// Ground forces from one source.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceSource {
    /// Where from.
    pub kind: ForceSourceKind,
    /// Says in the legend how: `penalty contact, sink 1.5 mm`.
    pub label: String,
    /// The forces.
    pub forces: GroundForces,
}

/// The one the others are compared with: measured before required before any.
pub fn reference(sources: &[ForceSource]) -> Option<&ForceSource> {
    let of = |kind| sources.iter().find(|w| w.kind == kind);
    of(ForceSourceKind::Measured).or_else(|| of(ForceSourceKind::Required)).or(sources.first())
}

/// A penalty contact whose vertical force differs by more than this share of the body's weight RMS says nothing of a motion but
/// how its soles were captured: it is left out, and the note says so.
const MEANINGLESS: f64 = 0.5;

/// Ground forces over each other; `weight_n` is the body weight.
pub fn contact_overlay(sources: &[ForceSource], weight_n: f64, note: &str) -> Figure {
    let title = "Ground forces: required, given, measured";
    let Some(reference) = reference(sources) else {
        return empty_page(title, note, "nothing tells of ground forces: there is no ground");
    };
    if sources.iter().all(|w| w.forces.total.is_empty()) {
        return empty_page(title, note, "no row in this span");
    }
    let mut order: Vec<&ForceSource> = sources.iter().collect();
    order.sort_by_key(|w| w.kind);
    let mut left_out = String::new();
    order.retain(|w| {
        let rms = match w.kind {
            ForceSourceKind::Given => {
                let pair = [&reference.forces, &w.forces];
                GroundForces::rms_difference(pair, &reference.forces.total, &w.forces.total)
            }
            _ => None,
        };
        let meaningless = rms.filter(|[up, _]| w.kind != reference.kind && *up > MEANINGLESS * weight_n);
        if let Some([up, _]) = meaningless {
            let percent = 100.0 * up / weight_n;
            left_out = format!(
                " · penalty contact is off by {} N RMS ({percent:.0} % of body weight) and is not drawn",
                short(up)
            );
        }
        meaningless.is_none()
    });
    let keys = order.iter().map(|w| {
        let (color, _, stroke) = w.kind.look();
        Key { label: w.label.clone(), color, sample: Sample::Line(stroke) }
    });
    let mut keys: Vec<Key> = keys.collect();
    keys.push(Key::dashed("body weight", REFERENCE));
    let mut panels = row("total", &order, reference, weight_n, |f| Some(&f.total));
    for foot in &reference.forces.feet {
        let of = |f: &GroundForces| f.feet.iter().position(|x| x.link == foot.link);
        panels.extend(row(&foot.name, &order, reference, weight_n, |f| of(f).map(|i| &f.feet[i].force[..])));
    }
    label_time(&mut panels, 2);
    let note = format!(
        "{note}{}over each panel: RMS of the difference from what is {}{left_out}",
        if note.is_empty() { "" } else { " · " },
        reference.kind.name()
    );
    page(title, &note, &keys, &panels, 2, WIDTH, 190.0)
}

/// Panels of vertical and of horizontal force of one part.
fn row<'a>(
    name: &str,
    order: &[&'a ForceSource],
    reference: &'a ForceSource,
    weight: f64,
    part: impl for<'b> Fn(&'b GroundForces) -> Option<&'b [Vec3]>,
) -> Vec<Panel> {
    let mut differences = [Vec::new(), Vec::new()];
    for w in order.iter().filter(|w| w.kind != reference.kind) {
        let (Some(a), Some(b)) = (part(&reference.forces), part(&w.forces)) else { continue };
        if let Some(rms) = GroundForces::rms_difference([&reference.forces, &w.forces], a, b) {
            for (said, rms) in differences.iter_mut().zip(rms) {
                said.push(format!("{} {} N", w.kind.name(), short(rms)));
            }
        }
    }
    let title = |kind: &str, said: &[String]| match said.is_empty() {
        true => format!("{name} · {kind}"),
        false => format!("{name} · {kind} · RMS {}", said.join(", ")),
    };
    let curves = |f: fn(&Vec3) -> f64| -> Vec<Series> {
        let one = |w: &&ForceSource| {
            let (color, width, stroke) = w.kind.look();
            let clock = Clock { rate_hz: w.forces.rate_hz, start_s: w.forces.start_s };
            let values = part(&w.forces)?.iter().map(f);
            let series = Series::over_time(clock, values, color).wide(width);
            Some(Series { stroke, ..series })
        };
        order.iter().filter_map(one).collect()
    };
    let ceiling = |f: fn(&Vec3) -> f64, least: f64| -> (Option<f64>, String) {
        let peak = |w: &&ForceSource| {
            let forces = part(&w.forces).unwrap_or_default();
            forces.iter().map(f).filter(|y| y.is_finite()).fold(0.0, f64::max)
        };
        let others =
            order.iter().filter(|w| w.kind != ForceSourceKind::Given).map(peak).fold(least, f64::max);
        match order.iter().find(|w| w.kind == ForceSourceKind::Given).map(peak) {
            Some(given) if given > OFF_SCALE * others => {
                (Some(1.3 * others), format!(" · penalty off scale, peak {} N", short(given)))
            }
            _ => (None, String::new()),
        }
    };
    let (up, across) = (ceiling(|f| f.y, 0.5 * weight), ceiling(|f| f.x.hypot(f.z), 0.1 * weight));
    let line = Guide { y: weight, color: REFERENCE, stroke: Stroke::Dashed, always: name == "total" };
    vec![
        Panel {
            title: title("vertical", &differences[0]) + &up.1,
            y_label: "N".into(),
            series: curves(|f| f.y),
            guides: vec![zero(true), line],
            ceiling: up.0,
            least_span: 10.0,
            ..Panel::default()
        },
        Panel {
            title: title("horizontal", &differences[1]) + &across.1,
            y_label: "N".into(),
            series: curves(|f| f.x.hypot(f.z)),
            guides: vec![zero(true)],
            ceiling: across.0,
            least_span: 10.0,
            ..Panel::default()
        },
    ]
}
