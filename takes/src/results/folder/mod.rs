//! The output folder of a run: all files or none, and nothing replaced that is not ours.
//!
//! In: names and bytes of files. Out: a folder in which they are, with a manifest. A run uses it so:
//!
//! ```text
//! Folder::check ─→ simulate ─→ Folder::begin ─→ add, write ─→ commit (data) ─→ add, write ─→ commit (figures, report)
//! ```
//!
//! What is promised:
//! - A file is replaced or removed only if a run wrote it (the manifest lists it) and nobody changed it since, and never
//!   if this run read it. Any other file is named in an error, or left alone.
//! - A folder holds the output of one run, before and after any failure, also of a killed process, once [`Folder::begin`]
//!   or [`Folder::recover`] was called for it.
//! - Nothing is left behind by an interrupted run ([`interrupt`]); what a killed one leaves blocks nobody and is removed
//!   by the next run into the folder. The manifest is the only file in the folder besides the output.
//!
//! | module | holds |
//! |---|---|
//! | [`manifest`] | what runs wrote into a folder: names, lengths, digests |
//! | `names` | which names stay in the folder, and the order of moving |
//! | `scratch` | a temporary folder for whatever is no output of a run |
//! | `staging` | temporary names, locks, removal of what killed processes left |
//! | `commit` | moving files into place, and taking it back |
//! | `file` | single files, and whether a file is an input |
//! | [`interrupt`] | removal of temporary files at Ctrl-C |
//! | `error` | what can be wrong |

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use commit::{Commit, JOURNAL};
use file::ReadFiles;
use manifest::{MANIFEST, Manifest, Stamp};
use staging::Staging;

mod commit;
mod error;
mod file;
pub mod interrupt;
pub mod manifest;
mod names;
mod scratch;
mod staging;
#[cfg(test)]
mod tests;

pub use error::{FolderError, Foreign};
pub use file::{Overwrite, check_file, was_read, write_file};
pub use scratch::Scratch;

/// What becomes of files of earlier runs that a run does not write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Earlier {
    /// They are removed: a `dynamic.bvh` of an earlier run beside a newer `kinematic.bvh` would mislead.
    #[default]
    Remove,
    /// They stay: a command that adds figures to the folder of a run.
    Keep,
}

/// What a run is going to write.
#[derive(Debug, Clone, Copy, Default)]
pub struct Plan<'a> {
    /// The command, for the manifest.
    pub command: &'a str,
    /// Names of files it will write, relative to the folder, with `/`. Those known before the run suffice: when files
    /// are moved into place, all are checked.
    pub planned: &'a [&'a str],
    /// Files it has read or will read.
    pub reads: &'a [PathBuf],
    /// Other files of earlier runs.
    pub earlier: Earlier,
}

/// The output folder of a run in the making. Dropped, it leaves only what was committed.
///
/// # Examples
/// ```
/// # use takes::results::folder::{Folder, FolderError, Plan};
/// # fn main() -> Result<(), FolderError> {
/// # let home = tempfile::tempdir().unwrap();
/// # let dir = home.path().join("out");
/// let plan = Plan { command: "render", planned: &["report.json"], ..Plan::default() };
/// Folder::check(&dir, &plan)?; // before a long run
/// let mut folder = Folder::begin(&dir, &plan)?;
/// let path = folder.add("trace_npz", "trace.npz")?;
/// # std::fs::write(path, "").unwrap();
/// // … write the trace to `path` …
/// folder.add("report_json", "report.json")?;
/// folder.write("report.json", b"{}")?;
/// folder.commit()?; // the data is there, whatever happens to the figures
/// folder.add("motion_svg", "plots/motion.svg")?;
/// folder.write("plots/motion.svg", b"<svg/>")?;
/// folder.commit()?;
/// assert!(dir.join("plots/motion.svg").exists() && dir.join("trace.npz").exists());
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Folder {
    /// As the user named it.
    shown: PathBuf,
    /// Its absolute path.
    target: PathBuf,
    staging: Staging,
    command: String,
    earlier: Earlier,
    reads: ReadFiles,
    /// Subfolder (empty for the folder itself) and key in its report → name relative to the folder.
    files: BTreeMap<(String, String), String>,
    /// Names that are in the target already.
    committed: BTreeSet<String>,
    /// The manifest as last written.
    mine: Option<Stamp>,
}

/// Where output is to go.
enum Target {
    /// A folder, by its canonical path.
    Exists(PathBuf),
    /// In a folder (which may not exist either), under a name that does not exist.
    Absent(PathBuf, PathBuf),
}

impl Target {
    fn of(dir: &Path) -> Result<Self, FolderError> {
        let failed = || FolderError::io("write into", dir);
        let not_a_folder = |what| Err(FolderError::NotAFolder { path: dir.into(), what });
        match fs::metadata(dir) {
            Ok(meta) if meta.is_dir() => Ok(Self::Exists(fs::canonicalize(dir).map_err(failed())?)),
            Ok(_) => not_a_folder("a file"),
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                if fs::symlink_metadata(dir).is_ok() {
                    return not_a_folder("a symbolic link to nothing");
                }
                let path = std::path::absolute(dir).map_err(failed())?;
                match (path.parent(), path.file_name()) {
                    (Some(parent), Some(name)) => Ok(Self::Absent(parent.into(), name.into())),
                    _ => not_a_folder("a path that ends with `..`"),
                }
            }
            Err(e) => Err(failed()(e)),
        }
    }
}

impl Folder {
    /// Checks, before a long run, that its output can be written. Leaves nothing behind.
    ///
    /// # Errors
    /// As [`Folder::begin`].
    pub fn check(dir: &Path, plan: &Plan) -> Result<(), FolderError> {
        Self::begin(dir, plan).map(drop)
    }

    /// Begins the output of a run, in a temporary folder: in the target if that exists, else beside it.
    ///
    /// Undoes what a killed process left half moved, and removes temporary folders without a living owner.
    ///
    /// # Errors
    /// If the folder cannot be written to, if a planned file exists and may not be replaced, if a name is none.
    pub fn begin(dir: &Path, plan: &Plan) -> Result<Self, FolderError> {
        plan.planned.iter().try_for_each(|name| names::check(name))?;
        let reads = ReadFiles::new(plan.reads);
        let target = Target::of(dir)?;
        let home = match &target {
            Target::Exists(path) => {
                commit::recover(path)?;
                let manifest = Manifest::read(dir)?.map(|(manifest, _)| manifest);
                for name in plan.planned {
                    commit::owned(path, dir, name, manifest.as_ref(), &reads)?;
                }
                staging::remove_ownerless(path, JOURNAL);
                path.parent().into_iter().for_each(|parent| staging::remove_ownerless(parent, JOURNAL));
                path
            }
            Target::Absent(parent, name) => {
                commit::forget(parent, name);
                staging::remove_ownerless(parent, JOURNAL);
                parent
            }
        };
        let staging = Staging::create(home).map_err(FolderError::io("write into", dir))?;
        let target = match target {
            Target::Exists(path) => path,
            Target::Absent(_, name) => staging.dir().with_file_name(name),
        };
        Ok(Self {
            shown: dir.into(),
            target,
            staging,
            command: plan.command.into(),
            earlier: plan.earlier,
            reads,
            files: BTreeMap::new(),
            committed: BTreeSet::new(),
            mine: None,
        })
    }

    /// Undoes or completes what killed processes left half moved in a folder; for commands that read a run's output. If
    /// somebody is just moving files into it, waits until that is done. Whether there was anything to undo or complete.
    ///
    /// # Errors
    /// If there is something, and the folder cannot be written to.
    pub fn recover(dir: &Path) -> Result<bool, FolderError> {
        match fs::canonicalize(dir) {
            Ok(path) if path.is_dir() => commit::recover(&path),
            _ => Ok(false),
        }
    }

    /// The target, as the user named it.
    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.shown
    }

    /// The folder itself, as a place for files.
    pub fn top(&mut self) -> Subfolder<'_> {
        Subfolder { folder: self, name: String::new() }
    }

    /// A folder in it that has a report of its own (`span_1`).
    ///
    /// # Errors
    /// `Name`; of the file system.
    pub fn inside(&mut self, name: &str) -> Result<Subfolder<'_>, FolderError> {
        let inside = Subfolder { folder: self, name: name.into() };
        names::check(name)?;
        inside.make("")?;
        Ok(inside)
    }

    /// Adds a file: the path to write it to, whose folders exist.
    ///
    /// * `what`: its key in the report (`trace_npz`)
    /// * `name`: its name relative to the folder (`plots/motion.svg`)
    ///
    /// # Errors
    /// `Name` for one that leaves the folder, `Twice` for one that has another key; of the file system.
    pub fn add(&mut self, what: &str, name: &str) -> Result<PathBuf, FolderError> {
        self.top().add(what, name)
    }

    /// Writes a file that was added, or is to be in the folder but not in the report.
    ///
    /// # Errors
    /// `Name`; of the file system.
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<(), FolderError> {
        self.top().write(name, bytes)
    }

    /// All files added so far, for the report: key → name. Keys of files in a subfolder begin with its name (`span_1_trace_npz`).
    #[must_use]
    pub fn files(&self) -> BTreeMap<String, String> {
        let key = |folder: &String, what: &String| match folder.as_str() {
            "" => what.clone(),
            folder => format!("{}_{what}", folder.replace('/', "_")),
        };
        self.files.iter().map(|((folder, what), name)| (key(folder, what), name.clone())).collect()
    }

    /// Moves everything written since the last commit into place: all of it, or nothing and an error.
    ///
    /// The first commit replaces earlier output (see [`Earlier`]); later ones add to it and replace files of this run. A
    /// target that does not exist appears whole, by one rename.
    ///
    /// # Errors
    /// `Foreign`, `Input` for a file that may not be replaced, `Overtaken` if another run committed after this one,
    /// `NotWritten` for an added file that was not written; of the file system.
    pub fn commit(&mut self) -> Result<(), FolderError> {
        let files = self.staging.files();
        let staged = commit::staged(&files)?;
        let known = |name: &String| staged.contains_key(name) || self.committed.contains(name);
        if let Some(name) = self.files.values().find(|name| !known(name)) {
            return Err(FolderError::NotWritten { name: name.clone() });
        }
        self.mine = Some(match self.appear(&files, &staged)? {
            Some(stamp) => stamp,
            None => {
                let commit = Commit {
                    staging: &self.staging,
                    target: &self.target,
                    shown: &self.shown,
                    reads: &self.reads,
                    command: &self.command,
                    keeps: self.mine.is_some() || self.earlier == Earlier::Keep,
                    mine: self.mine,
                };
                commit.run(&staged)?
            }
        });
        self.committed.extend(staged.into_keys());
        Ok(())
    }

    /// Makes the whole folder appear if nothing has its name; the stamp of its manifest if so.
    fn appear(&self, files: &Path, staged: &BTreeMap<String, Stamp>) -> Result<Option<Stamp>, FolderError> {
        let exists = || fs::symlink_metadata(&self.target).is_ok();
        if self.mine.is_some() || exists() {
            return Ok(None);
        }
        let failed = || FolderError::io("write into", &self.shown);
        let json = commit::manifest_of(&self.command, staged).to_json();
        let manifest = files.join(MANIFEST);
        fs::write(&manifest, &json).map_err(failed())?;
        let _pass = interrupt::pass();
        if let Err(e) = fs::rename(files, &self.target) {
            // somebody made the folder just now: its files are looked at one by one
            fs::remove_file(&manifest).map_err(failed())?;
            return if exists() { Ok(None) } else { Err(failed()(e)) };
        }
        fs::create_dir(files).map_err(failed())?;
        Ok(Some(Stamp::of(json.as_bytes())))
    }
}

/// The folder, or a folder in it with a report of its own.
#[derive(Debug)]
pub struct Subfolder<'a> {
    folder: &'a mut Folder,
    /// Relative to the folder; empty for the folder itself.
    name: String,
}

impl Subfolder<'_> {
    /// As [`Folder::add`], with a name relative to this subfolder.
    ///
    /// # Errors
    /// As [`Folder::add`].
    pub fn add(&mut self, what: &str, name: &str) -> Result<PathBuf, FolderError> {
        let path = self.path_of(name)?;
        let name = self.full(name);
        let key = (self.name.clone(), what.to_owned());
        if let Some((other, _)) = self.folder.files.iter().find(|(k, n)| **n == name && **k != key) {
            return Err(FolderError::Twice { name, first: other.1.clone(), second: what.into() });
        }
        self.folder.files.insert(key, name);
        Ok(path)
    }

    /// As [`Folder::write`], with a name relative to this subfolder.
    ///
    /// # Errors
    /// As [`Folder::write`].
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<(), FolderError> {
        let path = self.path_of(name)?;
        fs::write(path, bytes).map_err(FolderError::io("write", self.folder.shown.join(self.full(name))))
    }

    /// Files added to this subfolder, for its own report: key → name, relative to it.
    #[must_use]
    pub fn files(&self) -> BTreeMap<String, String> {
        let start = if self.name.is_empty() { 0 } else { self.name.len() + 1 };
        let here = self.folder.files.iter().filter(|((folder, _), _)| *folder == self.name);
        here.map(|((_, what), name)| (what.clone(), name[start..].to_owned())).collect()
    }

    /// Where to write, until the next commit, what is to be in a folder of this name (empty for this one); it exists. For
    /// functions that name their files themselves; add these with [`Subfolder::add`].
    ///
    /// # Errors
    /// `Name`; of the file system.
    pub fn make(&self, name: &str) -> Result<PathBuf, FolderError> {
        let full = self.full(name);
        let path = self.folder.staging.files().join(&full);
        if !full.is_empty() {
            names::check(&full)?;
            fs::create_dir_all(&path).map_err(FolderError::io("write", self.folder.shown.join(&full)))?;
        }
        Ok(path)
    }

    /// A name relative to the whole folder.
    fn full(&self, name: &str) -> String {
        match (self.name.as_str(), name) {
            ("", name) => name.into(),
            (folder, "") => folder.into(),
            (folder, name) => format!("{folder}/{name}"),
        }
    }

    /// Where to write a file of this name; its folder exists.
    fn path_of(&self, name: &str) -> Result<PathBuf, FolderError> {
        names::check(name)?;
        let (folder, file) = name.rsplit_once('/').unwrap_or(("", name));
        Ok(self.make(folder)?.join(file))
    }
}
