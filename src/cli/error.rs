//! Errors of the command line and their exit codes.

use crate::export::error::ExportError;
use crate::fleet::error::FleetError;
use crate::init::error::InitError;
use crate::outcome::error::OutcomeError;
use crate::problem_file::ProblemFileError;
use crate::setup::error::SetupError;
use crate::verb::ending;
use crate::verb::error::VerbError;
use thiserror::Error;

/// Why a command ends without a result.
#[derive(Debug, Error)]
pub enum CliError {
    #[error(transparent)]
    Verb(#[from] VerbError),
    #[error(transparent)]
    Problem(#[from] ProblemFileError),
    #[error(transparent)]
    Setup(#[from] SetupError),
    #[error(transparent)]
    Fleet(#[from] FleetError),
    #[error(transparent)]
    Init(#[from] InitError),
    #[error(transparent)]
    Outcome(#[from] OutcomeError),
    #[error(transparent)]
    Export(#[from] ExportError),
    #[error("standard output cannot be written: {0}; the results are in their folder")]
    Output(std::io::Error),
    #[error("{0}")]
    WrongUse(String),
}

impl CliError {
    /// What was done could not be printed.
    pub const NOT_PRINTED: u8 = 1;
    /// A repeated run gave another answer.
    pub const ANOTHER_ANSWER: u8 = 1;
    pub const WRONG_USE: u8 = ending::WRONG_USE;
    pub const WRONG_DATA: u8 = ending::WRONG_DATA;
    pub const DEFECT: u8 = ending::DEFECT;
    pub const INTERRUPTED: u8 = ending::INTERRUPTED;

    /// Whether somebody interrupted the run, and no file is at fault.
    pub fn is_interrupt(&self) -> bool {
        matches!(self, Self::Verb(error) if error.is_interrupt())
    }

    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Verb(error) => error.exit_code(),
            Self::Init(error) if error.concerns_data() => Self::WRONG_DATA,
            Self::Setup(error) if error.concerns_data() => Self::WRONG_DATA,
            Self::Output(_) => Self::NOT_PRINTED,
            Self::Fleet(_)
            | Self::Problem(_)
            | Self::Init(_)
            | Self::Setup(_)
            | Self::Outcome(_)
            | Self::Export(_)
            | Self::WrongUse(_) => Self::WRONG_USE,
        }
    }
}
