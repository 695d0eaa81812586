//! A project of an edit by example: a folder of plain files.
//!
//! ```text
//! lean/project.ron            how the edit is learned
//! lean/pairs/walk.ron         a pair: which files, which spans; removing it undoes the step
//! lean/pairs/walk.source.bvh  the motion before
//! lean/pairs/walk.target.bvh  the motion as it should be: frame n is frame n of the source
//! lean/model.edit             what was learned of all pairs; removing it loses nothing
//! ```
//!
//! In: clips and their edited versions. Out: pairs on disk, an [`ExampleEdit`] of them, and corrections: frames that somebody changed
//! in the result become a pair of their own. Every file is written whole or not at all, the pair's own file last, so that a run that is
//! killed leaves no half of a pair.

use std::collections::BTreeSet;
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use edits::by_example::{ExampleEdit, ExampleOptions, Learning, Pair, Rig};
use formats::bvh::{ImportOptions, WriteOptions};
use motion::{Clip, Dof, Value};
use serde::{Deserialize, Serialize};
use takes::results::folder::{Overwrite, write_file};

use super::PropagateError;

/// How much a joint may differ and still count as unchanged: what rounding in files leaves, rad.
pub const SAME_RAD: f64 = 0.002;
/// The same of the root's place, m.
pub const SAME_M: f64 = 0.001;

/// A pair as its file has it; paths are beside the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Pair")]
pub struct PairFile {
    /// The motion before.
    pub source: String,
    /// The motion as it should be.
    pub target: String,
    /// Parts that are examples, s; none is all.
    #[serde(default)]
    pub spans_s: Vec<(f64, f64)>,
    /// When the target's frames come, s, where timing is edited.
    #[serde(default)]
    pub times_s: Option<Vec<f64>>,
    /// Keeps pairs apart that contradict each other on purpose.
    #[serde(default)]
    pub context: Option<String>,
}

/// A project on disk.
#[derive(Clone, Debug, PartialEq)]
pub struct Project {
    dir: PathBuf,
    /// How the edit is learned.
    pub options: ExampleOptions,
}

/// Frames that somebody changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// First frame.
    pub from_frame: usize,
    /// Last frame.
    pub to_frame: usize,
    /// First time, s.
    pub from_s: f64,
    /// Last time, s.
    pub to_s: f64,
    /// Links whose joints differ, farthest first, with how far, degrees (mm for the root's place).
    pub joints: Vec<(String, f64)>,
}

impl Project {
    /// Makes a project in a new or empty folder.
    ///
    /// # Errors
    /// A project that is there already; files that cannot be written.
    pub fn create(dir: &Path, options: ExampleOptions) -> Result<Self, PropagateError> {
        let file = dir.join(PROJECT);
        if file.exists() {
            return Err(PropagateError::Exists { path: file });
        }
        make(&dir.join(PAIRS))?;
        let pretty = ron::ser::PrettyConfig::new().struct_names(false);
        let text = ron::ser::to_string_pretty(&options, pretty)
            .map_err(|e| PropagateError::File { path: file.clone(), what: e.to_string() })?;
        let text =
            format!("// How the edit is learned; docs/BY_EXAMPLE.md says which to turn when.\n{text}\n");
        write_file(&file, text.as_bytes(), Overwrite::Refuse, &[])?;
        Ok(Self { dir: dir.into(), options })
    }

    /// Opens a project.
    ///
    /// # Errors
    /// A folder that is none; words that make no sense, at their place.
    pub fn open(dir: &Path) -> Result<Self, PropagateError> {
        let file = dir.join(PROJECT);
        if !file.is_file() {
            return Err(PropagateError::NoProject { path: dir.into() });
        }
        Ok(Self { dir: dir.into(), options: read_ron(&file)? })
    }

    /// Its folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Where its model is.
    pub fn model(&self) -> PathBuf {
        self.dir.join(MODEL)
    }

    /// Adds a pair whose clips are on disk, and copies the files (of scenes, their motion as BVH); returns the pair's file.
    ///
    /// # Errors
    /// Clips that do not go together, files that cannot be read, a name that is taken.
    pub fn add(&self, pair: &Pair, source: &Path, target: &Path) -> Result<PathBuf, PropagateError> {
        if takes::is_ron(source) || takes::is_ron(target) {
            return self.add_pair(pair);
        }
        self.check(pair)?;
        let copy = |path: &Path| fs::read(path).map_err(|e| file_fault(path, &e));
        let ending =
            |path: &Path| path.extension().map_or("bvh".into(), |e| e.to_string_lossy().into_owned());
        let (a, b) = (copy(source)?, copy(target)?);
        self.put(pair, (&ending(source), &a), (&ending(target), &b))
    }

    /// Adds a pair of two clips in memory, written as BVH.
    ///
    /// # Errors
    /// As [`Project::add`].
    pub fn add_pair(&self, pair: &Pair) -> Result<PathBuf, PropagateError> {
        self.check(pair)?;
        let (a, b) = (bvh(&pair.source)?, bvh(&pair.target)?);
        self.put(pair, ("bvh", &a), ("bvh", &b))
    }

    /// A pair that can be learned from, and a name that is a file's.
    fn check(&self, pair: &Pair) -> Result<(), PropagateError> {
        let plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
        if pair.name.is_empty() || pair.name.starts_with('.') || !pair.name.chars().all(plain) {
            return Err(PropagateError::Name { name: motion::names::echo(&pair.name) });
        }
        check(pair, &self.options)
    }

    fn put(
        &self,
        pair: &Pair,
        source: (&str, &[u8]),
        target: (&str, &[u8]),
    ) -> Result<PathBuf, PropagateError> {
        let (pairs, name) = (self.dir.join(PAIRS), &pair.name);
        make(&pairs)?;
        let file = PairFile {
            source: format!("{name}.source.{}", source.0),
            target: format!("{name}.target.{}", target.0),
            spans_s: pair.spans_s.clone(),
            times_s: pair.times_s.clone(),
            context: pair.context.clone(),
        };
        let own = pairs.join(format!("{name}.ron"));
        if own.exists() {
            return Err(PropagateError::Exists { path: own });
        }
        let pretty = ron::ser::PrettyConfig::new().struct_names(true).compact_arrays(true);
        let text = ron::ser::to_string_pretty(&file, pretty)
            .map_err(|e| PropagateError::File { path: own.clone(), what: e.to_string() })?;
        // files of a pair that was removed or never finished are replaced
        write_file(&pairs.join(&file.source), source.1, Overwrite::Allow, &[])?;
        write_file(&pairs.join(&file.target), target.1, Overwrite::Allow, &[])?;
        write_file(&own, format!("{text}\n").as_bytes(), Overwrite::Refuse, &[])?;
        Ok(own)
    }

    /// The files of all pairs, by name; no clip is opened.
    ///
    /// # Errors
    /// Files that make no sense, at their place.
    pub fn files(&self) -> Result<Vec<(String, PairFile)>, PropagateError> {
        let dir = self.dir.join(PAIRS);
        let entries = fs::read_dir(&dir).map_err(|e| file_fault(&dir, &e))?;
        let mut files: Vec<PathBuf> = entries
            .filter_map(|e| e.ok().map(|e| e.path()))
            .filter(|path| path.extension().is_some_and(|e| e == "ron"))
            .collect();
        files.sort();
        let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        files.iter().map(|path| Ok((name(path), read_ron(path)?))).collect()
    }

    /// All pairs, by name; of one context (and of none) where one is given.
    ///
    /// # Errors
    /// Pairs that cannot be read, with their file; a context that no pair has.
    pub fn pairs(&self, context: Option<&str>) -> Result<Vec<Pair>, PropagateError> {
        let files = self.files()?;
        let contexts: BTreeSet<&String> = files.iter().filter_map(|(_, f)| f.context.as_ref()).collect();
        if let Some(asked) = context.filter(|asked| contexts.iter().all(|c| c != asked)) {
            return Err(PropagateError::Context {
                found: motion::names::echo(asked),
                known: contexts.iter().map(|c| format!("`{c}`")).collect::<Vec<_>>().join(", "),
            });
        }
        let dir = self.dir.join(PAIRS);
        let mut pairs = Vec::new();
        for (name, file) in files {
            if !is_of(&file.context, context) {
                continue;
            }
            pairs.push(Pair {
                times_s: file.times_s,
                spans_s: file.spans_s,
                context: file.context,
                ..Pair::new(name, open(&dir.join(file.source))?, open(&dir.join(file.target))?)
            });
        }
        Ok(pairs)
    }

    /// Contexts of the pairs that a model was taught; pairs that were removed since are not known any more.
    ///
    /// # Errors
    /// As [`Project::files`].
    pub fn contexts(&self, edit: &ExampleEdit) -> Result<BTreeSet<String>, PropagateError> {
        let files = self.files()?;
        let taught = files.into_iter().filter(|(name, _)| edit.pairs.contains(name));
        Ok(taught.filter_map(|(_, f)| f.context).collect())
    }

    /// Whether a model was taught the pairs that are there: all of them, or all of one context.
    ///
    /// # Errors
    /// As [`Project::files`].
    pub fn is_current(&self, edit: &ExampleEdit) -> Result<bool, PropagateError> {
        let files = self.files()?;
        let mut taught: Vec<&String> = edit.pairs.iter().collect();
        taught.sort();
        let of = |context: Option<&str>| {
            let mut names: Vec<&String> =
                files.iter().filter(|(_, f)| is_of(&f.context, context)).map(|(name, _)| name).collect();
            names.sort();
            names
        };
        let contexts = files.iter().map(|(_, f)| f.context.as_deref());
        Ok(contexts.chain([None]).any(|c| of(c) == taught))
    }

    /// Learns the edit of all pairs and writes the model.
    ///
    /// # Errors
    /// No pairs, pairs that do not go together, files that cannot be written.
    pub fn train(&self, context: Option<&str>) -> Result<ExampleEdit, PropagateError> {
        self.train_watched(context, &|_| ControlFlow::Continue(()))
    }

    /// As [`Project::train`], watched ([`ExampleEdit::learn_watched`]); what is on disk stays as it is if it is ended.
    ///
    /// # Errors
    /// As [`Project::train`]; [`edits::ExampleError::Cancelled`].
    pub fn train_watched(
        &self,
        context: Option<&str>,
        watch: &(dyn Fn(Learning) -> ControlFlow<()> + Sync),
    ) -> Result<ExampleEdit, PropagateError> {
        let edit = ExampleEdit::learn_watched(&self.pairs(context)?, &self.options, watch)?;
        self.save(&edit)?;
        Ok(edit)
    }

    /// Writes the model.
    ///
    /// # Errors
    /// A file of that name that is no learned edit; files that cannot be written.
    pub fn save(&self, edit: &ExampleEdit) -> Result<(), PropagateError> {
        let path = self.model();
        if path.exists() {
            formats::example_file::open(&path)
                .map_err(|source| PropagateError::Model { path: path.clone(), source })?;
        }
        Ok(write_file(&path, &formats::example_file::bytes(edit), Overwrite::Allow, &[])?)
    }
}

/// Whether a pair is learned where a context is asked for.
fn is_of(own: &Option<String>, asked: Option<&str>) -> bool {
    match (own, asked) {
        (None, _) | (_, None) => true,
        (Some(own), Some(asked)) => own == asked,
    }
}

const PROJECT: &str = "project.ron";
const PAIRS: &str = "pairs";
const MODEL: &str = "model.edit";

/// Checks a pair before anything is written: its frames, its spans, and that the bodies are one rig.
///
/// # Errors
/// As [`Pair::check`]; spans without frames; bodies that differ.
pub fn check(pair: &Pair, options: &ExampleOptions) -> Result<(), PropagateError> {
    pair.check()?;
    pair.examples(options.examples_hz)?;
    Rig::find(Rig::of(&pair.source.skeleton)?.file(), &pair.target.skeleton)?;
    Ok(())
}

/// The model of a project, or of a file.
///
/// # Errors
/// A project that was not trained; a file that is no learned edit.
pub fn model(path: &Path) -> Result<ExampleEdit, PropagateError> {
    let file = if path.is_dir() { Project::open(path)?.model() } else { path.to_owned() };
    if path.is_dir() && !file.exists() {
        return Err(PropagateError::Untrained { path: path.into() });
    }
    formats::example_file::open(&file).map_err(|source| PropagateError::Model { path: file, source })
}

/// Frames in which `edited` differs from `result`, in runs.
///
/// # Errors
/// Clips with different frames or skeletons; nothing that differs.
pub fn changes(result: &Clip, edited: &Clip) -> Result<Vec<Change>, PropagateError> {
    let s = &result.skeleton;
    let names = |c: &Clip| c.skeleton.links().iter().map(|l| l.name.clone()).collect::<Vec<_>>();
    if names(result) != names(edited) || result.frames() != edited.frames() {
        return Err(PropagateError::NotTheResult {
            found: (edited.frames(), edited.skeleton.links().len()),
            needed: (result.frames(), s.links().len()),
        });
    }
    let dofs = Dof::all(s);
    let larger = motion::symmetry::size_m(s) / motion::symmetry::size_m(&edited.skeleton);
    let mut changes: Vec<Change> = Vec::new();
    for f in 0..result.frames() {
        let mut joints: Vec<(String, f64)> = Vec::new();
        for dof in &dofs {
            let (a, b) = (dof.read(s, result.pose(f)), dof.read(&edited.skeleton, edited.pose(f)));
            let (b, least, shown) = match (dof, b) {
                (Dof::Coordinate(..), Value::Scalar(x)) => (Value::Scalar(x * larger), SAME_M, 1e3),
                _ => (b, SAME_RAD, 1_f64.to_degrees()),
            };
            let apart = a.distance(&b);
            if apart > least {
                joints.push((s.links()[dof.link()].name.clone(), apart * shown));
            }
        }
        if joints.is_empty() {
            continue;
        }
        let at_s = f as f64 / result.rate_hz;
        match changes.last_mut() {
            Some(last) if last.to_frame + 1 == f => {
                (last.to_frame, last.to_s) = (f, at_s);
                for (name, apart) in joints {
                    match last.joints.iter_mut().find(|j| j.0 == name) {
                        Some(j) => j.1 = j.1.max(apart),
                        None => last.joints.push((name, apart)),
                    }
                }
            }
            _ => changes.push(Change { from_frame: f, to_frame: f, from_s: at_s, to_s: at_s, joints }),
        }
    }
    for change in &mut changes {
        change.joints.sort_by(|a, b| b.1.total_cmp(&a.1));
    }
    if changes.is_empty() {
        return Err(PropagateError::NothingChanged);
    }
    Ok(changes)
}

/// `result` with what `edited` changes in `changes`, faded linearly into the frames within `blend_s` of them; and the spans that are
/// then examples.
pub fn blended(result: &Clip, edited: &Clip, changes: &[Change], blend_s: f64) -> (Clip, Vec<(f64, f64)>) {
    let s = result.skeleton.clone();
    let reach = (blend_s * result.rate_hz).round() as usize;
    let larger = motion::symmetry::size_m(&s) / motion::symmetry::size_m(&edited.skeleton);
    let own = |f: usize| {
        let mut q = edited.pose(f).to_vec();
        if matches!(s.links()[0].joint, motion::Joint::Free) {
            let p = edited.skeleton.position(&q, 0) * larger;
            s.set_position(&mut q, 0, &p);
        }
        q
    };
    let mut out = result.clone();
    let mut delta = vec![0.0; s.nv()];
    let mut spans = Vec::new();
    for (i, change) in changes.iter().enumerate() {
        let before = i.checked_sub(1).map_or(0, |i| changes[i].to_frame + 1);
        let after = changes.get(i + 1).map_or(result.frames(), |c| c.from_frame);
        let from = change.from_frame.saturating_sub(reach).max(before);
        let to = (change.to_frame + reach).min(after - 1);
        for f in from..=to {
            let nearest = f.clamp(change.from_frame, change.to_frame);
            let share = 1.0 - f.abs_diff(nearest) as f64 / (reach + 1) as f64;
            s.difference(result.pose(nearest), &own(nearest), 1.0, &mut delta);
            let mut q = out.pose(f).to_vec();
            s.integrate(&mut q, &delta, share);
            out.pose_mut(f).copy_from_slice(&q);
        }
        spans.push((from as f64 / result.rate_hz, to as f64 / result.rate_hz));
    }
    (out, spans)
}

/// A clip of a project: a file of a clip, or a scene, whose motion is then as it is written to BVH and read again.
///
/// # Errors
/// Of the format; of the scene.
pub fn open(path: &Path) -> Result<Clip, PropagateError> {
    if takes::is_ron(path) {
        let take = takes::open(path, &takes::Ask::default()).map_err(Box::new)?;
        let written = formats::bvh::Bvh::parse(&bvh(&take.asked.clip)?)
            .map_err(|e| PropagateError::Bvh(e.fault.to_string()))?;
        let read = formats::bvh::import(&written, &ImportOptions::default());
        return Ok(read.map_err(|e| PropagateError::Bvh(e.to_string()))?.0);
    }
    let (clip, _) = formats::open_clip(path, &ImportOptions::default()).map_err(Box::new)?;
    Ok(clip)
}

fn bvh(clip: &Clip) -> Result<Vec<u8>, PropagateError> {
    let text = formats::bvh::write(clip, &WriteOptions::default());
    Ok(text.map_err(|e| PropagateError::Bvh(e.to_string()))?.into_bytes())
}

fn make(dir: &Path) -> Result<(), PropagateError> {
    fs::create_dir_all(dir).map_err(|e| file_fault(dir, &e))
}

fn read_ron<T: for<'de> Deserialize<'de>>(path: &Path) -> Result<T, PropagateError> {
    let text = motion::file::read_within(path, MOST_BYTES).map_err(|e| file_fault(path, &e))?;
    let text = String::from_utf8(text)
        .map_err(|e| PropagateError::File { path: path.into(), what: e.to_string() })?;
    ron::from_str(&text).map_err(|e| PropagateError::File {
        path: path.into(),
        what: format!(
            "{}:{}: {}",
            e.span.start.line,
            e.span.start.col,
            motion::names::brief(&e.code.to_string())
        ),
    })
}

/// Largest file of words; the times of a long pair are in it.
const MOST_BYTES: u64 = 64 << 20;

fn file_fault(path: &Path, e: &std::io::Error) -> PropagateError {
    PropagateError::File { path: path.into(), what: e.to_string() }
}
