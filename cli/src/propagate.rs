//! `propagate`: an edit learned from a few edited seconds, applied to other motion, corrected, learned again.

use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use formats::glb;
use formats::table::{ClipOut, endings};
use motion::Clip;
use serde_json::json;
use studies::propagate::apply::{self, Use};
use studies::propagate::project::{self, Change, Project};
use studies::propagate::{EditOptions, Learning, Pair, PropagateError, Where, report};
use takes::results::folder::{check_file, write_file};

use crate::failure::Failure;
use crate::output;
use crate::progress::progress;
use crate::propagate_args::{
    ApplyArgs, CorrectArgs, ExportArgs, PairArgs, PropagateArgs, StatusArgs, Step, TrainArgs,
};

/// Runs the command.
///
/// # Errors
/// Bad input, pairs that cannot be learned from, files that cannot be written.
pub fn run(args: &PropagateArgs) -> Result<(), Failure> {
    match &args.step {
        Step::New(args) => {
            // pairs that do not go together leave no project behind
            let (pair, options) = (pair(args)?, EditOptions::default());
            project::check(&pair, &options)?;
            add(&Project::create(&args.project, options)?, args, &pair)
        }
        Step::Add(args) => add(&Project::open(&args.project)?, args, &pair(args)?),
        Step::Train(args) => train(args),
        Step::Apply(args) => apply(args),
        Step::Export(args) => export(args),
        Step::Correct(args) => correct(args),
        Step::Status(args) => status(args),
    }
}

/// The pair that arguments name.
fn pair(args: &PairArgs) -> Result<Pair, Failure> {
    let name = name(args.name.as_ref(), &args.target);
    let (source, target) = (project::open(&args.source)?, project::open(&args.target)?);
    Ok(Pair { spans_s: args.spans.clone(), context: args.context.clone(), ..Pair::new(name, source, target) })
}

fn name(given: Option<&String>, file: &Path) -> String {
    given.cloned().unwrap_or_else(|| file.file_stem().unwrap_or_default().to_string_lossy().into_owned())
}

fn add(project: &Project, args: &PairArgs, pair: &Pair) -> Result<(), Failure> {
    let file = project.add(pair, &args.source, &args.target)?;
    let edited = project::changes(&pair.source, &pair.target);
    let mut text = match &edited {
        Ok(changes) => describe(changes),
        Err(PropagateError::NothingChanged) => {
            "the target is the source: this pair teaches to change nothing\n".into()
        }
        Err(e) => return Err(Failure::input(e)),
    };
    let dir = project.dir().display();
    let _ = write!(text, "wrote {}\nnext: contrapposto propagate train {dir}\n", file.display());
    output::print(&text)
}

fn train(args: &TrainArgs) -> Result<(), Failure> {
    let mut project = Project::open(&args.project)?;
    if let Some(estimator) = args.estimator {
        project.options.estimator = estimator;
    }
    let progress = progress();
    progress.part("learning");
    let edit = project.train_watched(args.context.as_deref(), &|l: Learning| {
        let before = if l.model == "configurations" { 0.0 } else { 0.5 };
        progress.at(before + 0.5 * l.evaluations as f64 / l.of.max(1) as f64);
        ControlFlow::Continue(())
    })?;
    let learned = report::learned(&edit);
    if args.json {
        return output::json(&learned);
    }
    let dir = args.project.display();
    output::print(&format!(
        "{learned}wrote {}\nnext: contrapposto propagate apply {dir} CLIP OUT\n",
        project.model().display()
    ))
}

fn apply(args: &ApplyArgs) -> Result<(), Failure> {
    let mut reads = reads(&args.model, &args.clip);
    reads.extend(args.place.onto.clone());
    check(&args.output, args.force, &reads)?;
    let (edit, clip) = (Arc::new(project::model(&args.model)?), project::open(&args.clip)?);
    let at = Where { parts: args.place.parts.clone(), span_s: args.place.span, ..Where::default() };
    let onto = args.place.onto.as_deref().map(apply::body).transpose()?;
    let how = Use { amount: args.place.amount, contacts: args.place.contacts, at, onto };
    let done = apply::apply(&edit, &clip, &how)?;
    put(&args.output, &done.edited.clip, &args.clip, args.force, &reads)?;
    let report = report::applied(&clip, &done);
    if args.json {
        return output::json(&report);
    }
    output::print(&format!("{report}wrote {}\n", args.output.display()))
}

fn export(args: &ExportArgs) -> Result<(), Failure> {
    let reads = reads(&args.model, &args.clip);
    check(&args.output, args.force, &reads)?;
    let (edit, clip) = (Arc::new(project::model(&args.model)?), project::open(&args.clip)?);
    let done = apply::apply(&edit, &clip, &Use::default())?;
    put(&args.output, &done.untimed, &args.clip, args.force, &reads)?;
    let (model, input, out) = (args.model.display(), args.clip.display(), args.output.display());
    output::print(&format!(
        "wrote {out}: {} frames, frame n is frame n of {input}\n\
         next: change some frames of it, save them as EDITED.bvh, and\n      \
         contrapposto propagate correct {model} {input} --from EDITED.bvh\n",
        done.untimed.frames()
    ))
}

fn correct(args: &CorrectArgs) -> Result<(), Failure> {
    let project = Project::open(&args.project)?;
    let mut edit = project::model(&args.project)?;
    let (clip, edited) = (project::open(&args.clip)?, project::open(&args.from)?);
    let done = apply::apply(&Arc::new(edit.clone()), &clip, &Use::default())?;
    let changes = project::changes(&done.untimed, &edited)?;
    let (target, spans_s) = project::blended(&done.untimed, &edited, &changes, args.blend);
    let times_s = report::times(&clip, &done);
    let name = name(args.name.as_ref(), &args.from);
    let pair = Pair { times_s, spans_s, context: args.context.clone(), ..Pair::new(name, clip, target) };
    let file = project.add_pair(&pair)?;
    let mut text = describe(&changes);
    let _ = writeln!(text, "wrote {}", file.display());
    let others: Vec<String> = project
        .contexts(&edit)?
        .into_iter()
        .filter(|c| pair.context.as_ref().is_some_and(|own| own != c))
        .collect();
    if let (Some(own), false) = (&pair.context, others.is_empty()) {
        // an edit of one context is not taught the examples of another
        let dir = project.dir().display();
        let _ = writeln!(
            text,
            "the model is of context {}: it stays as it is; `propagate train {dir} --context {own}` learns this one",
            others.join(", ")
        );
    } else if !args.no_train {
        edit.grow(std::slice::from_ref(&pair)).map_err(PropagateError::from)?;
        project.save(&edit)?;
        let _ = writeln!(
            text,
            "wrote {}: {} examples, kernels kept; `propagate train` learns them again",
            project.model().display(),
            edit.frames.len()
        );
    }
    if args.json {
        let value = json!({ "pair": file, "changes": changes });
        return output::json(&value);
    }
    output::print(&text)
}

fn status(args: &StatusArgs) -> Result<(), Failure> {
    let project = Project::open(&args.project)?;
    let clips: Result<Vec<(String, Clip)>, Failure> =
        args.clips.iter().map(|c| Ok((c.display().to_string(), project::open(c)?))).collect();
    let asked = report::Asked { next: args.next, contradiction_rad: args.contradiction.to_radians() };
    let status = report::status(&project, &clips?, &asked)?;
    if args.json {
        return output::json(&status);
    }
    output::print(&status.to_string())
}

/// Which frames and joints differ, a line a run of frames.
fn describe(changes: &[Change]) -> String {
    let mut text = String::new();
    for c in changes.iter().take(10) {
        let joints: Vec<String> =
            c.joints.iter().take(4).map(|(name, apart)| format!("{name} {apart:.1}")).collect();
        let more =
            if c.joints.len() > 4 { format!(" and {} more", c.joints.len() - 4) } else { String::new() };
        let _ = writeln!(
            text,
            "frames {} to {} ({:.3} s to {:.3} s): {}{more} (degrees; mm of the root)",
            c.from_frame,
            c.to_frame,
            c.from_s,
            c.to_s,
            joints.join(", ")
        );
    }
    if changes.len() > 10 {
        let _ = writeln!(text, "and {} more runs of frames", changes.len() - 10);
    }
    text
}

/// Files that a command reads.
fn reads(model: &Path, clip: &Path) -> Vec<PathBuf> {
    vec![if model.is_dir() { model.join("model.edit") } else { model.to_owned() }, clip.to_owned()]
}

fn check(output: &Path, force: bool, reads: &[PathBuf]) -> Result<(), Failure> {
    Ok(check_file(output, output::overwrite(force), reads)?)
}

/// Writes a clip in the format of the file's ending, in metres.
fn put(output: &Path, clip: &Clip, from: &Path, force: bool, reads: &[PathBuf]) -> Result<(), Failure> {
    let write = formats::format_of(output).and_then(|f| f.write_clip);
    let write = write.ok_or_else(|| {
        let kinds = endings(|f| f.write_clip.is_some());
        Failure::Input(format!("{}: cannot write this; allowed: {kinds}", output.display()))
    })?;
    let solids = glb::bones(&clip.skeleton);
    let name = from.file_stem().unwrap_or_default().to_string_lossy();
    let out = ClipOut { clip, solids: &solids, colors: &[], name: &name, metres_per_unit: UNIT_M };
    Ok(write_file(output, &write(&out).map_err(Failure::run)?, output::overwrite(force), reads)?)
}

/// Unit of a BVH written, m: centimetres.
const UNIT_M: f64 = 0.01;
