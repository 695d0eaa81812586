//! Energies, and the power of the joints.
//!
//! In: a [`Trace`](dynamics::Trace). Out: a page with kinetic energy, potential energy over its least, and
//! their sum; and the power `Σ τ·v` of all muscles, positive where they drive, negative where they brake.
//! Actuator torques and velocities of a joint are along the same axes, so their product needs no turning.

use crate::angles::label_time;
use crate::columns::{WIDTH, empty_page, rows, short};
use crate::excerpt::Excerpt;
use crate::figure::Figure;
use crate::gains::zero;
use crate::panel::{Key, Panel, Series, page};
use crate::style::{BLUE, GREEN, INK, VERMILION};

/// Energies and power over time.
pub fn energies<'a>(trace: impl Into<Excerpt<'a>>, note: &str) -> Figure {
    let trace = &trace.into();
    let title = "Energy and power";
    let nv = trace.character.skeleton.nv();
    let rows = rows(trace).min(trace.energy.len() / 2).min(trace.torque.len().min(trace.v.len()) / nv.max(1));
    if rows == 0 {
        return empty_page(title, note, "the trace has no rows");
    }
    let kinetic: Vec<f64> = (0..rows).map(|k| trace.energy[2 * k]).collect();
    let potential: Vec<f64> = (0..rows).map(|k| trace.energy[2 * k + 1]).collect();
    let least = potential.iter().copied().filter(|e| e.is_finite()).fold(f64::INFINITY, f64::min);
    let least = if least.is_finite() { least } else { 0.0 };
    let power: Vec<f64> = (0..rows)
        .map(|k| {
            let row = k * nv..(k + 1) * nv;
            trace.torque[row.clone()].iter().zip(&trace.v[row]).map(|(t, v)| t * v).sum()
        })
        .collect();
    let work = |sign: f64| -> f64 {
        let of_sign = power.iter().filter(|p| p.is_finite() && **p * sign > 0.0);
        of_sign.sum::<f64>() / trace.rate_hz
    };
    let clock = trace.clock();
    let mut panels = [
        Panel {
            title: "kinetic, potential over its least, and their sum".into(),
            y_label: "J".into(),
            series: vec![
                Series::over_time(clock, potential.iter().map(|e| e - least), VERMILION),
                Series::over_time(clock, kinetic.iter().copied(), BLUE),
                Series::over_time(clock, kinetic.iter().zip(&potential).map(|(k, p)| k + p - least), INK)
                    .wide(1.2),
            ],
            guides: vec![zero(true)],
            least_span: 5.0,
            ..Panel::default()
        },
        Panel {
            title: format!(
                "power of all joints · {} J of work done, {} J taken up",
                short(work(1.0)),
                short(-work(-1.0))
            ),
            y_label: "W".into(),
            series: vec![Series::over_time(clock, power.iter().copied(), GREEN)],
            guides: vec![zero(true)],
            least_span: 5.0,
            ..Panel::default()
        },
    ];
    label_time(&mut panels, 1);
    let keys = [
        Key::line("kinetic", BLUE),
        Key::line("potential", VERMILION),
        Key::line("sum", INK),
        Key::line("power", GREEN),
    ];
    page(title, note, &keys, &panels, 1, WIDTH, 200.0)
}
