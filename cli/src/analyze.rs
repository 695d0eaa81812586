//! `analyze`: a clip to the forces it needs, as numbers, tables and figures.

use std::path::PathBuf;

use takes::analysis;
use takes::results::analysis_write::AnalysisWhat;

use crate::analysis_text;
use crate::args::AnalyzeArgs;
use crate::failure::Failure;
use crate::output;
use crate::plot::clip_options;
use crate::progress::progress;

/// Runs the command.
///
/// # Errors
/// Bad input, files that cannot be written.
pub fn run(args: &AnalyzeArgs) -> Result<(), Failure> {
    let progress = progress();
    progress.part("reading");
    let mut input = analysis::open(&args.input, args.dynamics.body.as_deref(), &args.clip.import())
        .map_err(Failure::input)?;
    clip_options(&args.input, &input, args.clip.given(), args.dynamics.body.is_some())?;
    if let Some(view) = args.view {
        input.view = view;
    }
    progress.part("analysing");
    let analysis = input.analyze(&args.dynamics.options()).map_err(Failure::input)?;
    let dir = output::folder(args.out.as_deref(), &format!("{}-analysis", input.name));
    let reads: Vec<PathBuf> = args.dynamics.body.iter().chain([&args.input]).cloned().collect();
    let what = AnalysisWhat {
        tables: args.format.clone(),
        sink_m: (!args.no_plots).then_some(1e-3 * args.dynamics.sink_mm),
        reads,
    };
    let written = input.write(&analysis, &dir, &what, &progress)?;
    drop(progress);
    let report = &written.report;
    output::print(&if args.json { report.to_json() } else { analysis_text::of(&input, report, &dir) })?;
    output::undrawn(&written.undrawn, &dir)
}
