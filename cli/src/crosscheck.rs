//! `crosscheck`: forces, ours and MuJoCo's, as a table, a page and JSON.

use std::path::{Path, PathBuf};

use crosscheck::{CrossCheck, Event, Options, report, results};
use takes::LookAhead;
use takes::results::folder::Folder;

use crate::args::CrosscheckArgs;
use crate::failure::Failure;
use crate::output;
use crate::progress::progress;

/// Runs the command.
///
/// # Errors
/// Bad input, no MuJoCo, engines that fail, checks that fail.
pub fn run(args: &CrosscheckArgs) -> Result<(), Failure> {
    let progress = progress();
    let stem = args.input.file_stem().map_or_else(|| "model".into(), |s| s.to_string_lossy().into_owned());
    let dir = output::folder(args.out.as_deref(), &format!("{stem}-crosscheck"));
    let reads: Vec<PathBuf> =
        [&args.input].into_iter().chain(&args.patch).chain(&args.against).cloned().collect();
    Folder::check(&dir, &results::plan(&reads))?;
    let options = Options {
        seed: args.seed,
        states: args.states,
        dynamics_only: args.dynamics_only,
        against: args.against.clone(),
        inject: args.inject.clone(),
        states_only: args.states_only,
        push_map: args.push_map.then(|| args.settings()),
        root: args.root,
        tension: args.tension,
        foresight: args.root.as_ref().map_or(LookAhead::Usual, |_| args.foresight.into()),
        patch: crate::args::patch(args.patch.as_deref()).map_err(Failure::input)?,
    };
    let mut part = "";
    let done = crosscheck::run(&args.input, &options, &mut |event| match event {
        Event::Note(text) => eprintln!("{text}"),
        Event::Part(name, _) if name != part => {
            part = name;
            progress.part(name);
        }
        Event::Part(_, fraction) => progress.at(fraction),
    });
    let cross = done?;
    progress.part("writing");
    let undrawn = results::write(&cross, &dir, &reads, &progress)?;
    drop(progress);
    let json = report::json(&cross);
    output::print(&if args.json { json } else { summary(&cross, &dir) })?;
    output::undrawn(&undrawn, &dir)?;
    match cross.failed() {
        0 => Ok(()),
        n => {
            let names: Vec<String> = cross
                .checks
                .iter()
                .filter(|c| !c.pass)
                .map(|c| format!("{} ({})", c.quantity, c.at))
                .collect();
            let all = cross.checks.len();
            Err(Failure::Run(format!("{n} of {all} checks fail: {}", names.join("; "))))
        }
    }
}

fn summary(cross: &CrossCheck, dir: &Path) -> String {
    let (name, mujoco) = (&cross.name, &cross.mujoco);
    let verdict = match (cross.failed(), cross.checks.len()) {
        (0, 0) => format!("{name}: nothing to compare with MuJoCo {mujoco}"),
        (0, all) => format!("{name}: all {all} checks against MuJoCo {mujoco} pass"),
        (n, all) => format!("{name}: {n} of {all} checks against MuJoCo {mujoco} FAIL"),
    };
    let table = report::text(cross);
    let page = dir.join("crosscheck.html");
    format!(
        "{verdict} ({} random states, seed {})\n\n{table}\nwritten  {}\n",
        cross.states,
        cross.seed,
        page.display()
    )
}
