//! Which figures a run gets.

use motion::Vec3;
use motion::names::Word;
use plots::{Figure, StripOptions, StripRow, View, film_strip_with};
use scenes::StripSpec;
use sim::Outcome;

use crate::Take;
use crate::results::number;

/// The motion asked for without its edits, above the same with them.
const STRIP_EDITED: &str = "strip_edited";
/// The motion asked for, above the one performed.
const STRIP_DYNAMIC: &str = "strip_dynamic";

/// A figure of the trace alone: its name and who draws it.
type OfTrace = (&'static str, fn(&dynamics::Trace, &str) -> Figure);

/// Figures of what was performed.
const OF_TRACE: &[OfTrace] = &[
    ("joint_angles", |t, note| plots::joint_angles(t, note)),
    ("gains_and_torques", |t, note| plots::gains_and_torques(t, note)),
    ("contact_forces", |t, note| plots::contact_forces(t, note)),
    ("center_of_mass", |t, note| plots::center_of_mass(t, note)),
    ("momentum_residual", |t, note| plots::momentum_residual(t, note)),
];

/// Names of all figures a run may get.
pub fn stems() -> impl Iterator<Item = &'static str> {
    [STRIP_EDITED, STRIP_DYNAMIC].into_iter().chain(OF_TRACE.iter().map(|(stem, _)| *stem))
}

/// A figure: its name, and how to draw it, or why it cannot be.
pub type Draw<'a> = (&'static str, Box<dyn Fn() -> Result<Figure, String> + 'a>);

/// The figures of a run: names, and how to draw each. Nothing is drawn yet.
pub fn figures<'a>(take: &'a Take, outcome: Option<&'a Outcome>) -> Vec<Draw<'a>> {
    let mut figures: Vec<Draw<'a>> = Vec::new();
    if !take.log.edits().is_empty() {
        figures.push((STRIP_EDITED, Box::new(|| Ok(strip_of_edits(take)))));
    }
    if let Some(outcome) = outcome {
        figures.push((STRIP_DYNAMIC, Box::new(|| Ok(strip_of_run(take, outcome)))));
        for &(stem, draw) in OF_TRACE {
            figures.push((stem, Box::new(move || Ok(draw(&outcome.trace, &note(take, outcome))))));
        }
    }
    figures
}

fn strip_of_edits(take: &Take) -> Figure {
    let up = ground_up(take);
    let rows = [
        StripRow::new("unedited", &take.unedited).on(&up),
        StripRow::new("edited", &take.asked.clip).on(&up).standing(&take.asked.contacts),
    ];
    let note = format!("{}: {}", take.name, take.log.edits().join(", then "));
    film_strip_with(&rows, &take.body.character, &note, &options(take))
}

fn strip_of_run(take: &Take, outcome: &Outcome) -> Figure {
    let (up, performed) = (ground_up(take), outcome.trace.clip());
    let rows = [
        StripRow::new("kinematic", &take.asked.clip).on(&up).standing(&take.asked.contacts),
        StripRow::new("dynamic", &performed).on(&outcome.trace.disturbed.ground_up),
    ];
    film_strip_with(&rows, &take.body.character, &note(take, outcome), &until(options(take), take, outcome))
}

/// The same up to the end of a run that ended early: afterwards nothing was performed.
fn until(options: StripOptions, take: &Take, outcome: &Outcome) -> StripOptions {
    let end_s = outcome.trace.rows().saturating_sub(1) as f64 / outcome.trace.rate_hz;
    if end_s + 1.0 / take.asked.clip.rate_hz > take.asked.clip.duration_s() {
        return options;
    }
    let to_s = options.to_s.map_or(end_s, |t| t.min(end_s));
    StripOptions { from_s: options.from_s.min(to_s), to_s: Some(to_s), ..options }
}

/// Normal of the ground as the motion asked for has it.
fn ground_up(take: &Take) -> Vec<Vec3> {
    take.conditions.physics.ground.iter().map(|g| g.up).collect()
}

/// What a figure should say under its title.
fn note(take: &Take, outcome: &Outcome) -> String {
    let t = &outcome.trace;
    let root = t.root.name().word();
    let tension = number(take.conditions.physics.tension);
    let tilt = take.conditions.physics.ground.map_or(0.0, |g| g.up.y.clamp(-1.0, 1.0).acos().to_degrees());
    let most = take.conditions.tilts.iter().map(|t| t.tilt.to_degrees()).fold(0.0, f64::max);
    let tilt = match (tilt > 0.0, take.conditions.tilts.is_empty()) {
        (_, false) => format!(", ground tilts to {most:.0}°"),
        (true, true) => format!(", ground tilted by {tilt:.0}°"),
        (false, true) => String::new(),
    };
    let end = outcome.fall.as_ref().map_or(String::new(), |fall| format!("; {fall}"));
    format!(
        "{}: tension {tension}, root {root}, {} Hz, {} substeps{tilt}{end}",
        take.name,
        number(t.rate_hz),
        t.substeps
    )
}

/// From where a scene wants its strips seen.
pub fn strip_view(strip: &StripSpec) -> View {
    strip.yaw_deg.and_then(View::degrees).unwrap_or_default()
}

/// As the scene wants its strips.
fn options(take: &Take) -> StripOptions {
    let strip = &take.strip;
    StripOptions {
        count: strip.figures,
        from_s: strip.from_s,
        to_s: strip.to_s,
        view: strip_view(strip),
        ground_m: take.conditions.physics.ground.map(|g| g.height_m),
        colors: take.body.colors.clone(),
        props: take.conditions.props.clone(),
        ..StripOptions::default()
    }
}
