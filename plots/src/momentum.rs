//! Momentum of the whole body, and the force that changes it.
//!
//! In: a [`Trace`](dynamics::Trace). Out: a page with linear momentum, its rate less gravity (the force
//! from outside that the motion needs, N and % of body weight), and angular momentum about the centre of
//! mass.

use motion::Vec3;

use crate::angles::{COLORS, label_time};
use crate::columns::{WIDTH, empty_page, mark_times, rows, short, vectors, weight};
use crate::excerpt::Excerpt;
use crate::figure::Figure;
use crate::gains::zero;
use crate::panel::{Guide, Key, Panel, Series, Stroke, page};
use crate::style::REFERENCE;

/// Linear and angular momentum over time.
pub fn momenta<'a>(trace: impl Into<Excerpt<'a>>, note: &str) -> Figure {
    let trace = &trace.into();
    let title = "Momentum";
    let (linear, angular) = (vectors(&trace.momentum, 6, 0), vectors(&trace.momentum, 6, 3));
    let rows = rows(trace).min(linear.len());
    if rows < 2 {
        return empty_page(title, note, "fewer than two rows: nothing to differentiate");
    }
    let weight = weight(trace);
    let rate = (1..linear.len())
        .map(|row| (linear[row] - linear[row - 1]) * trace.rate_hz - trace.gravity * trace.mass_at(row));
    let force: Vec<Vec3> = std::iter::once(Vec3::repeat(f64::NAN)).chain(rate).collect();
    let peak = |of: &[Vec3]| of.iter().map(|v| v.norm()).filter(|n| n.is_finite()).fold(0.0, f64::max);
    let panel = |of: &[Vec3], title: String, unit: &str, least_span: f64| Panel {
        title,
        y_label: unit.into(),
        series: (0..3)
            .map(|k| Series::over_time(trace.clock(), of.iter().map(|v| v[k]), COLORS[k]))
            .collect(),
        guides: vec![zero(true)],
        least_span,
        ..Panel::default()
    };
    let mut outside = panel(
        &force,
        format!(
            "force from outside that it takes, d(momentum)/dt \u{2212} m g · peak {} N, body weight {weight:.0} N",
            short(peak(&force))
        ),
        "N",
        (0.1 * weight).max(1.0),
    );
    outside.guides.push(Guide { y: weight, color: REFERENCE, stroke: Stroke::Dashed, always: true });
    let mut panels = vec![
        panel(&linear, format!("linear momentum · peak {} N·s", short(peak(&linear))), "N·s", 2.0),
        outside,
        panel(
            &angular,
            format!("angular momentum about the centre of mass · peak {} N·m·s", short(peak(&angular))),
            "N·m·s",
            0.5,
        ),
    ];
    label_time(&mut panels, 1);
    let mut keys = vec![
        Key::line("x, to the left", COLORS[0]),
        Key::line("y, up", COLORS[1]),
        Key::line("z, forward", COLORS[2]),
        Key::dashed("body weight", REFERENCE),
    ];
    mark_times(trace, &mut panels, &mut keys);
    page(title, note, &keys, &panels, 1, WIDTH, 180.0)
}
