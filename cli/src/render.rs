//! `render`: a scene or a clip to a folder of clips, trace, report and figures.

use takes::{LookAhead, What};

use crate::args::RenderArgs;
use crate::engines::engines;
use crate::failure::Failure;
use crate::output;
use crate::progress::progress;
use crate::{pareto, summary};

/// Runs the command.
///
/// # Errors
/// Bad input, a run that cannot start or that diverged, files that cannot be written.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    check(args)?;
    if let Some(fidelities) = &args.pareto {
        return pareto::run(args, fidelities);
    }
    let progress = progress();
    progress.part("staging");
    let mut ask = args.ask().map_err(Failure::input)?;
    if let Some(path) = &args.replay {
        ask.foresight = LookAhead::As(takes::replay::replay(path).map_err(Failure::input)?);
    }
    let mut take = takes::open(args.input.as_path(), &ask)?;
    if matches!(ask.foresight, LookAhead::As(_)) && !take.looks_ahead() {
        return Err(Failure::Input(format!(
            "{} has nothing to foresee: --foresight and --replay are for motion that steps (clips, retargeted motion, scripts with footwork or keys on a leg), over ground, with --root free",
            args.input.display()
        )));
    }
    if let Some(view) = args.view {
        take.strip.yaw_deg = Some(view.yaw_deg());
    }
    let dir = output::folder(args.out.as_deref(), &take.name);
    let what = What { figures: !args.no_plots, reads: args.reads() };
    let engines = engines();
    take.engine(&engines)?;
    // check the folder first, so that a bad path fails before the simulation
    take.check(&dir, &what, args.kinematic)?;
    let performed = if args.kinematic { take.preview() } else { take.perform(&engines, &progress)? };
    let written = performed.write(&dir, &what, &progress)?;
    drop(progress);
    let report = &written.report;
    output::print(&if args.json { report.to_json() } else { summary::of(&performed.take, report, &dir) })?;
    if let Some(why) = performed.diverged() {
        let dir = dir.display();
        return Err(Failure::Run(format!("{why}; what was recorded until then is in {dir}")));
    }
    output::undrawn(&written.undrawn, &dir)
}

/// Refuses options that would do nothing.
fn check(args: &RenderArgs) -> Result<(), Failure> {
    let is_scene = takes::is_ron(&args.input);
    if args.no_edits && !is_scene {
        let path = args.input.display();
        return Err(Failure::Input(format!(
            "--no-edits is for scenes (.ron); {path} is a clip without edits"
        )));
    }
    let option = args.clip.given().or(args.body.as_ref().map(|_| "--body"));
    let option = option.or(args.span.map(|_| "--span"));
    let option = option.or((!args.edit.is_empty()).then_some("--edit"));
    match option.filter(|_| is_scene) {
        Some(option) => {
            let path = args.input.display();
            Err(Failure::Input(format!(
                "{option} is for clips (.bvh); {path} is a scene, which names its own body and edits and is performed whole"
            )))
        }
        None => Ok(()),
    }
}
