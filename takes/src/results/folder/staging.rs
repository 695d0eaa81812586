//! Temporary files and folders with an owner: unique names, a lock, and removal of those without an owner.
//!
//! A name is `.contrapposto-PID-RANDOM.tmp`. Whether its owner lives is told by a lock of the operating system
//! (`flock`), which ends with the process, not by the process number, which containers share. A staging folder:
//!
//! | in it | what |
//! |---|---|
//! | `lock` | made first, locked as long as the owner lives |
//! | `files/` | the output, as it will be in the target |
//! | `manifest.json`, `journal.json`, `old/` | during a commit, see `commit` |
//!
//! A file under such a name (a single file being written) is itself locked. Where a file system has no locks,
//! nothing is taken for ownerless.

use std::fs::{self, File, Metadata, OpenOptions, TryLockError};
use std::hash::{BuildHasher, RandomState};
use std::io;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use super::error::FolderError;
use super::interrupt::{self, Temporary};
use super::names::RESERVED;

/// The file that is locked in a staging folder.
const LOCK: &str = "lock";
/// The file that is locked in a folder while somebody commits into it.
const COMMIT_LOCK: &str = ".contrapposto.lock";
/// New names that are tried when another process removes ours before it is locked.
const ATTEMPTS: usize = 20;
/// How long another process may hold a folder for its commit before that is an error.
const LONGEST_COMMIT: Duration = Duration::from_secs(30);
const PAUSE: Duration = Duration::from_millis(2);

/// A name no other process has.
fn unique_name() -> String {
    // the standard library's hash keys are random numbers of the operating system
    let random = RandomState::new().hash_one(std::time::SystemTime::now());
    format!("{RESERVED}-{}-{random:016x}.tmp", std::process::id())
}

fn is_temporary_name(name: &str) -> bool {
    name.strip_prefix(RESERVED).is_some_and(|rest| rest.starts_with('-') && rest.ends_with(".tmp"))
}

/// Whether an open file is still the one at a path.
fn is_at(file: &File, path: &Path) -> bool {
    match (file.metadata(), fs::symlink_metadata(path)) {
        (Ok(a), Ok(b)) => same_file(&a, &b),
        _ => false,
    }
}

#[cfg(unix)]
pub(super) fn same_file(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
pub(super) fn same_file(a: &Metadata, b: &Metadata) -> bool {
    (a.len(), a.created().ok()) == (b.len(), b.created().ok())
}

/// Whether a file that was just made is ours: locked, and not removed meanwhile. A file system without locks says yes.
fn own(file: &File, path: &Path) -> bool {
    !matches!(file.try_lock(), Err(TryLockError::WouldBlock)) && is_at(file, path)
}

/// A folder in which output is made.
#[derive(Debug)]
pub(super) struct Staging {
    temporary: Temporary,
    _lock: File,
}

impl Staging {
    /// In a folder, which is made with those above it if it does not exist.
    pub(super) fn create(home: &Path) -> io::Result<Self> {
        for _ in 0..ATTEMPTS {
            let made = {
                let _pass = interrupt::pass();
                let folders = create_folders(home)?;
                let dir = fs::canonicalize(home).map(|home| home.join(unique_name()));
                match dir.and_then(|dir| fs::create_dir(&dir).map(|()| dir)) {
                    Ok(dir) => Temporary::with_folders(dir, folders),
                    Err(e) => {
                        folders.iter().for_each(|f| drop(fs::remove_dir(f)));
                        return Err(e);
                    }
                }
            };
            let path = made.path().join(LOCK);
            let lock = match OpenOptions::new().write(true).create_new(true).open(&path) {
                Err(e) if e.kind() == io::ErrorKind::NotFound => continue,
                lock => lock?,
            };
            if own(&lock, &path) {
                let staging = Self { temporary: made, _lock: lock };
                fs::create_dir(staging.files())?;
                return Ok(staging);
            }
        }
        Err(io::Error::other("its temporary folder is removed again and again by another process"))
    }

    pub(super) fn dir(&self) -> &Path {
        self.temporary.path()
    }

    pub(super) fn files(&self) -> PathBuf {
        self.dir().join("files")
    }

    /// Leaves the folder where it is: a journal in it is still needed.
    pub(super) fn keep(&self) {
        self.temporary.keep();
    }
}

/// Makes a folder and those above it; which were made, innermost first.
fn create_folders(path: &Path) -> io::Result<Vec<PathBuf>> {
    let missing: Vec<PathBuf> = path
        .ancestors()
        .take_while(|p| !p.as_os_str().is_empty() && !p.exists())
        .map(Path::to_owned)
        .collect();
    let done = if path.as_os_str().is_empty() { Ok(()) } else { fs::create_dir_all(path) };
    done.inspect_err(|_| missing.iter().for_each(|f| drop(fs::remove_dir(f))))?;
    Ok(missing)
}

/// A temporary file, locked, and its guard.
pub(super) fn temporary_file(folder: &Path) -> io::Result<(File, Temporary)> {
    for _ in 0..ATTEMPTS {
        let (file, temporary) = {
            let _pass = interrupt::pass();
            let path = folder.join(unique_name());
            let file = OpenOptions::new().write(true).create_new(true).open(&path)?;
            (file, Temporary::new(path))
        };
        if own(&file, temporary.path()) {
            return Ok((file, temporary));
        }
    }
    Err(io::Error::other("its temporary file is removed again and again by another process"))
}

/// Names of temporary files and folders of any process in a folder; none if it cannot be read.
fn temporaries(home: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(home).into_iter().flatten().flatten();
    let ours = entries.filter(|e| e.file_name().to_str().is_some_and(is_temporary_name));
    ours.map(|e| e.path()).collect()
}

/// Staging folders in a folder that have this file.
pub(super) fn staging_with(home: &Path, file: &str) -> Vec<PathBuf> {
    temporaries(home).into_iter().filter(|dir| fs::symlink_metadata(dir.join(file)).is_ok()).collect()
}

/// The lock of a staging folder, if its owner lives no more.
pub(super) fn take_over(dir: &Path) -> Option<File> {
    let path = dir.join(LOCK);
    let file = OpenOptions::new().write(true).open(&path).ok()?;
    (file.try_lock().is_ok() && is_at(&file, &path)).then_some(file)
}

/// Removes temporary files and folders in a folder whose owner lives no more. Staging folders with this file stay.
pub(super) fn remove_ownerless(home: &Path, but_with: &str) {
    for path in temporaries(home) {
        let Ok(meta) = fs::symlink_metadata(&path) else { continue };
        if meta.is_file() {
            let file = OpenOptions::new().write(true).open(&path);
            if file.is_ok_and(|f| f.try_lock().is_ok() && is_at(&f, &path)) {
                let _ = fs::remove_file(&path);
            }
        } else if meta.is_dir() && fs::symlink_metadata(path.join(but_with)).is_err() {
            // an empty one: ended before its lock was made; if its owner lives, it takes another name
            if fs::remove_dir(&path).is_ok() {
                continue;
            }
            let lock = take_over(&path);
            // the lock is made first: one with content but without a lock was half removed
            let half_removed =
                || fs::symlink_metadata(path.join(LOCK)).is_err_and(|e| e.kind() == io::ErrorKind::NotFound);
            let ownerless = lock.is_some() || half_removed();
            if ownerless && fs::symlink_metadata(path.join(but_with)).is_err() {
                let _ = fs::remove_dir_all(&path);
            }
        }
    }
}

/// A folder held for a commit; nobody else of our kind changes it.
#[derive(Debug)]
pub(super) struct CommitLock {
    // dropped first: the file is removed while it is locked
    _temporary: Temporary,
    _file: File,
}

impl CommitLock {
    /// Removes the lock's file if a killed process left it.
    pub(super) fn remove_ownerless(dir: &Path) {
        let path = dir.join(COMMIT_LOCK);
        let _pass = interrupt::pass();
        let file = OpenOptions::new().write(true).open(&path);
        if file.is_ok_and(|file| file.try_lock().is_ok() && is_at(&file, &path)) {
            let _ = fs::remove_file(&path);
        }
    }

    /// Waits until the folder is free.
    pub(super) fn acquire(dir: &Path) -> Result<Self, FolderError> {
        let path = dir.join(COMMIT_LOCK);
        let started = Instant::now();
        loop {
            {
                let _pass = interrupt::pass();
                let file = OpenOptions::new().write(true).create(true).truncate(false).open(&path);
                let file = file.map_err(FolderError::io("write into", dir))?;
                // who removes the file holds it, so one that was locked after its removal is no lock
                if own(&file, &path) {
                    return Ok(Self { _temporary: Temporary::new(path), _file: file });
                }
            }
            if started.elapsed() > LONGEST_COMMIT {
                return Err(FolderError::Busy { dir: dir.into(), waited_s: LONGEST_COMMIT.as_secs() });
            }
            thread::sleep(PAUSE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(dir: &Path) -> usize {
        fs::read_dir(dir).unwrap().count()
    }

    #[test]
    fn names_differ_within_one_process() {
        let names: std::collections::BTreeSet<String> = (0..1000).map(|_| unique_name()).collect();
        assert_eq!(names.len(), 1000);
        assert!(names.iter().all(|n| is_temporary_name(n)));
        assert!(!is_temporary_name(".contrapposto.json") && !is_temporary_name(COMMIT_LOCK));
    }

    /// Each kind of remainder of a killed process goes; what is held stays.
    #[test]
    fn the_ownerless_are_removed_and_the_held_stay() {
        let dir = tempfile::tempdir().unwrap();
        let held = Staging::create(dir.path()).unwrap();
        let (_file, held_file) = temporary_file(dir.path()).unwrap();
        let stale = |n: u32| dir.path().join(format!("{RESERVED}-{n}-0123456789abcdef.tmp"));
        fs::create_dir(stale(1)).unwrap(); // before its lock was made
        fs::create_dir_all(stale(2).join("files/plots")).unwrap(); // half removed
        fs::create_dir_all(stale(3).join("files")).unwrap();
        fs::write(stale(3).join(LOCK), "").unwrap(); // whole
        fs::write(stale(4), "half").unwrap(); // a file
        fs::create_dir(stale(5)).unwrap();
        fs::write(stale(5).join("journal.json"), "").unwrap(); // to be recovered
        fs::write(dir.path().join(".contrapposto-notes.txt"), "a person's").unwrap();
        remove_ownerless(dir.path(), "journal.json");
        assert!(held.files().exists() && held_file.path().exists() && stale(5).exists());
        assert!((1..5).all(|n| !stale(n).exists()));
        assert_eq!(entries(dir.path()), 4);
        drop((held, held_file));
        assert_eq!(entries(dir.path()), 2);
    }

    #[test]
    fn folders_made_on_the_way_go_with_the_staging_folder() {
        let dir = tempfile::tempdir().unwrap();
        let staging = Staging::create(&dir.path().join("a/b")).unwrap();
        assert!(staging.dir().starts_with(dir.path().join("a/b")));
        drop(staging);
        assert_eq!(entries(dir.path()), 0);
    }

    #[test]
    fn one_holds_the_commit_lock_at_a_time() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join(COMMIT_LOCK), "").unwrap(); // of a killed process
        let counter = std::sync::Mutex::new(0);
        thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..50 {
                        let _lock = CommitLock::acquire(dir.path()).unwrap();
                        let mut inside = counter.try_lock().expect("two hold the lock");
                        *inside += 1;
                        CommitLock::remove_ownerless(dir.path());
                        assert!(dir.path().join(COMMIT_LOCK).exists());
                    }
                });
            }
        });
        assert_eq!((counter.into_inner().unwrap(), entries(dir.path())), (400, 0));
        fs::write(dir.path().join(COMMIT_LOCK), "").unwrap();
        CommitLock::remove_ownerless(dir.path());
        assert_eq!(entries(dir.path()), 0);
    }
}
