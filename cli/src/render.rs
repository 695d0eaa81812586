//! `render`: a scene or a clip to a folder of clips, trace, report and figures.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use motion::Clip;
use motion::format::{self, bvh, glb};
use scenes::report::span_folder;
use scenes::{Outcome, Report, Stage};

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::output::{self, Output};
use crate::progress::Progress;
use crate::{figures, pareto, summary};

/// Runs the command.
///
/// # Errors
/// Bad input, a run that cannot start or that diverged, files that cannot be written.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    check(args)?;
    if let Some(fidelities) = &args.pareto {
        return pareto::run(args, fidelities);
    }
    let mut progress = Progress::new();
    progress.part("staging");
    let overrides = args.overrides().map_err(Failure::input)?;
    let stage = scenes::open_with(&args.input, args.body.as_deref(), &args.clip.import(), &overrides)
        .map_err(Failure::input)?;
    let stage = if args.no_edits { stage.without_edits() } else { stage };
    let dir = args.out.clone().unwrap_or_else(|| Path::new("out").join(&stage.name));
    // an hour of simulation must not end at a locked door
    Output::check(&dir)?;
    let (mut report, progress) = if !args.kinematic && stage.stands_in_parts() {
        render_parts(args, &stage, &dir, progress)?
    } else {
        render_whole(args, &stage, &dir, progress)?
    };
    drop(progress);
    output::print(&if args.json { report.to_json() } else { summary::of(&stage, &report, &dir) })?;
    let parts = report.spans.iter_mut().flatten().filter_map(|s| s.dynamic.take());
    match report.dynamic.take().into_iter().chain(parts).find_map(|d| d.diverged) {
        Some(why) => {
            Err(Failure::Run(format!("{why}; what was recorded until then is in {}", dir.display())))
        }
        None => Ok(()),
    }
}

fn render_whole(
    args: &RenderArgs,
    stage: &Stage,
    dir: &Path,
    mut progress: Progress,
) -> Result<(Report, Progress), Failure> {
    progress.part("performing");
    let outcome = match args.kinematic {
        true => None,
        false => Some(stage.perform(&mut |done| progress.at(done)).map_err(Failure::run)?),
    };
    progress.part("writing");
    let mut report = Report::new(stage, outcome.as_ref());
    let output = Output::begin(dir)?;
    let mut folder = Folder::new(output.dir());
    folder.fill(stage, outcome.as_ref(), args, &mut progress)?;
    folder.finish(&mut report)?;
    output.finish()?;
    Ok((report, progress))
}

/// Every standing span by itself, each in a folder of its own.
fn render_parts(
    args: &RenderArgs,
    stage: &Stage,
    dir: &Path,
    mut progress: Progress,
) -> Result<(Report, Progress), Failure> {
    progress.part("performing");
    let bar = Mutex::new(progress);
    let tell = |done: f64| {
        if let Ok(mut bar) = bar.lock() {
            bar.at(done);
        }
    };
    let performed = stage.perform_standing(&tell).map_err(Failure::run)?;
    let mut progress = bar.into_inner().unwrap_or_else(PoisonError::into_inner);
    progress.part("writing");
    let mut report = Report::of_spans(stage, &performed);
    let output = Output::begin(dir)?;
    let mut folder = Folder::new(output.dir());
    folder.motion("kinematic", stage, &stage.kinematic)?;
    for (k, part) in performed.iter().enumerate() {
        let name = span_folder(k);
        let mut inner = Folder::new(&output.dir().join(&name));
        std::fs::create_dir(&inner.dir).map_err(|e| cannot_write(&name, &e))?;
        inner.fill(&part.stage, Some(&part.outcome), args, &mut progress)?;
        inner.finish(&mut Report::new(&part.stage, Some(&part.outcome)))?;
        let files =
            inner.files.iter().map(|(what, file)| (format!("{name}_{what}"), format!("{name}/{file}")));
        folder.files.extend(files);
    }
    folder.finish(&mut report)?;
    output.finish()?;
    Ok((report, progress))
}

/// Refuses options that would do nothing.
fn check(args: &RenderArgs) -> Result<(), Failure> {
    let is_scene = args.input.extension().is_some_and(|e| e.eq_ignore_ascii_case("ron"));
    if args.no_edits && !is_scene {
        let path = args.input.display();
        return Err(Failure::Input(format!(
            "--no-edits is for scenes (.ron); {path} is a clip without edits"
        )));
    }
    let option = args.clip.given().or(args.body.as_ref().map(|_| "--body"));
    let option = option.or(args.span.map(|_| "--span"));
    match option.filter(|_| is_scene) {
        Some(option) => {
            let path = args.input.display();
            Err(Failure::Input(format!(
                "{option} is for clips (.bvh); {path} is a scene, which names its own body and is performed whole"
            )))
        }
        None => Ok(()),
    }
}

fn cannot_write(name: &str, e: &std::io::Error) -> Failure {
    Failure::Run(format!("cannot write {name}: {e}"))
}

/// The folder being filled, and what is in it.
struct Folder {
    dir: PathBuf,
    files: BTreeMap<String, String>,
}

impl Folder {
    fn new(dir: &Path) -> Self {
        Self { dir: dir.to_owned(), files: BTreeMap::new() }
    }

    /// Everything a run leaves but its report.
    fn fill(
        &mut self,
        stage: &Stage,
        outcome: Option<&Outcome>,
        args: &RenderArgs,
        progress: &mut Progress,
    ) -> Result<(), Failure> {
        self.motion("kinematic", stage, &stage.kinematic)?;
        match outcome {
            None => self.body("kinematic", stage, &stage.kinematic)?,
            Some(outcome) => {
                let performed = stage.at_frames(&outcome.trace.clip());
                self.motion("dynamic", stage, &performed)?;
                self.body("dynamic", stage, &performed)?;
                let path = self.add("trace_npz", "trace.npz");
                outcome.trace.save_npz(&path).map_err(|e| cannot_write("trace.npz", &e))?;
            }
        }
        if args.no_plots {
            return Ok(());
        }
        progress.part("drawing");
        let plots = self.dir.join(output::PLOTS);
        std::fs::create_dir(&plots).map_err(|e| cannot_write(output::PLOTS, &e))?;
        figures::draw(stage, outcome, &mut |stem, figure, done| {
            figure.save(&plots, stem).map_err(Failure::run)?;
            for kind in ["svg", "png"] {
                self.add(&format!("{stem}_{kind}"), &format!("{}/{stem}.{kind}", output::PLOTS));
            }
            progress.at(done);
            Ok(())
        })
    }

    /// Writes the report, which knows all files.
    fn finish(&mut self, report: &mut Report) -> Result<(), Failure> {
        let path = self.add("report_json", "report.json");
        report.files.clone_from(&self.files);
        format::write(&path, report.to_json().as_bytes()).map_err(Failure::run)
    }

    fn add(&mut self, what: &str, name: &str) -> PathBuf {
        self.files.insert(what.into(), name.into());
        self.dir.join(name)
    }

    /// A clip of the character as BVH, with all joints of the clip it came from and in its unit.
    fn motion(&mut self, stem: &str, stage: &Stage, clip: &Clip) -> Result<(), Failure> {
        let path = self.add(&format!("{stem}_bvh"), &format!("{stem}.bvh"));
        let options = bvh::WriteOptions { metres_per_unit: stage.metres_per_unit(), ..Default::default() };
        bvh::write_file(&path, &stage.for_files(clip), &options).map_err(Failure::run)
    }

    /// A clip of the character as GLB, with its solids.
    fn body(&mut self, stem: &str, stage: &Stage, clip: &Clip) -> Result<(), Failure> {
        let path = self.add(&format!("{stem}_glb"), &format!("{stem}.glb"));
        glb::write_file(&path, clip, &stage.solids(), &stage.colors, &stage.name).map_err(Failure::run)
    }
}
