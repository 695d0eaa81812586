//! Which figures a run gets.

use motion::Vec3;
use plots::{Figure, StripOptions, StripRow, film_strip_with};
use scenes::{Outcome, Stage};

use crate::failure::Failure;

/// The motion asked for without its edits, above the same with them.
const STRIP_EDITED: &str = "strip_edited";
/// The motion asked for, above the one performed.
const STRIP_DYNAMIC: &str = "strip_dynamic";

/// A figure of the trace alone: its name and who draws it.
type OfTrace = (&'static str, fn(&scenes::Trace, &str) -> Figure);

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

/// Takes a figure: its name, how to draw it.
type Draw<'a> = (&'static str, Box<dyn Fn() -> Figure + 'a>);

/// Draws the figures of a run one by one; `save` gets the name, the figure and the fraction done.
///
/// # Errors
/// Those of `save`.
pub fn draw(
    stage: &Stage,
    outcome: Option<&Outcome>,
    save: &mut dyn FnMut(&str, &Figure, f64) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let mut figures: Vec<Draw> = Vec::new();
    if !stage.log.edits().is_empty() {
        figures.push((STRIP_EDITED, Box::new(|| strip_of_edits(stage))));
    }
    if let Some(outcome) = outcome {
        figures.push((STRIP_DYNAMIC, Box::new(|| strip_of_run(stage, outcome))));
        for &(stem, draw) in OF_TRACE {
            figures.push((stem, Box::new(move || draw(&outcome.trace, &note(stage, outcome)))));
        }
    }
    let count = figures.len() as f64;
    for (i, (stem, figure)) in figures.iter().enumerate() {
        save(stem, &figure(), (i + 1) as f64 / count)?;
    }
    Ok(())
}

fn strip_of_edits(stage: &Stage) -> Figure {
    let up = ground_up(stage);
    let rows = [
        StripRow::new("unedited", &stage.unedited).on(&up),
        StripRow::new("edited", &stage.kinematic).on(&up),
    ];
    let note = format!("{}: {}", stage.name, stage.log.edits().join(", then "));
    film_strip_with(&rows, &stage.character, &note, &options(stage))
}

fn strip_of_run(stage: &Stage, outcome: &Outcome) -> Figure {
    let (up, performed) = (ground_up(stage), outcome.trace.clip());
    let rows = [
        StripRow::new("kinematic", &stage.kinematic).on(&up),
        StripRow::new("dynamic", &performed).on(&outcome.trace.disturbed.ground_up),
    ];
    film_strip_with(&rows, &stage.character, &note(stage, outcome), &options(stage))
}

/// Normal of the ground as the motion asked for has it.
fn ground_up(stage: &Stage) -> Vec<Vec3> {
    stage.physics.ground.iter().map(|g| g.up).collect()
}

/// What a figure should say under its title.
fn note(stage: &Stage, outcome: &Outcome) -> String {
    let t = &outcome.trace;
    let root = match t.root {
        scenes::RootMode::Free => "free",
        scenes::RootMode::Assisted { .. } => "assisted",
        scenes::RootMode::Pinned => "pinned",
    };
    let tension = crate::summary::number(stage.physics.tension);
    let tilt = stage.physics.ground.map_or(0.0, |g| g.up.y.clamp(-1.0, 1.0).acos().to_degrees());
    let most = stage.tilts.iter().map(|t| t.tilt.to_degrees()).fold(0.0, f64::max);
    let tilt = match (tilt > 0.0, stage.tilts.is_empty()) {
        (_, false) => format!(", ground tilts to {most:.0}°"),
        (true, true) => format!(", ground tilted by {tilt:.0}°"),
        (false, true) => String::new(),
    };
    let end = outcome.fall.as_ref().map_or(String::new(), |fall| format!("; {fall}"));
    format!(
        "{}: tension {tension}, root {root}, {} Hz, {} substeps{tilt}{end}",
        stage.name, t.rate_hz, t.substeps
    )
}

/// As the scene wants its strips.
fn options(stage: &Stage) -> StripOptions {
    let strip = &stage.strip;
    StripOptions {
        count: strip.figures,
        from_s: strip.from_s,
        to_s: strip.to_s,
        yaw_deg: strip.yaw_deg,
        ground_m: stage.physics.ground.map(|g| g.height_m),
        colors: stage.colors.clone(),
        ..StripOptions::default()
    }
}
