//! Which figures a run gets.

use plots::{Figure, StripOptions, StripRow, film_strip_with};
use scenes::{Outcome, Stage};

use crate::failure::Failure;

/// The motion asked for without its edits, above the same with them.
const STRIP_EDITED: &str = "strip_edited";
/// The motion asked for, above the one performed.
const STRIP_DYNAMIC: &str = "strip_dynamic";
const JOINT_ANGLES: &str = "joint_angles";
const GAINS_AND_TORQUES: &str = "gains_and_torques";
const CONTACT_FORCES: &str = "contact_forces";
const CENTER_OF_MASS: &str = "center_of_mass";
const MOMENTUM_RESIDUAL: &str = "momentum_residual";

/// Names of all figures a run may get.
pub const STEMS: &[&str] = &[
    STRIP_EDITED,
    STRIP_DYNAMIC,
    JOINT_ANGLES,
    GAINS_AND_TORQUES,
    CONTACT_FORCES,
    CENTER_OF_MASS,
    MOMENTUM_RESIDUAL,
];

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
        let trace = &outcome.trace;
        let note = note(stage, outcome);
        let page = |draw: fn(_, &str) -> Figure| {
            let note = note.clone();
            Box::new(move || draw(trace, &note))
        };
        figures.push((STRIP_DYNAMIC, Box::new(|| strip_of_run(stage, outcome))));
        figures.push((JOINT_ANGLES, page(plots::joint_angles)));
        figures.push((GAINS_AND_TORQUES, page(plots::gains_and_torques)));
        if trace.ground_m.is_some() {
            figures.push((CONTACT_FORCES, page(plots::contact_forces)));
        }
        figures.push((CENTER_OF_MASS, page(plots::center_of_mass)));
        figures.push((MOMENTUM_RESIDUAL, page(plots::momentum_residual)));
    }
    let count = figures.len() as f64;
    for (i, (stem, figure)) in figures.iter().enumerate() {
        save(stem, &figure(), (i + 1) as f64 / count)?;
    }
    Ok(())
}

fn strip_of_edits(stage: &Stage) -> Figure {
    let rows = [
        StripRow { label: "unedited", clip: &stage.unedited },
        StripRow { label: "edited", clip: &stage.kinematic },
    ];
    let note = format!("{}: {}", stage.name, stage.log.edits().join(", then "));
    film_strip_with(&rows, &stage.character, &note, &options(stage))
}

fn strip_of_run(stage: &Stage, outcome: &Outcome) -> Figure {
    let performed = stage.at_frames(&outcome.trace.clip());
    let rows = [
        StripRow { label: "kinematic", clip: &stage.kinematic },
        StripRow { label: "dynamic", clip: &performed },
    ];
    film_strip_with(&rows, &stage.character, &note(stage, outcome), &options(stage))
}

/// What tells one run of a scene from another.
fn note(stage: &Stage, outcome: &Outcome) -> String {
    let t = &outcome.trace;
    format!("{}: tension {}, {} Hz × {}", stage.name, stage.physics.tension, t.rate_hz, t.substeps)
}

/// As the scene wants its strips.
fn options(stage: &Stage) -> StripOptions {
    let strip = &stage.strip;
    StripOptions {
        count: strip.figures,
        from_s: strip.from_s,
        to_s: strip.to_s,
        ground_m: stage.physics.ground.map(|g| g.height_m),
        ..StripOptions::default()
    }
}
