//! `analyze`: a clip to the forces it needs, as numbers, tables and figures.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use motion::format;
use scenes::{Analysis, AnalysisReport, analysis_files, study};

use crate::analysis_text;
use crate::args::{AnalyzeArgs, Format, What};
use crate::drawing::Drawing;
use crate::failure::Failure;
use crate::output::{self, Output};
use crate::plot::clip_options;
use crate::progress::Progress;

/// Files an analysis may leave in its folder, besides figures.
const OURS: &[&str] = &["analysis.csv", "torques.mot", "ground_forces.mot", "analysis.npz", "report.json"];

/// Runs the command.
///
/// # Errors
/// Bad input, files that cannot be written.
pub fn run(args: &AnalyzeArgs) -> Result<(), Failure> {
    let mut progress = Progress::new();
    progress.part("reading");
    let study = study::open(&args.input, args.dynamics.body.as_deref(), &args.clip.import())
        .map_err(Failure::input)?;
    clip_options(&args.input, &study, args.clip.given(), args.dynamics.body.is_some())?;
    progress.part("analysing");
    let analysis = study.analyze(&args.dynamics.options()).map_err(Failure::input)?;
    let mut report = AnalysisReport::new(&study, &analysis);
    let dir = args.out.clone().unwrap_or_else(|| Path::new("out").join(format!("{}-analysis", study.name)));

    progress.part("writing");
    let output = Output::replacing(&dir, ours())?;
    let mut files = BTreeMap::new();
    for format in &args.format {
        for (key, name, bytes) in made(*format, &analysis)? {
            files.insert(key.to_owned(), name.to_owned());
            format::write(&output.dir().join(name), &bytes).map_err(Failure::run)?;
        }
    }
    if !args.no_plots {
        progress.part("drawing");
        let drawing = Drawing::new(&study, Ok(&analysis), &args.dynamics, None)?;
        let plots = output.dir().join(output::PLOTS);
        std::fs::create_dir(&plots)
            .map_err(|e| Failure::run(format!("cannot write {}: {e}", output::PLOTS)))?;
        let whats: Vec<What> = What::EACH.into_iter().filter(|w| drawing.has(*w).is_ok()).collect();
        for (i, what) in whats.iter().enumerate() {
            drawing.draw(*what).0.save(&plots, what.stem()).map_err(Failure::run)?;
            for kind in ["svg", "png"] {
                let stem = what.stem();
                files.insert(format!("{stem}_{kind}"), format!("{}/{stem}.{kind}", output::PLOTS));
            }
            progress.at((i + 1) as f64 / whats.len() as f64);
        }
    }
    files.insert("report_json".into(), "report.json".into());
    report.files = files;
    let json = report.to_json();
    format::write(&output.dir().join("report.json"), json.as_bytes()).map_err(Failure::run)?;
    output.finish()?;
    drop(progress);
    output::print(&if args.json { json } else { analysis_text::of(&study, &report, &dir) })
}

/// Files of a format: what they hold, name, bytes.
fn made(format: Format, a: &Analysis) -> Result<Vec<(&'static str, &'static str, Vec<u8>)>, Failure> {
    Ok(match format {
        Format::Csv => vec![("analysis_csv", "analysis.csv", analysis_files::csv(a).into_bytes())],
        Format::Mot => vec![
            ("torques_mot", "torques.mot", analysis_files::torques_mot(a).into_bytes()),
            ("ground_forces_mot", "ground_forces.mot", analysis_files::ground_forces_mot(a).into_bytes()),
        ],
        Format::Npz => {
            let mut out = Cursor::new(Vec::new());
            analysis_files::write_npz(a, &mut out)
                .map_err(|e| Failure::Run(format!("cannot write analysis.npz: {e}")))?;
            vec![("analysis_npz", "analysis.npz", out.into_inner())]
        }
    })
}

/// Every file an analysis may leave, relative to its folder.
fn ours() -> Vec<PathBuf> {
    let figures = What::EACH.into_iter().flat_map(|w| {
        ["svg", "png"].map(|kind| Path::new(output::PLOTS).join(format!("{}.{kind}", w.stem())))
    });
    OURS.iter().map(PathBuf::from).chain(figures).collect()
}
