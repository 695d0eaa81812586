//! Output folders: all files or none, and text on standard output.
//!
//! Files are written into a temporary folder and moved into place when all are complete. A folder that
//! does not exist appears whole, by one rename; in one that does, the files are renamed over earlier
//! ones and other files stay, except earlier output of ours that this run does not have: a
//! `dynamic.bvh` beside a newer `kinematic.bvh` would lie.

use std::ffi::OsString;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::figures;

/// Files a run may leave in its folder, besides figures; those not written anew are removed.
const OURS: &[&str] =
    &["kinematic.bvh", "kinematic.glb", "dynamic.bvh", "dynamic.glb", "trace.npz", "report.json"];
/// The folder of figures.
pub const PLOTS: &str = "plots";

/// A folder in the making; dropped, it leaves nothing behind.
pub struct Output {
    target: PathBuf,
    staging: PathBuf,
    existed: bool,
    ours: Vec<PathBuf>,
}

impl Output {
    /// Begins a folder of a run.
    ///
    /// # Errors
    /// If it cannot be written to.
    pub fn begin(target: &Path) -> Result<Self, Failure> {
        let spans = span_folders(target);
        let of_spans = spans.iter().flat_map(|span| ours().map(move |file| span.join(file)));
        Self::replacing(target, ours().chain(of_spans).collect())
    }

    /// Begins a folder in which these files, if not written anew, are removed; all others stay.
    ///
    /// # Errors
    /// If it cannot be written to.
    pub fn replacing(target: &Path, ours: Vec<PathBuf>) -> Result<Self, Failure> {
        let fail = |e: io::Error| Failure::run(format!("cannot write into {}: {e}", target.display()));
        let existed = target.is_dir();
        // inside a folder that exists: its parent may be closed to us, or another file system
        let parent = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let home = if existed { target } else { parent };
        fs::create_dir_all(home).map_err(fail)?;
        if !existed && fs::symlink_metadata(target).is_ok() {
            return Err(fail(io::Error::new(io::ErrorKind::AlreadyExists, "it is a file, not a folder")));
        }
        let staging = home.join(format!(".contrapposto.{}.tmp", std::process::id()));
        fs::create_dir(&staging).map_err(fail)?;
        Ok(Self { target: target.to_owned(), staging, existed, ours })
    }

    /// Checks that a folder can be written to, leaving nothing behind.
    ///
    /// # Errors
    /// As [`Output::begin`].
    pub fn check(target: &Path) -> Result<(), Failure> {
        // folders made on the way are taken away again
        let made = first_missing(target.parent().unwrap_or(Path::new("")));
        let done = Self::begin(target).map(drop);
        let mut folder = target.parent();
        while let (Some(first), Some(f)) = (&made, folder) {
            let _ = fs::remove_dir(f); // fails on one that holds something: it stays
            folder = (f != first).then(|| f.parent()).flatten();
        }
        done
    }

    /// Where to write for now.
    pub fn dir(&self) -> &Path {
        &self.staging
    }

    /// Moves everything into place.
    ///
    /// # Errors
    /// Of the file system, with the file.
    pub fn finish(self) -> Result<(), Failure> {
        if !self.existed && fs::rename(&self.staging, &self.target).is_ok() {
            return Ok(());
        }
        let fail = |path: &Path, e: io::Error| Failure::run(format!("cannot write {}: {e}", path.display()));
        fs::create_dir_all(&self.target).map_err(|e| fail(&self.target, e))?;
        let mut files = files(&self.staging).map_err(|e| fail(&self.staging, e))?;
        for name in self.ours.iter().filter(|n| !files.contains(n)) {
            let path = self.target.join(name);
            match fs::remove_file(&path) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(fail(&path, e)),
                _ => {}
            }
        }
        // the report comes last: where it is new, everything is
        files.sort_by_key(|name| name.file_name().is_some_and(|n| n == "report.json"));
        for name in files {
            let to = self.target.join(&name);
            let folder = to.parent().unwrap_or(&self.target);
            let moved = fs::create_dir_all(folder).and_then(|()| fs::rename(self.staging.join(&name), &to));
            moved.map_err(|e| fail(&to, e))?;
        }
        // folders go if they are empty
        for folder in span_folders(&self.target).into_iter().chain([PathBuf::new()]) {
            let _ = fs::remove_dir(self.target.join(&folder).join(PLOTS));
            let _ = fs::remove_dir(self.target.join(&folder));
        }
        Ok(())
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.staging);
    }
}

/// The topmost folder of a path that does not exist.
fn first_missing(path: &Path) -> Option<PathBuf> {
    let missing = path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists());
    missing.last().map(Path::to_owned)
}

/// Every file a run may leave in its folder, relative to it.
fn ours() -> impl Iterator<Item = PathBuf> {
    let figures = figures::stems()
        .flat_map(|stem| ["svg", "png"].map(|kind| Path::new(PLOTS).join(format!("{stem}.{kind}"))));
    OURS.iter().map(PathBuf::from).chain(figures)
}

/// Folders of standing spans in a folder, relative to it.
fn span_folders(folder: &Path) -> Vec<PathBuf> {
    let names = fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.file_name());
    let is_span = |name: &OsString| {
        let number = name.to_str().and_then(|n| n.strip_prefix("span_"));
        number.is_some_and(|n| n.parse::<usize>().is_ok())
    };
    let mut found: Vec<PathBuf> = names.filter(is_span).map(PathBuf::from).collect();
    found.sort();
    found
}

/// Files in a folder and the folders in it, sorted, relative to it.
fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = PathBuf::from(entry.file_name());
        if entry.file_type()?.is_dir() {
            found.extend(files(&entry.path())?.into_iter().map(|f| name.join(f)));
        } else {
            found.push(name);
        }
    }
    found.sort();
    Ok(found)
}

/// Prints on standard output; a reader that has gone away (`| head`) is no failure.
///
/// # Errors
/// Of standard output.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::run(format!("cannot write to standard output: {e}")))
        }
        _ => Ok(()),
    }
}
