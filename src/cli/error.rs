//! Errors of the command line and their exit codes.

use crate::estimate::task::FitError;
use crate::fault::Fault;
use crate::outcome::error::OutcomeError;
use crate::problem_file::ProblemFileError;
use crate::setup::error::SetupError;
use thiserror::Error;

/// Why a command ends without a result.
#[derive(Debug, Error)]
pub enum CliError {
    #[error(transparent)]
    Problem(#[from] ProblemFileError),
    #[error(transparent)]
    Setup(#[from] SetupError),
    #[error(transparent)]
    Fit(#[from] FitError),
    #[error(transparent)]
    Outcome(#[from] OutcomeError),
    #[error("{0}")]
    WrongUse(String),
    #[error("interrupted before there was anything to write")]
    Interrupted,
}

impl CliError {
    /// The command line or the problem file is wrong, or the results folder cannot be written.
    pub const WRONG_USE: u8 = 2;
    /// A recording or robot file is wrong.
    pub const WRONG_DATA: u8 = 3;
    /// No solution.
    pub const NO_SOLUTION: u8 = 4;
    pub const INTERRUPTED: u8 = 130;

    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Setup(error) | Self::Fit(FitError::Setup(error)) => of_setup(error),
            Self::Fit(FitError::Estimate { .. }) => Self::NO_SOLUTION,
            Self::Problem(_) | Self::Outcome(_) | Self::WrongUse(_) => Self::WRONG_USE,
            Self::Interrupted => Self::INTERRUPTED,
        }
    }

    /// Stable identifier of the fault, where it has one.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Problem(error) => error.describe().code,
            Self::Setup(error) | Self::Fit(FitError::Setup(error)) => error.describe().code,
            Self::Outcome(error) => error.describe().code,
            Self::Fit(FitError::Estimate { .. }) => "no-solution",
            Self::WrongUse(_) => "wrong-use",
            Self::Interrupted => "interrupted",
        }
    }
}

fn of_setup(error: &SetupError) -> u8 {
    if error.concerns_data() {
        CliError::WRONG_DATA
    } else {
        CliError::WRONG_USE
    }
}
