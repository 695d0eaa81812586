//! Ctrl-C: temporary files and folders of this process are removed before it ends.
//!
//! A process has a list of its temporary paths ([`Temporary`], a guard value). [`install`] starts a thread that
//! waits for SIGINT and SIGTERM. On the first one it waits for a commit in progress (milliseconds), removes all
//! paths of the list and ends the process with exit code 130 (SIGINT) or 143 (SIGTERM). A second signal ends the
//! process at once, and so does the time limit [`LIMIT`]. What is left then is removed by the next run into the
//! same folder. Outside Unix, `install` does nothing and the next run cleans up.
//!
//! Operations that must not be cut in two (a commit; making a path and entering it in the list) hold the *gate*
//! for reading. The removing thread holds it for writing and keeps it until the process has ended. So a thread
//! that fails because its temporary folder was removed under it stops when it drops its guard, and cannot end the
//! process with another exit code.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard};
use std::time::Duration;

/// The process ends this long after the first signal, whatever it is doing.
pub const LIMIT: Duration = Duration::from_millis(400);
/// Signals this soon after the first one count as the same: `timeout` and some shells send each twice.
pub const SAME: Duration = Duration::from_millis(40);

static GATE: RwLock<()> = RwLock::new(());
static LIST: Mutex<BTreeMap<u64, Listed>> = Mutex::new(BTreeMap::new());
static NEXT: AtomicU64 = AtomicU64::new(0);

/// What is to be removed.
#[derive(Debug, Clone)]
struct Listed {
    path: PathBuf,
    /// Folders that were made to hold it, innermost first; they go if they are empty.
    made: Vec<PathBuf>,
}

/// Permission to do what must not be cut in two. Never ask for it while holding it.
pub(super) fn pass() -> RwLockReadGuard<'static, ()> {
    GATE.read().unwrap_or_else(PoisonError::into_inner)
}

fn list() -> MutexGuard<'static, BTreeMap<u64, Listed>> {
    LIST.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary file or folder: removed when the value is dropped, and when the process is interrupted.
#[derive(Debug)]
pub struct Temporary {
    key: u64,
    path: PathBuf,
}

impl Temporary {
    /// Enters a path; make what is there afterwards.
    #[must_use]
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self::with_folders(path.into(), Vec::new())
    }

    /// As [`Temporary::new`], with folders that were made to hold it, innermost first.
    pub(super) fn with_folders(path: PathBuf, made: Vec<PathBuf>) -> Self {
        let key = NEXT.fetch_add(1, Ordering::Relaxed);
        list().insert(key, Listed { path: path.clone(), made });
        Self { key, path }
    }

    /// The path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Takes the path off the list: it was moved into place, or is to stay.
    pub fn keep(&self) {
        list().remove(&self.key);
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !list().contains_key(&self.key) {
            return; // kept
        }
        let _pass = pass();
        // removed before it is taken off the list, so that an interruption finds it there
        let listed = list().get(&self.key).cloned();
        if let Some(listed) = listed {
            let _ = remove(&listed).or_else(|_| remove(&listed));
        }
        list().remove(&self.key);
    }
}

/// Removes a file, or a folder with all that is in it; fine if nothing is there. A symbolic link is removed, not followed.
///
/// Fails while another thread makes or removes files in the folder, even if with `NotFound`; try again then.
fn remove(listed: &Listed) -> io::Result<()> {
    match fs::symlink_metadata(&listed.path) {
        Ok(meta) if meta.is_dir() => fs::remove_dir_all(&listed.path)?,
        Ok(_) => fs::remove_file(&listed.path)?,
        Err(e) if e.kind() == io::ErrorKind::NotFound => {}
        Err(e) => return Err(e),
    }
    remove_made(listed);
    Ok(())
}

fn remove_made(listed: &Listed) {
    for folder in &listed.made {
        let _ = fs::remove_dir(folder); // fails on one that holds something: it stays
    }
}

/// Installs the handler for SIGINT and SIGTERM. Call it once, at the start of a program; a second call does nothing.
///
/// # Errors
/// If the operating system refuses the handler or its thread.
pub fn install() -> io::Result<()> {
    #[cfg(unix)]
    signals::install()?;
    Ok(())
}

#[cfg(unix)]
mod signals {
    use std::sync::{Mutex, PoisonError};
    use std::time::{Duration, Instant};
    use std::{io, thread};

    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::exit;

    use super::{GATE, LIMIT, SAME, list, remove, remove_made};

    /// Time between two looks for a second signal, and between two attempts to remove a path.
    const PAUSE: Duration = Duration::from_millis(2);
    /// Exit code of a process ended by signal n is this + n, by convention of the shells.
    const ENDED_BY_SIGNAL: i32 = 128;

    pub(super) fn install() -> io::Result<()> {
        static INSTALLED: Mutex<bool> = Mutex::new(false);
        let mut installed = INSTALLED.lock().unwrap_or_else(PoisonError::into_inner);
        if *installed {
            return Ok(());
        }
        let signals = Signals::new([SIGINT, SIGTERM])?;
        thread::Builder::new().name("signals".into()).spawn(|| wait(signals))?;
        *installed = true;
        Ok(())
    }

    fn wait(mut signals: Signals) {
        let Some(signal) = signals.forever().next() else { return };
        let started = Instant::now();
        let code = ENDED_BY_SIGNAL + signal;
        let cleaner = thread::Builder::new().name("cleaner".into()).spawn(move || {
            clean();
            exit(code)
        });
        if cleaner.is_err() {
            exit(code); // no thread to be had: the next run cleans up
        }
        thread::sleep(SAME);
        signals.pending().for_each(drop);
        while started.elapsed() < LIMIT && signals.pending().next().is_none() {
            thread::sleep(PAUSE);
        }
        exit(code)
    }

    /// Removes everything on the list. Does not give the gate back: no thread may begin anything after this.
    fn clean() {
        std::mem::forget(GATE.write().unwrap_or_else(PoisonError::into_inner));
        let all: Vec<_> = list().values().cloned().collect();
        let mut left = all.clone();
        while !left.is_empty() {
            // a thread that is just writing into a folder can make it fail; it soon finds the folder gone
            left.retain(|listed| remove(listed).is_err());
            if !left.is_empty() {
                thread::sleep(PAUSE);
            }
        }
        // two may have been in one folder that was made for the first of them
        all.iter().for_each(remove_made);
    }
}
