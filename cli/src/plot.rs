//! `plot`: a trace, a clip or a scene to figures.

use std::path::{Path, PathBuf};

use motion::names;
use motion::names::Word;
use takes::results::analysis_figures::{AnalysisFigure, Drawing};
use takes::results::analysis_write::{FigurePlace, figures_json, write_figures};
use takes::results::folder::Overwrite;
use takes::{AnalysisInput, AnalysisSource, analysis};

use crate::args::{Pick, PlotArgs};
use crate::failure::Failure;
use crate::output;
use crate::progress::progress;

/// Runs the command.
///
/// # Errors
/// Bad input, files that cannot be written.
pub fn run(args: &PlotArgs) -> Result<(), Failure> {
    let progress = progress();
    progress.part("reading");
    let mut motion = analysis::open(&args.input, args.dynamics.body.as_deref(), &args.clip.import())
        .map_err(Failure::input)?;
    refuse_clip_options(&args.input, &motion, args)?;
    if let Some(view) = args.view {
        motion.view = view;
    }
    progress.part("analysing");
    let analysis = motion.analyze(&args.dynamics.options());
    let analysis = analysis.as_ref().map_err(ToString::to_string);
    let sink_m = 1e-3 * args.dynamics.sink_mm;
    let mut drawing =
        Drawing::new(&motion, analysis, sink_m, args.mujoco.as_deref()).map_err(Failure::input)?;
    select(&mut drawing, args)?;
    let (figures, left_out) = figures(&drawing, args)?;
    if args.view.is_some() && !figures.contains(&AnalysisFigure::Strip) {
        return Err(Failure::Input(
            "--view is for film strips; none of the figures asked for is one (--what strip)".into(),
        ));
    }
    let place = place(args, &motion, &figures)?;
    progress.part("drawing");
    let overwrite = if args.force { Overwrite::Allow } else { Overwrite::Refuse };
    let reads: Vec<PathBuf> = [&args.input, &motion.path].into_iter().chain(&args.mujoco).cloned().collect();
    let (drawn, undrawn) = write_figures(&drawing, &figures, &place, overwrite, &reads, &progress)?;
    drop(progress);
    let text = if args.json {
        let value = figures_json(&motion, &drawn, &left_out);
        output::to_json(&value)?
    } else {
        let mut text = String::new();
        for figure in &drawn {
            let names: Vec<String> = figure.files.iter().map(|f| f.display().to_string()).collect();
            text += &format!("{:<10}{}\n", figure.figure.word(), names.join(", "));
        }
        text + &left_out.iter().map(|why| format!("left out: {why}\n")).collect::<String>()
    };
    output::print(&text)?;
    let dir = match &place {
        FigurePlace::Beside(dir) | FigurePlace::Folder(dir) | FigurePlace::File(dir) => dir,
    };
    output::undrawn(&undrawn, dir)
}

/// Refuses options of clips where they would do nothing.
fn refuse_clip_options(input: &Path, motion: &AnalysisInput, args: &PlotArgs) -> Result<(), Failure> {
    clip_options(input, motion, args.clip.given(), args.dynamics.body.is_some())?;
    match (&args.mujoco, motion.recorded()) {
        (Some(_), None) => Err(Failure::Input(format!(
            "--mujoco is for traces; {} is a {}, which no engine has run",
            input.display(),
            motion.source.name()
        ))),
        _ => Ok(()),
    }
}

/// Refuses `--units` and the like, and `--body`, for anything but a clip.
pub fn clip_options(
    input: &Path,
    motion: &AnalysisInput,
    given: Option<&'static str>,
    body: bool,
) -> Result<(), Failure> {
    let option = given.or(body.then_some("--body"));
    match (&motion.source, option) {
        (AnalysisSource::Clip(_), _) | (_, None) => Ok(()),
        (source, Some(option)) => Err(Failure::Input(format!(
            "{option} is for clips (.bvh); {} is a {}, which has its own body",
            input.display(),
            source.name()
        ))),
    }
}

/// Limits the drawing to the span, joints and feet asked for.
fn select(drawing: &mut Drawing, args: &PlotArgs) -> Result<(), Failure> {
    let end = drawing.duration_s();
    let (from, to) = (args.from_s.unwrap_or(0.0), args.to_s.unwrap_or(end));
    for (option, value) in [("--from-s", args.from_s), ("--to-s", args.to_s)] {
        if let Some(value) = value.filter(|v| !(0.0..=end + 1e-6).contains(v)) {
            return Err(Failure::Input(format!("{option} is {value} s; allowed: 0 to {end:.3} s")));
        }
    }
    if from >= to && end > 0.0 {
        return Err(Failure::Input(format!("--from-s is {from} s, --to-s {to} s; the first must be less")));
    }
    drawing.between(from, to);
    if !args.joints.is_empty() {
        let known = drawing.joints();
        let find = |name: &String| {
            known.iter().find(|(n, _)| n == name).map(|(_, link)| *link).ok_or_else(|| {
                let hint = names::hint(name, known.iter().map(|(n, _)| n.as_str()));
                Failure::Input(format!("--joints: no joint `{name}` moves in this body{hint}"))
            })
        };
        let links = args.joints.iter().map(find).collect::<Result<Vec<_>, _>>()?;
        drawing.only_joints(links);
    }
    if !args.feet.is_empty() {
        let known = drawing.feet();
        let find = |name: &String| {
            known.iter().find(|(leg, foot, _)| leg == name || foot == name).map(|f| f.2).ok_or_else(|| {
                let hint = names::hint(name, known.iter().map(|(leg, _, _)| leg.as_str()));
                Failure::Input(format!("--feet: no foot `{name}`{hint}"))
            })
        };
        let links = args.feet.iter().map(find).collect::<Result<Vec<_>, _>>()?;
        drawing.only_feet(links);
    }
    Ok(())
}

/// The figures to draw in order, and why others of `all` are left out.
fn figures(drawing: &Drawing, args: &PlotArgs) -> Result<(Vec<AnalysisFigure>, Vec<String>), Failure> {
    let all = args.what.contains(&Pick::All);
    let mut figures = Vec::new();
    let mut left_out = Vec::new();
    for figure in AnalysisFigure::all() {
        let asked = args.what.contains(&Pick::One(figure));
        match drawing.has(figure) {
            Ok(()) if asked || all => figures.push(figure),
            Err(why) if asked => return Err(Failure::Input(format!("--what {}: {why}", figure.word()))),
            Err(why) if all => left_out.push(why),
            _ => {}
        }
    }
    Ok((figures, left_out))
}

/// Where figures go.
fn place(
    args: &PlotArgs,
    motion: &AnalysisInput,
    figures: &[AnalysisFigure],
) -> Result<FigurePlace, Failure> {
    let Some(out) = &args.out else {
        let beside = motion.recorded().and_then(|_| motion.path.parent());
        let own = || Path::new("out").join(&motion.name);
        return Ok(FigurePlace::Beside(beside.map_or_else(own, Path::to_owned)));
    };
    match extension(out).as_str() {
        "svg" | "png" if figures.len() == 1 => Ok(FigurePlace::File(out.clone())),
        kind @ ("svg" | "png") => Err(Failure::Input(format!(
            "--out {} is one .{kind} file, but there are {} figures; allowed: one --what, or a folder",
            out.display(),
            figures.len()
        ))),
        "" => Ok(FigurePlace::Folder(out.clone())),
        _ if out.is_dir() => Ok(FigurePlace::Folder(out.clone())),
        other => Err(Failure::Input(format!(
            "--out {}: cannot write .{other}; allowed: .svg, .png, or a folder",
            out.display()
        ))),
    }
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}
