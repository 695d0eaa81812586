//! Moving output into a folder that exists: all files or none, also if the process is killed on the way.
//!
//! In: a staging folder with the new files, the manifest of the target. Out: the target with the new files and the
//! new manifest, or unchanged. While the commit lock of the target is held:
//!
//! 1. Check: every file to be replaced is ours (listed in the manifest and unchanged) and no input.
//! 2. Write the new manifest and the journal (what is to be moved) into the staging folder.
//! 3. Move the old files aside, reports first, into `old/` of the staging folder; look again whether each is ours.
//! 4. Give the new files their names, reports last. A name that somebody took meanwhile is not replaced.
//! 5. Move the new manifest into place. From here on the commit counts as done.
//! 6. Remove the journal, the old files, and folders of ours that became empty.
//!
//! If something fails before 5, the moves are undone. If the process is killed, the next one that begins in the
//! folder (or [`recover`]) finds the journal: the new manifest still in the staging folder means undo, else 6 is done.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::{FolderError, Foreign};
use super::file::{ReadFiles, kind, place};
use super::interrupt;
use super::manifest::{MANIFEST, Manifest, Stamp};
use super::names;
use super::staging::{self, CommitLock, Staging, same_file};

/// Tells that moves have begun; in the staging folder.
pub(super) const JOURNAL: &str = "journal.json";
/// The new manifest, until the moves are done.
const NEW_MANIFEST: &str = "manifest.json";
/// Replaced and removed files.
const OLD: &str = "old";

/// What a commit moves.
#[derive(Debug, Serialize, Deserialize)]
struct Journal {
    /// The target beside the staging folder; none if the staging folder is in the target.
    into: Option<String>,
    /// In the order in which new files get their names.
    moves: Vec<Move>,
    /// Folders to be made, outermost first.
    folders: Vec<String>,
    /// Folders of earlier runs that may become empty, innermost first.
    emptied: Vec<String>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Move {
    name: String,
    /// What is moved in; none if the file is only removed.
    new: Option<Stamp>,
    /// What is moved aside, if there is something.
    old: Option<Stamp>,
}

/// What a commit is about.
pub(super) struct Commit<'a> {
    pub staging: &'a Staging,
    /// The target.
    pub target: &'a Path,
    /// The target as the user named it.
    pub shown: &'a Path,
    pub reads: &'a ReadFiles,
    pub command: &'a str,
    /// Whether files of the earlier manifest that are not written now stay.
    pub keeps: bool,
    /// The manifest this run wrote before, which must still be there.
    pub mine: Option<Stamp>,
}

/// What a look at the target says.
struct Planned {
    journal: Journal,
    /// As it will be.
    manifest: Manifest,
    /// Of files that are replaced or removed, when they were compared with the manifest.
    seen: BTreeMap<String, Metadata>,
}

/// A file of the target that may be replaced: its content, and its metadata when that was read; none if there is no file.
type Owned = Option<(Stamp, Metadata)>;

/// Whether a file of a folder may be replaced.
pub(super) fn owned(
    target: &Path,
    shown: &Path,
    name: &str,
    manifest: Option<&Manifest>,
    reads: &ReadFiles,
) -> Result<Owned, FolderError> {
    for folder in names::folders(name) {
        match kind(&target.join(folder)).map_err(FolderError::io("read", shown.join(folder)))? {
            Ok(None) => return Ok(None),
            Err(Foreign::Folder) => {}
            Ok(Some(_)) => return Err(FolderError::Foreign { path: shown.join(folder), why: Foreign::File }),
            Err(why) => return Err(FolderError::Foreign { path: shown.join(folder), why }),
        }
    }
    let (path, shown) = (target.join(name), shown.join(name));
    reads.refuse(&path, &shown)?;
    let meta = match kind(&path).map_err(FolderError::io("read", &shown))? {
        Ok(None) => return Ok(None),
        Ok(Some(meta)) => meta,
        Err(why) => return Err(FolderError::Foreign { path: shown, why }),
    };
    let Some(stamp) = manifest.and_then(|m| m.files.get(name)) else {
        return Err(FolderError::Foreign { path: shown, why: Foreign::NotListed });
    };
    match stamp.is_of(&path).map_err(FolderError::io("read", &shown))? {
        true => Ok(Some((*stamp, meta))),
        false => Err(FolderError::Foreign { path: shown, why: Foreign::Changed }),
    }
}

/// The new manifest of a folder that did not exist or has none of ours.
pub(super) fn manifest_of(command: &str, staged: &BTreeMap<String, Stamp>) -> Manifest {
    let mut manifest = Manifest::new(command);
    manifest.files.clone_from(staged);
    manifest.folders = staged.keys().flat_map(|name| names::folders(name)).map(str::to_owned).collect();
    manifest
}

impl Commit<'_> {
    /// Moves the staged files into the target, which exists; the stamp of its new manifest.
    pub(super) fn run(&self, staged: &BTreeMap<String, Stamp>) -> Result<Stamp, FolderError> {
        let _lock = CommitLock::acquire(self.target).map_err(|e| self.named(e))?;
        recover_locked(self.target).map_err(|e| self.named(e))?;
        let old = Manifest::read(self.target).map_err(|e| self.named(e))?;
        if self.mine.is_some() && self.mine != old.as_ref().map(|(_, stamp)| *stamp) {
            return Err(FolderError::Overtaken { dir: self.shown.into() });
        }
        let old = old.map(|(manifest, _)| manifest);
        let Planned { journal, manifest, seen } = self.plan(staged, old)?;
        let json = manifest.to_json();
        // synchronising can take long on a busy disk; nothing is moved yet, so an interruption may come between
        self.announce(&json, &journal)?;
        let _pass = interrupt::pass();
        if let Err(e) = self.moves(&journal, &seen) {
            if undo(self.staging.dir(), self.target, &journal).is_err() {
                self.staging.keep(); // the old files are in it; the next run tries again
            }
            return Err(e);
        }
        complete(self.staging.dir(), self.target, &journal)
            .map_err(FolderError::io("write into", self.shown))?;
        Ok(Stamp::of(json.as_bytes()))
    }

    /// Step 1.
    fn plan(&self, staged: &BTreeMap<String, Stamp>, old: Option<Manifest>) -> Result<Planned, FolderError> {
        let mut manifest = manifest_of(self.command, staged);
        if let Some(old) = old.as_ref().filter(|_| self.keeps) {
            manifest.command.clone_from(&old.command);
        }
        let mut moves = Vec::new();
        let mut seen = BTreeMap::new();
        for (name, stamp) in staged {
            let owned = owned(self.target, self.shown, name, old.as_ref(), self.reads)?;
            let aside = owned.map(|(stamp, meta)| {
                seen.insert(name.clone(), meta);
                stamp
            });
            moves.push(Move { name: name.clone(), new: Some(*stamp), old: aside });
        }
        for (name, stamp) in old.iter().flat_map(|m| &m.files).filter(|(n, _)| !staged.contains_key(*n)) {
            if self.keeps {
                manifest.files.insert(name.clone(), *stamp);
                continue;
            }
            match owned(self.target, self.shown, name, old.as_ref(), self.reads) {
                Ok(Some((stamp, meta))) => {
                    seen.insert(name.clone(), meta);
                    moves.push(Move { name: name.clone(), new: None, old: Some(stamp) });
                }
                // ours, but read by this run: stays, and stays ours
                Err(FolderError::Input { .. }) => drop(manifest.files.insert(name.clone(), *stamp)),
                // changed, or replaced by something else: the user's from now on
                Ok(None) | Err(FolderError::Foreign { .. }) => {}
                Err(e) => return Err(e),
            }
        }
        moves.sort_by(|a, b| names::order(&a.name).cmp(&names::order(&b.name)));
        // folders that exist and that no run made stay when they are empty
        let exists = |folder: &String| self.target.join(folder).is_dir();
        let folders: Vec<String> = manifest.folders.iter().filter(|f| !exists(f)).cloned().collect();
        let earlier: BTreeSet<String> = old.into_iter().flat_map(|m| m.folders).collect();
        let used: BTreeSet<&str> = manifest.files.keys().flat_map(|name| names::folders(name)).collect();
        let emptied = earlier.iter().rev().filter(|f| !used.contains(f.as_str())).cloned().collect();
        let ours = |f: &&str| earlier.contains(*f) || folders.iter().any(|made| made == f);
        manifest.folders = used.iter().copied().filter(|f| ours(f)).map(str::to_owned).collect();
        let inside = self.staging.dir().parent() == Some(self.target);
        let into = self.target.file_name().filter(|_| !inside).map(|n| n.to_string_lossy().into_owned());
        Ok(Planned { journal: Journal { into, moves, folders, emptied }, manifest, seen })
    }

    /// Steps 3 to 5.
    fn moves(&self, journal: &Journal, seen: &BTreeMap<String, Metadata>) -> Result<(), FolderError> {
        self.set_aside(&journal.moves, seen)?;
        for folder in &journal.folders {
            match fs::create_dir(self.target.join(folder)) {
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                done => done.map_err(FolderError::io("write", self.shown.join(folder)))?,
            }
        }
        self.give_names(&journal.moves)?;
        let manifest = self.target.join(MANIFEST);
        fs::rename(self.staging.dir().join(NEW_MANIFEST), manifest)
            .map_err(FolderError::io("write", self.shown.join(MANIFEST)))
    }

    /// Step 3.
    fn set_aside(&self, moves: &[Move], seen: &BTreeMap<String, Metadata>) -> Result<(), FolderError> {
        let staging = self.staging.dir();
        for m in moves.iter().rev() {
            let Some(stamp) = m.old else { continue };
            let shown = self.shown.join(&m.name);
            let aside = staging.join(OLD).join(&m.name);
            let folder = aside.parent().unwrap_or(staging);
            fs::create_dir_all(folder).map_err(FolderError::io("write", &shown))?;
            match fs::rename(self.target.join(&m.name), &aside) {
                Err(e) if e.kind() == io::ErrorKind::NotFound => continue,
                done => done.map_err(FolderError::io("write", &shown))?,
            }
            let unchanged = seen.get(&m.name).is_some_and(|meta| is_same(meta, &aside));
            if !unchanged && !stamp.is_of(&aside).unwrap_or(false) {
                return Err(FolderError::Foreign { path: shown, why: Foreign::Changed });
            }
        }
        Ok(())
    }

    /// Step 4.
    fn give_names(&self, moves: &[Move]) -> Result<(), FolderError> {
        for m in moves.iter().filter(|m| m.new.is_some()) {
            let shown = self.shown.join(&m.name);
            let placed = place(&self.staging.files().join(&m.name), &self.target.join(&m.name));
            if !placed.map_err(FolderError::io("write", &shown))? {
                return Err(FolderError::Foreign { path: shown, why: Foreign::NotListed });
            }
        }
        Ok(())
    }

    /// Step 2.
    fn announce(&self, manifest: &str, journal: &Journal) -> Result<(), FolderError> {
        self.write_synchronised(NEW_MANIFEST, manifest.as_bytes())?;
        let json = serde_json::to_vec(journal).map_err(io::Error::other);
        self.write_synchronised(JOURNAL, &json.map_err(FolderError::io("write into", self.shown))?)
    }

    /// Writes a file of the staging folder; under its name it is always whole.
    fn write_synchronised(&self, name: &str, bytes: &[u8]) -> Result<(), FolderError> {
        let path = self.staging.dir().join(name);
        let unfinished = path.with_extension("part");
        let save = || {
            let mut file = File::create(&unfinished)?;
            file.write_all(bytes)?;
            file.sync_all()?;
            fs::rename(&unfinished, &path)
        };
        save().map_err(FolderError::io("write into", self.shown))
    }

    /// The error with the folder as the user named it.
    fn named(&self, e: FolderError) -> FolderError {
        match e {
            FolderError::Io { action, source, .. } => {
                FolderError::Io { action, path: self.shown.into(), source }
            }
            FolderError::Manifest { why, .. } => {
                FolderError::Manifest { path: self.shown.join(MANIFEST), why }
            }
            FolderError::Busy { waited_s, .. } => FolderError::Busy { dir: self.shown.into(), waited_s },
            e => e,
        }
    }
}

fn is_same(meta: &Metadata, path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|now| {
        same_file(meta, &now) && meta.len() == now.len() && meta.modified().ok() == now.modified().ok()
    })
}

/// Step 6.
fn complete(staging: &Path, target: &Path, journal: &Journal) -> io::Result<()> {
    for folder in &journal.emptied {
        let _ = fs::remove_dir(target.join(folder)); // fails on one that holds something: it stays
    }
    fs::remove_file(staging.join(JOURNAL))?;
    match fs::remove_dir_all(staging.join(OLD)) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

/// Takes back what steps 3 and 4 did, as far as they came. May itself be cut off and repeated.
fn undo(staging: &Path, target: &Path, journal: &Journal) -> io::Result<()> {
    for m in journal.moves.iter().rev() {
        let (path, new, old) =
            (target.join(&m.name), staging.join("files").join(&m.name), staging.join(OLD).join(&m.name));
        if let (Some(stamp), Ok(Some(meta))) = (m.new, kind(&path)?) {
            match fs::symlink_metadata(&new) {
                // both names of one file: killed between making the second and removing the first
                Ok(staged) if same_file(&staged, &meta) => fs::remove_file(&path)?,
                Err(_) if stamp.is_of(&path)? => fs::rename(&path, &new)?,
                _ => {}
            }
        }
        if m.old.is_some() && fs::symlink_metadata(&old).is_ok() {
            let back = kind(&path)?;
            match (back, fs::symlink_metadata(&old)) {
                // killed while the old file was given its name back
                (Ok(Some(meta)), Ok(aside)) if same_file(&meta, &aside) => fs::remove_file(&old)?,
                // a name that somebody else took meanwhile stays theirs
                _ => drop(place(&old, &path)?),
            }
        }
    }
    for folder in journal.folders.iter().rev() {
        let _ = fs::remove_dir(target.join(folder));
    }
    fs::remove_file(staging.join(JOURNAL))
}

/// Staging folders with a journal for a target, in it and beside it.
fn pending(target: &Path) -> Vec<(PathBuf, Journal)> {
    let read = |dir: PathBuf| {
        let journal: Journal = serde_json::from_slice(&fs::read(dir.join(JOURNAL)).ok()?).ok()?;
        Some((dir, journal))
    };
    let inside = staging::staging_with(target, JOURNAL).into_iter().filter_map(read);
    let mut found: Vec<(PathBuf, Journal)> = inside.filter(|(_, j)| j.into.is_none()).collect();
    if let (Some(parent), Some(name)) = (target.parent(), target.file_name()) {
        let beside = staging::staging_with(parent, JOURNAL).into_iter().filter_map(read);
        found.extend(beside.filter(|(_, j)| j.into.as_deref().is_some_and(|into| name == into)));
    }
    // a journal with a name outside the target was not written by us
    found.retain(|(_, j)| {
        let names = j.moves.iter().map(|m| &m.name).chain(&j.folders).chain(&j.emptied);
        names.into_iter().all(|name| names::check(name).is_ok())
    });
    found
}

/// Removes what was to be moved into a folder that does not exist any more.
pub(super) fn forget(parent: &Path, name: &Path) {
    for dir in staging::staging_with(parent, JOURNAL) {
        let journal =
            fs::read(dir.join(JOURNAL)).ok().and_then(|b| serde_json::from_slice::<Journal>(&b).ok());
        if journal.is_some_and(|j| j.into.is_some_and(|into| Path::new(&into) == name))
            && staging::take_over(&dir).is_some()
        {
            let _ = fs::remove_dir_all(&dir);
        }
    }
}

/// Undoes or completes commits into a folder whose processes were killed; whether there were any.
///
/// If a commit is in progress, waits until it is done.
pub(super) fn recover(target: &Path) -> Result<bool, FolderError> {
    if pending(target).is_empty() {
        CommitLock::remove_ownerless(target);
        return Ok(false);
    }
    let _lock = CommitLock::acquire(target)?;
    recover_locked(target)
}

fn recover_locked(target: &Path) -> Result<bool, FolderError> {
    let mut any = false;
    for (staging, journal) in pending(target) {
        let Some(_owner) = staging::take_over(&staging) else { continue };
        let _pass = interrupt::pass();
        let is_undone = fs::symlink_metadata(staging.join(NEW_MANIFEST)).is_ok();
        let done = if is_undone { undo } else { complete };
        done(&staging, target, &journal).map_err(FolderError::io("write into", target))?;
        let _ = fs::remove_dir_all(&staging);
        any = true;
    }
    Ok(any)
}

/// Names, lengths and digests of all files in a staging folder, synchronised with the disk. Empty folders are removed.
pub(super) fn staged(files: &Path) -> Result<BTreeMap<String, Stamp>, FolderError> {
    let mut found = BTreeMap::new();
    collect(files, "", &mut found)?;
    Ok(found)
}

fn collect(folder: &Path, prefix: &str, found: &mut BTreeMap<String, Stamp>) -> Result<(), FolderError> {
    let failed = || FolderError::io("read", folder);
    for entry in fs::read_dir(folder).map_err(failed())? {
        let entry = entry.map_err(failed())?;
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        names::check(&name)?;
        let path = entry.path();
        if entry.file_type().map_err(failed())?.is_dir() {
            collect(&path, &format!("{name}/"), found)?;
            let _ = fs::remove_dir(&path); // fails on one that holds something
            continue;
        }
        let stamp = || {
            // synchronising needs a file opened for writing on some systems
            let file = OpenOptions::new().read(true).write(true).open(&path);
            let mut file = file.or_else(|_| File::open(&path))?;
            file.sync_all()?;
            Stamp::of_file(&mut file)
        };
        found.insert(name, stamp().map_err(FolderError::io("read", &path))?);
    }
    Ok(())
}

#[cfg(test)]
#[path = "commit_tests.rs"]
mod tests;
