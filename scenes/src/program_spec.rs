//! A program of the user, as scenes name it: a file and what it is given. Nothing is opened here.

use std::collections::BTreeMap;
use std::path::PathBuf;

use edits::Argument;

/// A program of the user as a scene names it.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramSpec {
    /// Its file.
    pub file: PathBuf,
    /// What the scene gives it, by name.
    pub params: BTreeMap<String, Argument>,
    /// Path of the program in the scene, for errors.
    pub at: String,
}
