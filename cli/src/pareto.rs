//! `render --pareto`: what a motion costs in help from outside, and what the help buys.

use std::fmt::Write;
use std::path::Path;

use studies::pareto::{self, FIDELITIES, Pareto, results};
use takes::overrides::RootChoice;
use takes::results::folder::Folder;
use takes::results::number;
use takes::{Ask, Overrides};

use crate::args::RenderArgs;
use crate::engines::engines;
use crate::failure::Failure;
use crate::output;
use crate::progress::progress;

/// Runs the curve; no fidelities are the default ones.
///
/// # Errors
/// Bad input, passes that cannot start, files that cannot be written.
pub fn run(args: &RenderArgs, fidelities: &[f64]) -> Result<(), Failure> {
    let progress = progress();
    progress.part("staging");
    let ask = args.ask().map_err(Failure::input)?;
    // not pinned: a clip that stands is asked for on planted feet
    let ask = Ask { overrides: Overrides { root: Some(RootChoice::Free), ..ask.overrides }, ..ask };
    let take = takes::open(args.input.as_path(), &ask)?;
    let dir = output::folder(args.out.as_deref(), &format!("{}-pareto", take.name));
    let reads: Vec<_> = take.files.iter().cloned().chain(args.reads()).collect();
    Folder::check(&dir, &results::plan(&reads))?;
    let engines = engines();
    let engine = take.engine(&engines)?;
    progress.part("performing");
    let fidelities = if fidelities.is_empty() { &FIDELITIES[..] } else { fidelities };
    let mut curve = pareto::pareto(&take, fidelities, engine, &|x| progress.at(x)).map_err(Failure::run)?;
    let undrawn = curve.write(&dir, !args.no_plots, &reads, &progress)?;
    drop(progress);
    output::print(&if args.json { curve.to_json() } else { summary(&curve, &dir) })?;
    output::undrawn(&undrawn, &dir)
}

fn summary(curve: &Pareto, dir: &Path) -> String {
    let mut text = String::new();
    // writing to a String cannot fail
    let _ = write(&mut text, curve, dir);
    text
}

fn write(out: &mut String, curve: &Pareto, dir: &Path) -> std::fmt::Result {
    let stand = curve.points.iter().filter(|p| p.stands());
    let first = stand.map(|p| p.fidelity).next();
    match first {
        Some(0.0) => {
            writeln!(out, "{}: stands free; help from outside only brings it closer\n", curve.scene)?
        }
        Some(f) => writeln!(out, "{}: stands from fidelity {} on\n", curve.scene, number(f))?,
        None => writeln!(out, "{}: THE BODY FELL at every fidelity\n", curve.scene)?,
    }
    writeln!(
        out,
        "  fidelity    budget    force RMS (of weight)      peak    moment RMS   links    joints  then"
    )?;
    for p in &curve.points {
        let closer = if p.stands() && !p.efficient { "; less help follows closer" } else { "" };
        let then = format!("{}{closer}", p.verdict.text);
        writeln!(
            out,
            "  {:>8} {:>7.1} N  {:>7.2} N   ({:>6} %) {:>9.1} N {:>9.2} N·m {:>5.0} mm {:>7.2}°  {then}",
            number(p.fidelity),
            p.force_budget_n,
            p.force_rms_n,
            p.force_rms_percent_bw.map_or_else(|| "-".into(), |x| format!("{x:.2}")),
            p.force_peak_n,
            p.moment_rms_nm,
            p.position_rms_mm,
            p.joint_rms_deg,
        )?;
    }
    let files: Vec<String> = curve.files.values().map(|f| dir.join(f).display().to_string()).collect();
    writeln!(out, "\n  files      {}", files.join("\n             "))
}
