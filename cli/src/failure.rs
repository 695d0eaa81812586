//! How a command ends when it does not end well: one block of text and an exit code.

use std::fmt::Display;
use std::process::ExitCode;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Something is wrong with a file or an argument: exit code 2.
    #[error("{0}")]
    Input(String),
    /// The input is good, the run or the writing failed: exit code 1.
    #[error("{0}")]
    Run(String),
}

impl Failure {
    /// Of an input.
    pub fn input(e: impl Display) -> Self {
        Self::Input(e.to_string())
    }

    /// Of a run.
    pub fn run(e: impl Display) -> Self {
        Self::Run(e.to_string())
    }

    /// Of an error that states whether the input is at fault.
    pub fn of(e: impl Display, is_input: bool) -> Self {
        if is_input { Self::input(e) } else { Self::run(e) }
    }

    /// The exit code.
    pub fn code(&self) -> ExitCode {
        match self {
            Self::Input(_) => ExitCode::from(2),
            Self::Run(_) => ExitCode::from(1),
        }
    }
}

impl From<takes::TakeError> for Failure {
    fn from(e: takes::TakeError) -> Self {
        Self::input(e)
    }
}

impl From<takes::WriteError> for Failure {
    fn from(e: takes::WriteError) -> Self {
        let input = e.is_input();
        Self::of(e, input)
    }
}

impl From<takes::PerformError> for Failure {
    fn from(e: takes::PerformError) -> Self {
        let input = e.is_input();
        Self::of(e, input)
    }
}

impl From<takes::UnknownEngine> for Failure {
    fn from(e: takes::UnknownEngine) -> Self {
        Self::input(e)
    }
}
