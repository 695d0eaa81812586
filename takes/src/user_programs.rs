//! Programs of the user: read from their files, given their parameters.
//!
//! In: a [`ProgramSpec`] of a scene. Out: the program as an edit or a reactive property. Faults are in the program's file, or at the
//! parameter in the scene.

use edits::EditError;
use programs::{Entry, Program, ProgramError, Reaction};
use scenes::error::read_text;
use scenes::scene::{EditKind, Scene, SceneEdit, may_edit_tracks};
use scenes::{ProgramSpec, SceneError};

/// Reads a program.
///
/// # Errors
/// Files that hold none, parameters that it does not take.
fn read(scene: &Scene, spec: &ProgramSpec) -> Result<Program, SceneError> {
    let text = read_text(&spec.file)?;
    Program::read(&spec.file, &text, &spec.params).map_err(|e| fault(scene, &spec.at, e))
}

/// What is wrong with a program, at its place.
fn fault(scene: &Scene, at: &str, e: ProgramError) -> SceneError {
    match e {
        ProgramError::File { file, line, column, message } => {
            SceneError { path: file, place: Some((line, column)), message, help: None }
        }
        ProgramError::Parameter { name, message } => {
            scene.source.error(&format!("{at}.params{{{name:?}}}"), message)
        }
    }
}

/// What is wrong with an edit: in the file of its program, or at `at` in the scene.
pub(crate) fn edit_fault(scene: &Scene, at: &str, e: EditError) -> SceneError {
    match e {
        EditError::Program { file, line, column, message } => {
            SceneError { path: file, place: Some((line, column)), message, help: None }
        }
        other => scene.source.error(at, other.to_string()),
    }
}

/// The program of an edit, if it is one, and what it changes.
///
/// # Errors
/// As [`read`]; programs that change neither elements nor clips, or both.
pub(crate) fn edit_program(scene: &Scene, edit: &SceneEdit) -> Result<Option<(Program, Entry)>, SceneError> {
    let EditKind::Program(spec) = &edit.kind else { return Ok(None) };
    let program = read(scene, spec)?;
    match (program.does(Entry::Elements), program.does(Entry::Clip)) {
        (true, false) => Ok(Some((program, Entry::Elements))),
        (false, true) => Ok(Some((program, Entry::Clip))),
        (elements, _) => {
            let found = if elements { "both" } else { "neither" };
            let message = format!(
                "{}: an edit has either `fn elements(script, params)` or `fn clip(clip, params)`; found {found}",
                spec.file.display()
            );
            Err(scene.source.error(&format!("{}.file", edit.at), message))
        }
    }
}

/// The program of an edit of tracks, if that is what the edit is; `after` a clip edit of this name, if there was one.
///
/// # Errors
/// As [`edit_program`]; where tracks cannot be edited.
pub(crate) fn track_program(
    scene: &Scene,
    edit: &SceneEdit,
    after: Option<&str>,
) -> Result<Option<Program>, SceneError> {
    let Some((program, Entry::Elements)) = edit_program(scene, edit)? else { return Ok(None) };
    may_edit_tracks(&scene.source, edit, after, &scene.motion)?;
    Ok(Some(program))
}

/// The program of an edit of clips, if that is what the edit is. One of tracks has been applied, or is refused: without a script there
/// are none.
///
/// # Errors
/// As [`track_program`].
pub(crate) fn clip_program(scene: &Scene, edit: &SceneEdit) -> Result<Option<Program>, SceneError> {
    match edit_program(scene, edit)? {
        Some((program, Entry::Clip)) => Ok(Some(program)),
        Some(_) if scene.motion.script().is_none() => track_program(scene, edit, None),
        _ => Ok(None),
    }
}

/// The reactive programs of a scene.
///
/// # Errors
/// As [`read`]; programs that do not react.
pub(crate) fn reactions(scene: &Scene) -> Result<Vec<Reaction>, SceneError> {
    let one = |spec: &ProgramSpec| Reaction::new(read(scene, spec)?).map_err(|e| fault(scene, &spec.at, e));
    scene.conditions.programs.iter().map(one).collect()
}
