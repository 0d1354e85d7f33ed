//! Errors of the command line and their exit codes.

use crate::estimate::task::FitError;
use crate::outcome::error::OutcomeError;
use crate::problem_file::ProblemFileError;
use crate::simulate::error::SimulateError;
use thiserror::Error;

/// Why a command ends without a result.
#[derive(Debug, Error)]
pub enum CliError {
    #[error(transparent)]
    Problem(#[from] ProblemFileError),
    #[error(transparent)]
    Fit(#[from] FitError),
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    #[error(transparent)]
    Outcome(#[from] OutcomeError),
    #[error("{0}")]
    WrongUse(String),
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
            Self::Fit(FitError::Setup(error)) => of_files(error.concerns_data()),
            Self::Fit(FitError::Estimate { .. }) => Self::NO_SOLUTION,
            Self::Simulate(error) if error.is_interrupt() => Self::INTERRUPTED,
            Self::Simulate(error) => of_files(error.concerns_data()),
            Self::Problem(_) | Self::Outcome(_) | Self::WrongUse(_) => Self::WRONG_USE,
        }
    }
}

/// Whether a recording or robot file is at fault, or the problem file.
fn of_files(concerns_data: bool) -> u8 {
    if concerns_data {
        CliError::WRONG_DATA
    } else {
        CliError::WRONG_USE
    }
}
