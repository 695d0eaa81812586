//! What can be wrong with a program: always with its place.

use std::path::PathBuf;

use controllers::ReactiveError;
use edits::EditError;
use rhai::{EvalAltResult, Position};
use thiserror::Error;

/// What is wrong with a program or with what a scene gives it.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ProgramError {
    /// In the user's file.
    #[error("{message}\n  --> {}:{line}:{column}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1, in characters.
        column: usize,
        /// What was found and what is allowed.
        message: String,
    },
    /// A parameter that the scene gives.
    #[error("{message}")]
    Parameter {
        /// Its name.
        name: String,
        /// What was found and what is allowed.
        message: String,
    },
}

impl From<ProgramError> for EditError {
    fn from(e: ProgramError) -> Self {
        let (file, line, column, message) = e.parts();
        Self::Program { file, line, column, message }
    }
}

impl From<ProgramError> for ReactiveError {
    fn from(e: ProgramError) -> Self {
        let (file, line, column, message) = e.parts();
        Self::Program { file, line, column, message }
    }
}

impl ProgramError {
    fn parts(self) -> (PathBuf, usize, usize, String) {
        match self {
            Self::File { file, line, column, message } => (file, line, column, message),
            Self::Parameter { name, message } => (PathBuf::from(name), 1, 1, message),
        }
    }
}

/// What happened while a program ran, in words, and where.
pub(crate) fn words(e: &EvalAltResult) -> (String, Position) {
    let inner = e.unwrap_inner();
    let message = match inner {
        EvalAltResult::ErrorRuntime(value, _) => value.to_string(),
        EvalAltResult::ErrorTooManyOperations(_) => {
            "the program was stopped here: it takes more steps than are allowed (does a loop never end?)"
                .into()
        }
        EvalAltResult::ErrorStackOverflow(_) => {
            format!("functions call each other too deep; allowed: {} levels", crate::limits::CALL_LEVELS)
        }
        other => {
            let text = other.to_string();
            let place = text.rfind(" (line ").unwrap_or(text.len());
            text[..place].to_owned()
        }
    };
    // the innermost place that is known
    let mut place = Position::NONE;
    let mut level = e;
    loop {
        let here = level.position();
        if !here.is_none() {
            place = here;
        }
        match level {
            EvalAltResult::ErrorInFunctionCall(.., deeper, _) => level = deeper,
            _ => return (message, place),
        }
    }
}

/// A fault of what a program gave or asked, at the place that calls.
pub(crate) fn refuse<T>(message: impl Into<String>) -> Result<T, Box<EvalAltResult>> {
    Err(EvalAltResult::ErrorRuntime(message.into().into(), Position::NONE).into())
}
