//! Programs of the user: read from their files, given their parameters.
//!
//! In: a [`ProgramSpec`] of a scene. Out: the program as an edit or a reactive property. Faults are in the program's file, or at the
//! parameter in the scene.

use edits::{EditError, Motion};
use programs::{Entry, Program, ProgramError, Reaction};
use scenes::error::read_text;
use scenes::scene::{EditKind, Scene, SceneEdit};
use scenes::{ProgramSpec, SceneError, Source};

/// Reads a program.
///
/// # Errors
/// Files that hold none, parameters that it does not take.
fn read(source: &Source, spec: &ProgramSpec) -> Result<Program, SceneError> {
    let text = read_text(&spec.file)?;
    Program::read(&spec.file, &text, &spec.params).map_err(|e| fault(source, &spec.at, e))
}

/// What is wrong with a program, at its place.
fn fault(source: &Source, at: &str, e: ProgramError) -> SceneError {
    match e {
        ProgramError::File { file, line, column, message } => {
            SceneError { path: file, place: Some((line, column)), message, help: None }
        }
        ProgramError::Parameter { name, message } => {
            source.error(&format!("{at}.params{{{name:?}}}"), message)
        }
    }
}

/// What is wrong with an edit: in the file of its program, or at `at` in the scene.
pub(crate) fn edit_fault(source: &Source, at: &str, e: EditError) -> SceneError {
    match e {
        EditError::Program { file, line, column, message } => {
            SceneError { path: file, place: Some((line, column)), message, help: None }
        }
        other => source.error(at, other.to_string()),
    }
}

/// The program of an edit, if it is one, and what it changes.
///
/// # Errors
/// As [`read`]; programs that change neither elements nor clips, or both.
pub(crate) fn edit_program(
    source: &Source,
    edit: &SceneEdit,
) -> Result<Option<(Program, Entry)>, SceneError> {
    let EditKind::Program(spec) = &edit.kind else { return Ok(None) };
    let program = read(source, spec)?;
    match (program.does(Entry::Elements), program.does(Entry::Clip)) {
        (true, false) => Ok(Some((program, Entry::Elements))),
        (false, true) => Ok(Some((program, Entry::Clip))),
        (elements, _) => {
            let found = if elements { "both" } else { "neither" };
            let message = format!(
                "{}: an edit has either `fn elements(script, params)` or `fn clip(clip, params)`; found {found}",
                spec.file.display()
            );
            Err(source.error(&format!("{}.file", edit.at), message))
        }
    }
}

/// The program of an edit of tracks, if that is what the edit is; `after` a clip edit of this name, if there was one.
///
/// # Errors
/// As [`edit_program`]; where a clip edit has changed what was sampled of the tracks.
pub(crate) fn track_program(
    source: &Source,
    edit: &SceneEdit,
    after: Option<&str>,
) -> Result<Option<Program>, SceneError> {
    let Some((program, Entry::Elements)) = edit_program(source, edit)? else { return Ok(None) };
    tracks_first(source, edit, after)?;
    Ok(Some(program))
}

/// Edits of tracks come before what changes the motion sampled from them; `after`: the name of a clip edit before it.
///
/// # Errors
/// At the edit.
pub(crate) fn tracks_first(source: &Source, edit: &SceneEdit, after: Option<&str>) -> Result<(), SceneError> {
    let Some(clip) = after else { return Ok(()) };
    let why = format!(
        "the edit `{}` changes the script, but `{clip}` before it changes what was sampled from the script; allowed: edits of the script first",
        edit.kind.name()
    );
    Err(source.error(&edit.at, why))
}

/// The program of an edit of clips, if that is what the edit is. One of tracks has been applied, or is refused: without a script there
/// are none.
///
/// # Errors
/// As [`edit_program`].
pub(crate) fn clip_program(
    source: &Source,
    edit: &SceneEdit,
    motion: &Motion,
) -> Result<Option<Program>, SceneError> {
    match edit_program(source, edit)? {
        Some((program, Entry::Clip)) => Ok(Some(program)),
        Some(_) if motion.tracks.is_none() => {
            let why = "this program changes the elements of a script, and the motion has none";
            let help = "a program with `fn clip(clip, params)` edits any motion";
            Err(source.error(&edit.at, why).with_help(help))
        }
        _ => Ok(None),
    }
}

/// The reactive programs of a scene.
///
/// # Errors
/// As [`read`]; programs that do not react.
pub(crate) fn reactions(scene: &Scene) -> Result<Vec<Reaction>, SceneError> {
    let one = |spec: &ProgramSpec| {
        Reaction::new(read(&scene.source, spec)?).map_err(|e| fault(&scene.source, &spec.at, e))
    };
    scene.conditions.programs.iter().map(one).collect()
}
