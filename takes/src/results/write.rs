//! A performed take as a folder of results: clips, trace, report, figures.
//!
//! In: a [`Performed`], a folder. Out: its files, and the report that names them. Everything that was computed is on disk before anything
//! is drawn: a figure that cannot be drawn is named, and costs nothing else.

use std::any::Any;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use formats::bvh::WriteOptions;
use formats::{bvh, foresight_npz, glb, trace_npz};
use motion::Clip;
use plots::Figure;
use scenes::contact_file;
use sim::Outcome;

use super::figures::{self, Draw};
use super::folder::{Earlier, Folder, FolderError, Plan, Subfolder, was_read};
use super::report::{Report, span_folder};
use crate::replay::offsets;
use crate::{Body, Performed, Progress, Runs, Take};

/// What stands when, to be edited and given to the next run.
pub const CONTACTS: &str = "contacts.ron";
/// The folder of figures.
pub const PLOTS: &str = "plots";

/// What of a result is written.
#[derive(Clone, Debug)]
pub struct What {
    /// Whether figures are drawn.
    pub figures: bool,
    /// Files beside those of the take that were read, and so are never replaced.
    pub reads: Vec<PathBuf>,
}

impl Default for What {
    fn default() -> Self {
        Self { figures: true, reads: Vec::new() }
    }
}

/// Why results cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// Of the folder.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A file of a format.
    #[error("cannot write {name}: {why}")]
    File {
        /// Its name.
        name: String,
        /// Why.
        why: String,
    },
}

impl WriteError {
    /// Whether the fault lies in the input (another folder would do) rather than in the run.
    pub fn is_input(&self) -> bool {
        matches!(self, Self::Folder(e) if e.is_input())
    }

    /// A file that could not be written.
    pub fn file(name: &str, why: impl std::fmt::Display) -> Self {
        Self::File { name: name.into(), why: why.to_string() }
    }
}

/// A figure that could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Undrawn {
    /// Its name.
    pub stem: String,
    /// Why.
    pub why: String,
}

/// A folder of results, written.
pub struct Written<R> {
    /// The report, which names all files.
    pub report: R,
    /// Figures that are missing.
    pub undrawn: Vec<Undrawn>,
}

/// How the files of a figure end.
const KINDS: [&str; 2] = ["svg", "png"];

/// Names the files of a figure in a folder's `plots`.
fn add_figure(into: &mut Subfolder<'_>, stem: &str) -> Result<(), WriteError> {
    for kind in KINDS {
        into.add(&format!("{stem}_{kind}"), &format!("{PLOTS}/{stem}.{kind}"))?;
    }
    Ok(())
}

/// Saves a figure into a folder's `plots`.
///
/// # Errors
/// Of the folder and of the figure.
pub fn save_figure(into: &mut Subfolder<'_>, stem: &str, figure: &Figure) -> Result<(), WriteError> {
    let plots = into.make(PLOTS)?;
    figure.save(&plots, stem).map_err(|e| WriteError::file(stem, e))?;
    add_figure(into, stem)
}

/// Adds a figure to the results in `dir`; the files written.
///
/// # Errors
/// Of the folder and of the figure.
pub fn write_figure(
    dir: &Path,
    command: &str,
    stem: &str,
    figure: &Figure,
) -> Result<Vec<PathBuf>, WriteError> {
    let names = KINDS.map(|kind| format!("{PLOTS}/{stem}.{kind}"));
    let planned = names.each_ref().map(String::as_str);
    let plan = Plan { command, planned: &planned, reads: &[], earlier: Earlier::Keep };
    let mut folder = Folder::begin(dir, &plan)?;
    save_figure(&mut folder.top(), stem, figure)?;
    folder.commit()?;
    Ok(names.iter().map(|name| dir.join(name)).collect())
}

/// Draws figures into a folder's `plots`, one by one; those that fail are returned.
///
/// # Errors
/// Of the folder.
pub fn draw(
    into: &mut Subfolder<'_>,
    figures: &[Draw<'_>],
    progress: &Progress<'_>,
) -> Result<Vec<Undrawn>, WriteError> {
    let mut undrawn = Vec::new();
    for (i, (stem, figure)) in figures.iter().enumerate() {
        let folder = into.make(PLOTS)?;
        // a panic of the drawing library becomes a message: the results are on disk already
        let drawn = catch_unwind(AssertUnwindSafe(|| {
            figure().and_then(|figure| figure.save(&folder, stem).map_err(|e| e.to_string()))
        }));
        let why = match drawn {
            Ok(drawn) => drawn.err(),
            Err(panic) => Some(panic_message(panic.as_ref())),
        };
        match why {
            None => add_figure(into, stem)?,
            Some(why) => {
                for kind in KINDS {
                    // one of the two may have been written
                    let _ = std::fs::remove_file(folder.join(format!("{stem}.{kind}")));
                }
                undrawn.push(Undrawn { stem: (*stem).into(), why });
            }
        }
        progress.at((i + 1) as f64 / figures.len() as f64);
    }
    Ok(undrawn)
}

/// Writes a folder whose report names all files: first the data that `data` adds, then the figures.
///
/// * `report`: the text of `report.json`, given the files there are
///
/// # Errors
/// [`WriteError`]. Figures that cannot be drawn are no error: they are returned.
pub fn write_report(
    dir: &Path,
    plan: &Plan<'_>,
    data: &mut dyn FnMut(&mut Folder) -> Result<(), WriteError>,
    figures: &[Draw<'_>],
    report: &mut dyn FnMut(BTreeMap<String, String>) -> String,
    progress: &Progress<'_>,
) -> Result<Vec<Undrawn>, WriteError> {
    progress.part("writing");
    let mut folder = Folder::begin(dir, plan)?;
    data(&mut folder)?;
    folder.add("report_json", "report.json")?;
    folder.write("report.json", report(folder.files()).as_bytes())?;
    folder.commit()?;
    if figures.is_empty() {
        return Ok(Vec::new());
    }
    progress.part("drawing");
    let undrawn = draw(&mut folder.top(), figures, progress)?;
    folder.write("report.json", report(folder.files()).as_bytes())?;
    folder.commit()?;
    Ok(undrawn)
}

/// What a panic said.
fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "it panicked".into())
}

/// Writes a clip of a body as BVH.
///
/// # Errors
/// Of the folder and of the format.
pub fn write_bvh(
    into: &mut Subfolder<'_>,
    stem: &str,
    clip: &Clip,
    metres_per_unit: f64,
) -> Result<(), WriteError> {
    let name = format!("{stem}.bvh");
    let path = into.add(&format!("{stem}_bvh"), &name)?;
    let options = WriteOptions { metres_per_unit, ..Default::default() };
    bvh::write_file(&path, clip, &options).map_err(|e| WriteError::file(&name, e))
}

/// Writes a clip of a body as GLB, with its solids; `name` is what the file calls the motion.
///
/// # Errors
/// Of the folder and of the format.
pub fn write_glb(
    into: &mut Subfolder<'_>,
    stem: &str,
    clip: &Clip,
    body: &Body,
    name: &str,
) -> Result<(), WriteError> {
    let file = format!("{stem}.glb");
    let path = into.add(&format!("{stem}_glb"), &file)?;
    glb::write_file(&path, clip, &body.solids(), &body.colors, name).map_err(|e| WriteError::file(&file, e))
}

/// What a take leaves in its folder, performed or only previewed.
fn plan<'a>(dir: &Path, preview: bool, foresight: bool, reads: &'a [PathBuf]) -> Plan<'a> {
    const FILES: [&str; 8] = [
        CONTACTS,
        "kinematic.bvh",
        "kinematic.glb",
        "report.json",
        "dynamic.bvh",
        "dynamic.glb",
        "trace.npz",
        "foresight.npz",
    ];
    let planned = match (preview, foresight) {
        (true, _) => &FILES[..4],
        (false, false) => &FILES[..7],
        (false, true) => &FILES[..],
    };
    // contacts that a person wrote there stay
    let planned = if was_read(&dir.join(CONTACTS), reads) { &planned[1..] } else { planned };
    Plan { command: "render", planned, reads, earlier: Earlier::Remove }
}

impl Take {
    /// Checks, before a long run, that its results can be written into `dir`; `preview`: those of its preview.
    ///
    /// # Errors
    /// A folder that cannot be written to; a file in it that is not ours, or was read.
    pub fn check(&self, dir: &Path, what: &What, preview: bool) -> Result<(), WriteError> {
        Ok(Folder::check(dir, &plan(dir, preview, self.looks_ahead(), &reads(self, what)))?)
    }
}

/// Writes what stands when, to be edited and given back; of a body without contacts nothing.
fn write_contacts(into: &mut Subfolder<'_>, take: &Take) -> Result<(), WriteError> {
    let names = take.contact_points();
    if names.is_empty() {
        return Ok(());
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    into.add("contacts_ron", CONTACTS)?;
    let text = contact_file::plan_text(&names, &take.asked.contacts);
    Ok(into.write(CONTACTS, text.as_bytes())?)
}

/// The files that a take was made of, and others that were read.
fn reads(take: &Take, what: &What) -> Vec<PathBuf> {
    take.files.iter().chain(&what.reads).cloned().collect()
}

impl Performed {
    /// Writes everything into `dir`; earlier results there are replaced when all is complete.
    ///
    /// # Errors
    /// [`WriteError`]. Figures that cannot be drawn are no error: they are in [`Written::undrawn`].
    pub fn write(
        &self,
        dir: &Path,
        what: &What,
        progress: &Progress<'_>,
    ) -> Result<Written<Report>, WriteError> {
        progress.part("writing");
        let preview = matches!(self.runs, Runs::Preview);
        let read = reads(&self.take, what);
        let mut folder = Folder::begin(dir, &plan(dir, preview, self.take.looks_ahead(), &read))?;
        let keeps = was_read(&dir.join(CONTACTS), &read);
        let take = &self.take;
        let mut report = Report::new(self);
        if !keeps {
            write_contacts(&mut folder.top(), take)?;
        }
        if self.spans().is_empty() {
            fill(&mut folder.top(), take, self.outcome())?;
        } else {
            write_bvh(
                &mut folder.top(),
                "kinematic",
                &take.for_files(&take.asked.clip),
                take.metres_per_unit(),
            )?;
            for (k, part) in self.spans().iter().enumerate() {
                fill(&mut folder.inside(&span_folder(k))?, &part.take, Some(&part.outcome))?;
            }
        }
        let mut undrawn = Vec::new();
        self.reports(&mut folder, &mut report)?;
        folder.commit()?;
        if what.figures {
            progress.part("drawing");
            if self.spans().is_empty() {
                undrawn = draw(&mut folder.top(), &figures::figures(take, self.outcome()), progress)?;
            }
            for (k, part) in self.spans().iter().enumerate() {
                let drawn = figures::figures(&part.take, Some(&part.outcome));
                undrawn.extend(draw(&mut folder.inside(&span_folder(k))?, &drawn, progress)?);
            }
            self.reports(&mut folder, &mut report)?;
            folder.commit()?;
        }
        Ok(Written { report, undrawn })
    }

    /// The reports: of the spans, each with its own files, and of the whole, which names all.
    fn reports(&self, folder: &mut Folder, report: &mut Report) -> Result<(), WriteError> {
        for (k, part) in self.spans().iter().enumerate() {
            let mut inside = folder.inside(&span_folder(k))?;
            let mut own = Report::of(&part.take, Some(&part.outcome), &[]);
            inside.add("report_json", "report.json")?;
            own.files = inside.files();
            inside.write("report.json", own.to_json().as_bytes())?;
        }
        folder.add("report_json", "report.json")?;
        report.files = folder.files();
        Ok(folder.write("report.json", report.to_json().as_bytes())?)
    }
}

/// Everything of a run but report and figures.
fn fill(into: &mut Subfolder<'_>, take: &Take, outcome: Option<&Outcome>) -> Result<(), WriteError> {
    let unit = take.metres_per_unit();
    write_bvh(into, "kinematic", &take.for_files(&take.asked.clip), unit)?;
    let Some(outcome) = outcome else {
        return write_glb(into, "kinematic", &take.asked.clip, &take.body, &take.name);
    };
    let performed = take.at_frames(&outcome.trace.clip());
    write_bvh(into, "dynamic", &take.for_files(&performed), unit)?;
    write_glb(into, "dynamic", &performed, &take.body, &take.name)?;
    let path = into.add("trace_npz", "trace.npz")?;
    trace_npz::save(&outcome.trace, &path).map_err(|e| WriteError::file("trace.npz", e))?;
    let Some(used) = &outcome.foresight else { return Ok(()) };
    let path = into.add("foresight_npz", "foresight.npz")?;
    foresight_npz::save(&offsets(outcome, used), &path).map_err(|e| WriteError::file("foresight.npz", e))
}
