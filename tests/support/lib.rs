//! What the tests of all crates share: where things are, and Python. No dependencies; a development dependency only.
//!
//! In: names of files and modules. Out: paths that exist, or a panic that says what is missing and where it was looked for: a test that
//! needs data does not pass without them. The one exception is Python: a test that needs it and cannot have it prints a line
//! `skipped: NAME: why`, and `.ci/run` fails on such lines.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The repository's root.
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).expect("tests/support lies in the repository").into()
}

/// A file or folder of the repository's library, by its path in `scenes`: `bow.ron`, `characters/human.ron`.
///
/// # Panics
/// If it does not exist.
pub fn scene(path: &str) -> PathBuf {
    existing(&root().join("scenes"), path, "the library of the repository")
}

/// A file or folder of the real data beside the repository, by its path in `shared`: `mocap/bvh/16_21.bvh`.
///
/// # Panics
/// If it does not exist.
pub fn shared(path: &str) -> PathBuf {
    let folder = root().join("../shared");
    existing(&folder, path, "the data that lie beside the repository; without them these tests cannot run")
}

fn existing(folder: &Path, path: &str, what: &str) -> PathBuf {
    let whole = folder.join(path);
    assert!(whole.exists(), "no `{path}` in {}, {what}", folder.display());
    whole
}

/// Files of a folder that end in `.extension`, by name.
///
/// # Panics
/// If there is none.
pub fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let read = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut all: Vec<PathBuf> = read
        .map(|entry| entry.expect("an entry of a folder that can be read").path())
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .collect();
    assert!(!all.is_empty(), "no *.{extension} in {}", folder.display());
    all.sort();
    all
}

/// Python with all of `modules`, to be called; `None`, after the line `skipped: TEST: why`, where there is none.
pub fn python(test: &str, modules: &[&str]) -> Option<Command> {
    let imports: Vec<String> = modules.iter().map(|m| format!("import {m}")).collect();
    let tried = Command::new("python3")
        .args(["-c", &imports.join("\n")])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let why = match tried {
        Ok(status) if status.success() => return Some(Command::new("python3")),
        Ok(_) => format!("python3 has not all of {modules:?}"),
        Err(e) => format!("python3: {e}"),
    };
    // not `eprintln!`: the line is for CI, and the harness would keep it to itself when the test passes
    let line = format!("skipped: {test}: {why}\n");
    let _ = std::io::Write::write_all(&mut std::io::stderr(), line.as_bytes());
    None
}
