//! The laws of programs, one file for each subject.

#[path = "../../../edits/tests/laws/body.rs"]
#[allow(dead_code)]
mod body;

mod clips;
mod elements;
mod limits;
mod reactions;

use std::collections::BTreeMap;
use std::path::Path;

use edits::Argument;
use programs::{Program, ProgramError};

/// A program of a file `mine.rhai`, without arguments.
fn program(text: &str) -> Program {
    read(text, &[]).unwrap()
}

fn read(text: &str, arguments: &[(&str, Argument)]) -> Result<Program, ProgramError> {
    let arguments: BTreeMap<String, Argument> =
        arguments.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
    Program::read(Path::new("mine.rhai"), text, &arguments)
}

/// What is wrong with a program, as the command line says it.
fn refused(text: &str) -> String {
    read(text, &[]).unwrap_err().to_string()
}
