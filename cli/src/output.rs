//! Text on standard output, and what is said of results.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use takes::results::folder::Overwrite;
use takes::results::write::Undrawn;

use crate::failure::Failure;

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

/// Prints a value as indented JSON.
///
/// # Errors
/// Of standard output.
pub fn json(value: &impl Serialize) -> Result<(), Failure> {
    print(&to_json(value)?)
}

/// A value as indented JSON with a final newline.
///
/// # Errors
/// A value that JSON cannot hold.
pub fn to_json(value: &impl Serialize) -> Result<String, Failure> {
    Ok(serde_json::to_string_pretty(value).map_err(Failure::run)? + "\n")
}

/// What `--force` says of a file that is there.
pub fn overwrite(force: bool) -> Overwrite {
    if force { Overwrite::Allow } else { Overwrite::Refuse }
}

/// The folder for results: the one asked for, or `out/NAME`.
pub fn folder(asked: Option<&Path>, name: &str) -> PathBuf {
    asked.map_or_else(|| Path::new("out").join(name), Path::to_owned)
}

/// Names figures that could not be drawn; everything else is on disk by then.
///
/// # Errors
/// If there are any: the run is done, but not all of it.
pub fn undrawn(missing: &[Undrawn], dir: &Path) -> Result<(), Failure> {
    if missing.is_empty() {
        return Ok(());
    }
    let each: Vec<String> = missing.iter().map(|u| format!("{} ({})", u.stem, u.why)).collect();
    Err(Failure::Run(format!(
        "figures that could not be drawn: {}; all other results are in {}",
        each.join(", "),
        dir.display()
    )))
}
