//! The Python environment MuJoCo runs in.
//!
//! In: a Python on the machine. Out: a virtual environment with MuJoCo, made once in the user's cache and reused, offline too.
//! Every package in it is one of `requirements.txt`, with its version and the hash of its wheel: pip takes no other. Nothing is
//! installed anywhere else.
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

use takes::results::folder::Scratch;

/// The MuJoCo that answers are compared with.
pub const MUJOCO: &str = "4.0.0";

/// Why there is no environment.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentError {
    /// No Python.
    #[error(
        "no Python found: looked for {looked}. The cross-check runs MuJoCo {MUJOCO}, a Python package: install Python 3.11 or newer with `venv` and `pip`, or name one with CONTRAPPOSTO_PYTHON"
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
    let place = home.join(format!("mujoco-{MUJOCO}-pinned"));
    // two threads of one process take turns; two processes each make one, and the first to finish wins
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let ready = || fs::read_to_string(place.join(READY)).is_ok_and(|made_of| made_of == REQUIREMENTS);
    if ready() {
        return Ok(python_of(&place));
    }
    let python = find_python()?;
    note(&format!("making a Python environment with mujoco {MUJOCO} in {} (once)", place.display()));
    // made in another folder and moved when complete, so that no process uses half an environment; removed at Ctrl-C
    let making =
        Scratch::beside(&home).map_err(|e| step(&place, "write into the cache folder", e.to_string()))?;
    make(&python, making.path())?;
    if !ready() {
        let _ = fs::remove_dir_all(&place);
    }
    match fs::rename(making.path(), &place) {
        Err(_) if ready() => {}
        moved => moved.map_err(|e| step(&place, "move it into place", e.to_string()))?,
    }
    Ok(python_of(&place))
}

static TURN: Mutex<()> = Mutex::new(());

/// Written when everything is installed: what it was made of, so that another version is made anew.
const READY: &str = "ready";
/// What is installed: every package, its version and the hashes of its wheels.
const REQUIREMENTS: &str = include_str!("requirements.txt");

fn make(python: &str, making: &Path) -> Result<(), EnvironmentError> {
    run(making, Command::new(python).args(["-m", "venv"]).arg(making))?;
    let list = making.join("requirements.txt");
    fs::write(&list, REQUIREMENTS).map_err(|e| step(making, "write the list of packages", e.to_string()))?;
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    let pinned = ["--only-binary", ":all:", "--require-hashes", "--requirement"];
    run(making, Command::new(python_of(making)).args(pip).args(pinned).arg(&list))?;
    fs::rename(&list, making.join(READY)).map_err(|e| step(making, "mark it ready", e.to_string()))
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
            Command::new(name).args(["-c", "import sys; sys.exit(sys.version_info < (3, 11))"]).output();
        asked.is_ok_and(|out| out.status.success())
    };
    let found = names.iter().find(works).cloned();
    found.ok_or_else(|| EnvironmentError::NoPython { looked: names.join(", ") })
}

fn python_of(place: &Path) -> PathBuf {
    if cfg!(windows) { place.join("Scripts").join("python.exe") } else { place.join("bin").join("python") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every package has one version and a hash; MuJoCo's is the one that is named in messages and results.
    #[test]
    fn every_package_is_pinned_by_hash() {
        let text = REQUIREMENTS.replace("\\\n", " ");
        let packages: Vec<&str> = text.lines().filter(|l| !l.trim_start().starts_with('#')).collect();
        assert!(packages.len() > 5, "{packages:?}");
        for package in &packages {
            assert!(package.contains("==") && package.contains("--hash=sha256:"), "{package}");
        }
        let mujoco = format!("mujoco=={MUJOCO} ");
        assert!(packages.iter().any(|p| p.starts_with(&mujoco)), "{mujoco}");
    }

    /// What is installed is what is pinned, and nothing else but pip and its tools.
    #[test]
    fn slow_what_is_installed_is_what_is_pinned() {
        let python = prepare(&mut |_| {}).expect("an environment");
        let list = "import importlib.metadata as m\nfor d in m.distributions(): print(d.name.lower() + '==' + d.version)";
        let out = Command::new(python).args(["-c", list]).output().expect("Python runs");
        let installed = String::from_utf8_lossy(&out.stdout).into_owned();
        let ours = |l: &&str| !["pip==", "setuptools=="].iter().any(|tool| l.starts_with(tool));
        let installed: Vec<&str> = installed.lines().filter(ours).collect();
        assert!(installed.len() > 5, "{installed:?}");
        for package in installed {
            assert!(REQUIREMENTS.contains(&format!("{package} ")), "{package} is not pinned");
        }
    }
}
