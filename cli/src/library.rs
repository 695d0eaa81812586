//! The library on the command line: names to paths, `library`, `new`.
//!
//! [`resolve`] says which argument of which command is a file of which kind; what a name means, `scenes::library` knows.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use takes::library::{self, Entry, Kind};
use takes::starter;

use crate::args::{Command, LibraryArgs, NewArgs};
use crate::failure::Failure;
use crate::output;

/// Replaces names of the library by the paths they stand for.
///
/// # Errors
/// A name that is not there.
pub fn resolve(command: &mut Command) -> Result<(), Failure> {
    const SCENE: &[Kind] = &[Kind::Scene];
    const BODY: &[Kind] = &[Kind::Character];
    const ANY: &[Kind] = &[Kind::Scene, Kind::Character];
    let path = |path: &mut PathBuf, kinds| {
        *path = library::resolve(path, kinds).map_err(Failure::input)?;
        Ok(())
    };
    let given = |file: &mut Option<PathBuf>, kinds| file.as_mut().map_or(Ok(()), |file| path(file, kinds));
    // a folder is that of a run here
    let motion = |file: &mut PathBuf| if file.is_dir() { Ok(()) } else { path(file, SCENE) };
    match command {
        Command::Render(args) => path(&mut args.input, SCENE).and(given(&mut args.body, BODY)),
        Command::Inspect(args) => path(&mut args.input, ANY),
        Command::Plot(args) => motion(&mut args.input).and(given(&mut args.dynamics.body, BODY)),
        Command::Analyze(args) => motion(&mut args.input).and(given(&mut args.dynamics.body, BODY)),
        Command::Crosscheck(args) => path(&mut args.input, ANY).and(given(&mut args.against, ANY)),
        Command::Push(args) => path(&mut args.input, SCENE),
        Command::Tune(args) => given(&mut args.input, SCENE),
        Command::Retarget(args) => path(&mut args.input, SCENE)
            .and(path(&mut args.to, BODY))
            .and(given(&mut args.keyposes, &[Kind::KeyPoses]))
            .and(given(&mut args.body, BODY)),
        Command::Pose(args) => path(&mut args.input, SCENE),
        Command::Style(args) => args.inputs().into_iter().try_for_each(|file| path(file, SCENE)),
        Command::Convert(args) => path(&mut args.input, ANY),
        Command::Library(_) | Command::New(_) | Command::Propagate(_) => Ok(()),
    }
}

/// Lists the library, or prints a file of it.
///
/// # Errors
/// A name that is not there, or that several files have.
pub fn run(args: &LibraryArgs) -> Result<(), Failure> {
    let Some(name) = &args.name else {
        return output::print(&if args.json { json(library::entries())? } else { list() });
    };
    let found: Vec<&Entry> = library::entries().filter(|e| e.name() == name).collect();
    let entry = match found.as_slice() {
        [entry] => *entry,
        [] => {
            let location = library::resolve(Path::new(name), &Kind::ALL).map_err(Failure::input)?;
            library::find(&location).ok_or_else(|| {
                Failure::Input(format!("{name}: no file of the library; `contrapposto library` lists them"))
            })?
        }
        several => {
            let each: Vec<String> = several
                .iter()
                .map(|e| format!("`{}` ({})", e.location().display(), e.kind().word()))
                .collect();
            return Err(Failure::Input(format!("`{name}` is the name of several: {}", each.join(", "))));
        }
    };
    output::print(&if args.json { json([entry].into_iter())? } else { entry.text().to_owned() })
}

/// What is in the library, folder by folder.
fn list() -> String {
    let width = library::entries().map(|e| e.name().len()).max().unwrap_or(0);
    let mut out = String::new();
    let mut folder = "";
    for entry in library::entries() {
        // writing to a String cannot fail
        if entry.folder() != folder {
            folder = entry.folder();
            let gap = if out.is_empty() { "" } else { "\n" };
            let _ = writeln!(out, "{gap}{folder}");
        }
        let _ = writeln!(out, "  {:<width$}  {}", entry.name(), entry.about());
    }
    out + "\nA name stands for its file: contrapposto render bow. In a file: library:characters/human.ron.\n\
           contrapposto library NAME prints one.\n"
}

fn json<'a>(entries: impl Iterator<Item = &'a Entry>) -> Result<String, Failure> {
    let value = |e: &Entry| {
        serde_json::json!({
            "name": e.name(),
            "kind": e.kind().word(),
            "folder": e.folder(),
            "location": e.location(),
            "about": e.about(),
        })
    };
    let all: Vec<serde_json::Value> = entries.map(value).collect();
    output::to_json(&all)
}

/// Writes a starter project.
///
/// # Errors
/// A folder that holds files of its names, or that cannot be written to.
pub fn new(args: &NewArgs) -> Result<(), Failure> {
    let written = starter::write(&args.dir)?;
    let files: String = written.iter().map(|f| format!("wrote {}\n", f.display())).collect();
    let here = matches!(args.dir.to_str(), Some("." | "./"));
    let enter = if here { String::new() } else { format!("cd {} && ", args.dir.display()) };
    output::print(&format!("{files}next: {enter}contrapposto render {}\n", starter::SCENE))
}
