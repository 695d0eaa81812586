//! `render`: a scene or a clip to a folder of clips, trace, report and figures.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use motion::Clip;
use motion::format::{self, bvh, glb};
use scenes::{Report, Stage};

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::output::{self, Output};
use crate::progress::Progress;
use crate::{figures, summary};

/// Runs the command.
///
/// # Errors
/// Bad input, a run that cannot start or that diverged, files that cannot be written.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let mut progress = Progress::new();
    check(args)?;
    progress.part("staging");
    let overrides = args.overrides().map_err(Failure::input)?;
    let stage = scenes::open_with(&args.input, args.body.as_deref(), &args.clip.import(), &overrides)
        .map_err(Failure::input)?;
    let stage = if args.no_edits { stage.without_edits() } else { stage };
    let dir = args.out.clone().unwrap_or_else(|| Path::new("out").join(&stage.name));
    // an hour of simulation must not end at a locked door
    Output::check(&dir)?;
    progress.part("performing");
    let outcome = match args.kinematic {
        true => None,
        false => Some(stage.perform(&mut |done| progress.at(done)).map_err(Failure::run)?),
    };
    progress.part("writing");
    let mut report = Report::new(&stage, outcome.as_ref());
    let output = Output::begin(&dir)?;
    let mut folder = Folder { dir: output.dir().to_owned(), files: BTreeMap::new() };
    folder.motion("kinematic", &stage, &stage.kinematic)?;
    match &outcome {
        None => folder.body("kinematic", &stage, &stage.kinematic)?,
        Some(outcome) => {
            let performed = stage.at_frames(&outcome.trace.clip());
            folder.motion("dynamic", &stage, &performed)?;
            folder.body("dynamic", &stage, &performed)?;
            let path = folder.add("trace_npz", "trace.npz");
            outcome.trace.save_npz(&path).map_err(|e| cannot_write("trace.npz", &e))?;
        }
    }
    if !args.no_plots {
        progress.part("drawing");
        let plots = folder.dir.join(output::PLOTS);
        std::fs::create_dir(&plots).map_err(|e| cannot_write(output::PLOTS, &e))?;
        figures::draw(&stage, outcome.as_ref(), &mut |stem, figure, done| {
            figure.save(&plots, stem).map_err(Failure::run)?;
            for kind in ["svg", "png"] {
                folder.add(&format!("{stem}_{kind}"), &format!("{}/{stem}.{kind}", output::PLOTS));
            }
            progress.at(done);
            Ok(())
        })?;
    }
    folder.add("report_json", "report.json");
    report.files = folder.files;
    let json = report.to_json();
    format::write(&folder.dir.join("report.json"), json.as_bytes()).map_err(Failure::run)?;
    output.finish()?;
    drop(progress);
    output::print(&if args.json { json } else { summary::of(&stage, &report, &dir) })?;
    match report.dynamic.and_then(|d| d.diverged) {
        Some(why) => {
            Err(Failure::Run(format!("{why}; what was recorded until then is in {}", dir.display())))
        }
        None => Ok(()),
    }
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
    match option.filter(|_| is_scene) {
        Some(option) => {
            let path = args.input.display();
            Err(Failure::Input(format!(
                "{option} is for clips (.bvh); {path} is a scene, which names its own body"
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
        glb::write_file(&path, clip, &stage.solids(), &stage.name).map_err(Failure::run)
    }
}
