//! The Python environment MuJoCo runs in.
//!
//! In: a Python on the machine. Out: a virtual environment with the pinned `mujoco` wheel, made once in the
//! user's cache and reused, offline too. Nothing is installed anywhere else.
//!
//! | variable | what it does |
//! |---|---|
//! | `CONTRAPPOSTO_PYTHON` | the Python to make it with, instead of `python3` or `python` |
//! | `CONTRAPPOSTO_CACHE` | where it is kept, instead of the user's cache folder |

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Mutex, PoisonError};

/// The MuJoCo that answers are compared with.
pub const MUJOCO: &str = "4.0.0";

/// Why there is no environment.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentError {
    /// No Python.
    #[error(
        "no Python found: looked for {looked}. The cross-check runs MuJoCo {MUJOCO}, a Python package: install Python 3.10 or newer with `venv` and `pip`, or name one with CONTRAPPOSTO_PYTHON"
    )]
    NoPython {
        /// The names tried.
        looked: String,
    },
    /// No folder to keep it in.
    #[error("no cache folder: neither CONTRAPPOSTO_CACHE nor XDG_CACHE_HOME, HOME or LOCALAPPDATA is set")]
    NoCache,
    /// A step that failed.
    #[error(
        "cannot make the Python environment in {place} (the network is needed once): `{command}` failed: {text}"
    )]
    Step {
        /// The folder.
        place: String,
        /// What was run.
        command: String,
        /// The last lines it said.
        text: String,
    },
}

/// Makes the environment or finds it made; returns its Python. `note` is called with what is being done.
///
/// # Errors
/// [`EnvironmentError`].
pub fn prepare(note: &mut dyn FnMut(&str)) -> Result<PathBuf, EnvironmentError> {
    let home = cache()?;
    let place = home.join(format!("mujoco-{MUJOCO}"));
    // two threads of one process take turns; two processes each make one, and the first to finish wins
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let ready = || place.join(READY).is_file();
    if ready() {
        return Ok(python_of(&place));
    }
    let python = find_python()?;
    note(&format!("making a Python environment with mujoco {MUJOCO} in {} (once)", place.display()));
    fs::create_dir_all(&home).map_err(|e| step(&place, "create the cache folder", e.to_string()))?;
    // made in another folder and moved when complete, so that no process uses half an environment
    let making = home.join(format!(".mujoco-{MUJOCO}.{}", std::process::id()));
    let made = make(&python, &making);
    let done = made.and_then(|()| {
        if !ready() {
            let _ = fs::remove_dir_all(&place);
        }
        match fs::rename(&making, &place) {
            Err(_) if ready() => Ok(()),
            moved => moved.map_err(|e| step(&place, "move it into place", e.to_string())),
        }
    });
    let _ = fs::remove_dir_all(&making);
    done.map(|()| python_of(&place))
}

static TURN: Mutex<()> = Mutex::new(());

/// Written when everything is installed.
const READY: &str = "ready";

fn make(python: &str, making: &Path) -> Result<(), EnvironmentError> {
    run(making, Command::new(python).args(["-m", "venv"]).arg(making))?;
    let wheel = format!("mujoco=={MUJOCO}");
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:"];
    run(making, Command::new(python_of(making)).args(pip).args([&wheel, "numpy"]))?;
    fs::write(making.join(READY), &wheel).map_err(|e| step(making, "mark it ready", e.to_string()))
}

fn run(place: &Path, command: &mut Command) -> Result<(), EnvironmentError> {
    let shown = format!("{command:?}").replace('"', "");
    match command.output() {
        Ok(out) if out.status.success() => Ok(()),
        Ok(out) => Err(step(place, &shown, last_lines(&out))),
        Err(e) => Err(step(place, &shown, e.to_string())),
    }
}

fn last_lines(out: &Output) -> String {
    let all = [out.stdout.as_slice(), out.stderr.as_slice()].concat();
    let text = String::from_utf8_lossy(&all);
    let lines: Vec<&str> = text.lines().filter(|l| !l.trim().is_empty()).collect();
    lines[lines.len().saturating_sub(4)..].join("\n  ")
}

fn step(place: &Path, command: &str, text: String) -> EnvironmentError {
    EnvironmentError::Step { place: place.display().to_string(), command: command.into(), text }
}

fn cache() -> Result<PathBuf, EnvironmentError> {
    let of = |name: &str| env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    of("CONTRAPPOSTO_CACHE")
        .or_else(|| of("XDG_CACHE_HOME").map(|p| p.join("contrapposto")))
        .or_else(|| of("HOME").map(|p| p.join(".cache").join("contrapposto")))
        .or_else(|| of("LOCALAPPDATA").map(|p| p.join("contrapposto")))
        .ok_or(EnvironmentError::NoCache)
}

fn find_python() -> Result<String, EnvironmentError> {
    let named = env::var("CONTRAPPOSTO_PYTHON").ok().filter(|v| !v.is_empty());
    let names = named.map_or_else(|| vec!["python3".into(), "python".into()], |n| vec![n]);
    let works = |name: &&String| {
        let asked =
            Command::new(name).args(["-c", "import sys; sys.exit(sys.version_info < (3, 10))"]).output();
        asked.is_ok_and(|out| out.status.success())
    };
    let found = names.iter().find(works).cloned();
    found.ok_or_else(|| EnvironmentError::NoPython { looked: names.join(", ") })
}

fn python_of(place: &Path) -> PathBuf {
    if cfg!(windows) { place.join("Scripts").join("python.exe") } else { place.join("bin").join("python") }
}
