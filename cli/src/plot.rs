//! `plot`: a trace, a clip or a scene to figures.

use std::path::{Path, PathBuf};

use motion::names;
use scenes::study;
use serde_json::json;

use crate::args::{PlotArgs, What};
use crate::drawing::Drawing;
use crate::failure::Failure;
use crate::output::{self, Output};
use crate::progress::Progress;

/// Runs the command.
///
/// # Errors
/// Bad input, files that cannot be written.
pub fn run(args: &PlotArgs) -> Result<(), Failure> {
    let mut progress = Progress::new();
    progress.part("reading");
    let study = study::open(&args.input, args.dynamics.body.as_deref(), &args.clip.import())
        .map_err(Failure::input)?;
    refuse_clip_options(&args.input, &study, args)?;
    progress.part("analysing");
    let analysis = study.analyze(&args.dynamics.options());
    let analysis = analysis.as_ref().map_err(ToString::to_string);
    let mut drawing = Drawing::new(&study, analysis, &args.dynamics, args.mujoco.as_deref())?;
    select(&mut drawing, args)?;
    let (whats, left_out) = whats(&drawing, args)?;
    progress.part("drawing");
    let target = Target::of(args, &study, &whats)?;
    let mut figures = Vec::new();
    let mut said = String::new();
    let output = match &target {
        Target::Folder(dir) => Some(Output::replacing(dir, Vec::new())?),
        Target::File(_) => None,
    };
    for (i, &what) in whats.iter().enumerate() {
        let (figure, numbers) = drawing.draw(what);
        let files = match (&target, &output) {
            (Target::Folder(dir), Some(output)) => {
                let made = figure.save(output.dir(), what.stem()).map_err(Failure::run)?;
                made.map(|path| dir.join(path.file_name().unwrap_or_default())).to_vec()
            }
            (Target::Folder(path) | Target::File(path), _) => {
                let svg = extension(path) == "svg";
                let saved = if svg { figure.save_svg(path) } else { figure.save_png(path) };
                saved.map_err(Failure::run)?;
                vec![path.clone()]
            }
        };
        let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
        said += &format!("{:<10}{}\n", what.stem(), names.join(", "));
        figures.push(json!({ "what": what.stem(), "files": names, "numbers": numbers }));
        progress.at((i + 1) as f64 / whats.len() as f64);
    }
    if let Some(output) = output {
        output.finish()?;
    }
    drop(progress);
    for why in &left_out {
        said += &format!("left out: {why}\n");
    }
    output::print(&match args.json {
        false => said,
        true => {
            let value = json!({
                "name": study.name,
                "source": study.source.name(),
                "figures": figures,
                "left_out": left_out,
            });
            serde_json::to_string_pretty(&value).map_err(Failure::run)? + "\n"
        }
    })
}

/// Refuses options of clips where they would do nothing.
fn refuse_clip_options(input: &Path, study: &scenes::Study, args: &PlotArgs) -> Result<(), Failure> {
    clip_options(input, study, args.clip.given(), args.dynamics.body.is_some())?;
    match (&args.mujoco, study.recorded()) {
        (Some(_), None) => Err(Failure::Input(format!(
            "--mujoco is for traces; {} is a {}, which no engine has run",
            input.display(),
            study.source.name()
        ))),
        _ => Ok(()),
    }
}

/// Refuses `--units` and the like, and `--body`, for anything but a clip.
pub fn clip_options(
    input: &Path,
    study: &scenes::Study,
    given: Option<&'static str>,
    body: bool,
) -> Result<(), Failure> {
    let option = given.or(body.then_some("--body"));
    match (&study.source, option) {
        (scenes::StudySource::Clip(_), _) | (_, None) => Ok(()),
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
fn whats(drawing: &Drawing, args: &PlotArgs) -> Result<(Vec<What>, Vec<String>), Failure> {
    let all = args.what.contains(&What::All);
    let mut whats = Vec::new();
    let mut left_out = Vec::new();
    for what in What::EACH {
        let asked = args.what.contains(&what);
        match drawing.has(what) {
            Ok(()) if asked || all => whats.push(what),
            Err(why) if asked => return Err(Failure::Input(format!("--what {}: {why}", what.stem()))),
            Err(why) if all => left_out.push(why),
            _ => {}
        }
    }
    Ok((whats, left_out))
}

/// Where figures go.
enum Target {
    Folder(PathBuf),
    File(PathBuf),
}

impl Target {
    fn of(args: &PlotArgs, study: &scenes::Study, whats: &[What]) -> Result<Self, Failure> {
        let Some(out) = &args.out else {
            let beside = study.recorded().and_then(|_| study.path.parent());
            return Ok(Self::Folder(match beside {
                Some(folder) => folder.join(output::PLOTS),
                None => Path::new("out").join(&study.name).join(output::PLOTS),
            }));
        };
        match extension(out).as_str() {
            "svg" | "png" if whats.len() == 1 => {
                if let Some(folder) = out.parent().filter(|f| !f.as_os_str().is_empty()) {
                    std::fs::create_dir_all(folder)
                        .map_err(|e| Failure::run(format!("cannot write into {}: {e}", folder.display())))?;
                }
                Ok(Self::File(out.clone()))
            }
            kind @ ("svg" | "png") => Err(Failure::Input(format!(
                "--out {} is one .{kind} file, but there are {} figures; allowed: one --what, or a folder",
                out.display(),
                whats.len()
            ))),
            "" => Ok(Self::Folder(out.clone())),
            _ if out.is_dir() => Ok(Self::Folder(out.clone())),
            other => Err(Failure::Input(format!(
                "--out {}: cannot write .{other}; allowed: .svg, .png, or a folder",
                out.display()
            ))),
        }
    }
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}
