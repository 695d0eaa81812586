//! Ground forces as several witnesses tell them, laid over each other: [YAH10, Fig. 9], and more.
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

/// Who tells a force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum WitnessKind {
    /// The engine of the dynamic pass.
    Measured,
    /// The penalty model.
    Given,
    /// The motion, by inverse dynamics.
    Required,
    /// MuJoCo.
    Mujoco,
}

impl WitnessKind {
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

/// A penalty force over this many times all others' peak is cut: feet that were captured a centimetre too
/// low weigh tons, and would flatten everything else.
const OFF_SCALE: f64 = 1.6;

/// A witness of the ground forces.
#[derive(Clone, Debug, PartialEq)]
pub struct Witness {
    /// Who.
    pub kind: WitnessKind,
    /// Says in the legend how: `penalty contact, sink 1.5 mm`.
    pub label: String,
    /// The forces.
    pub forces: GroundForces,
}

/// The one the others are compared with: measured before required before any.
pub fn reference(witnesses: &[Witness]) -> Option<&Witness> {
    let of = |kind| witnesses.iter().find(|w| w.kind == kind);
    of(WitnessKind::Measured).or_else(|| of(WitnessKind::Required)).or(witnesses.first())
}

/// Ground forces over each other; `weight_n` is the body weight.
pub fn contact_overlay(witnesses: &[Witness], weight_n: f64, note: &str) -> Figure {
    let title = "Ground forces: required, given, measured";
    let Some(reference) = reference(witnesses) else {
        return empty_page(title, note, "nothing tells of ground forces: there is no ground");
    };
    if witnesses.iter().all(|w| w.forces.total.is_empty()) {
        return empty_page(title, note, "no row in this span");
    }
    let mut order: Vec<&Witness> = witnesses.iter().collect();
    order.sort_by_key(|w| w.kind);
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
        "{note}{}over each panel: RMS of the difference from what is {}",
        if note.is_empty() { "" } else { " · " },
        reference.kind.name()
    );
    page(title, &note, &keys, &panels, 2, WIDTH, 190.0)
}

/// Panels of vertical and of horizontal force of one part.
fn row<'a>(
    name: &str,
    order: &[&'a Witness],
    reference: &'a Witness,
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
        let one = |w: &&Witness| {
            let (color, width, stroke) = w.kind.look();
            let clock = Clock { rate_hz: w.forces.rate_hz, start_s: w.forces.start_s };
            let values = part(&w.forces)?.iter().map(f);
            let series = Series::over_time(clock, values, color).wide(width);
            Some(Series { stroke, ..series })
        };
        order.iter().filter_map(one).collect()
    };
    let ceiling = |f: fn(&Vec3) -> f64, least: f64| -> (Option<f64>, String) {
        let peak = |w: &&Witness| {
            let forces = part(&w.forces).unwrap_or_default();
            forces.iter().map(f).filter(|y| y.is_finite()).fold(0.0, f64::max)
        };
        let others = order.iter().filter(|w| w.kind != WitnessKind::Given).map(peak).fold(least, f64::max);
        match order.iter().find(|w| w.kind == WitnessKind::Given).map(peak) {
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
