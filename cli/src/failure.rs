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

/// Errors that state whether the input is at fault.
macro_rules! at_fault {
    ($($error:ty),+) => {$(
        impl From<$error> for Failure {
            fn from(e: $error) -> Self {
                if e.is_input() { Self::input(e) } else { Self::run(e) }
            }
        }
    )+};
}

at_fault!(
    takes::WriteError,
    takes::PerformError,
    takes::results::folder::FolderError,
    takes::results::analysis_write::AnalysisWriteError,
    takes::starter::StarterError,
    studies::propagate::PropagateError,
    studies::push::PushError,
    studies::tune::SessionError,
    studies::tune::TuneError,
    studies::tune::SweepError,
    crosscheck::CrossCheckError
);

/// All faults of a request are of its input: nothing is random, and nothing outside is asked.
impl From<takes::retargeting::RetargetingError> for Failure {
    fn from(e: takes::retargeting::RetargetingError) -> Self {
        Self::input(e)
    }
}

impl From<takes::styles::StylesError> for Failure {
    fn from(e: takes::styles::StylesError) -> Self {
        Self::input(e)
    }
}

impl From<takes::UnknownEngine> for Failure {
    fn from(e: takes::UnknownEngine) -> Self {
        Self::input(e)
    }
}
