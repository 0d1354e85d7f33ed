//! Errors of the command line and their exit codes.

use crate::design::error::DesignError;
use crate::diagnose::error::DiagnoseError;
use crate::estimate::task::FitError;
use crate::export::error::ExportError;
use crate::fleet::error::FleetError;
use crate::init::error::InitError;
use crate::motors::error::MotorsError;
use crate::outcome::check::Finding;
use crate::outcome::error::OutcomeError;
use crate::problem_file::ProblemFileError;
use crate::report::text;
use crate::rollout::error::RolloutError;
use crate::simulate::error::SimulateError;
use thiserror::Error;

/// Why a command ends without a result.
#[derive(Debug, Error)]
pub enum CliError {
    #[error(transparent)]
    Problem(#[from] ProblemFileError),
    #[error(transparent)]
    Design(#[from] DesignError),
    #[error(transparent)]
    Fit(#[from] FitError),
    #[error(transparent)]
    Motors(#[from] MotorsError),
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    #[error(transparent)]
    Rollout(#[from] RolloutError),
    #[error(transparent)]
    Fleet(#[from] FleetError),
    #[error(transparent)]
    Init(#[from] InitError),
    #[error(transparent)]
    Outcome(#[from] OutcomeError),
    #[error(transparent)]
    Export(#[from] ExportError),
    /// Mistakes in the inputs with which every figure would be meaningless.
    #[error("{}\n--force goes on all the same", in_lines(.0))]
    Mistakes(Vec<Finding>),
    /// Files that have changed since a result was made from them, one line each.
    #[error("{}\nrestore them, or run the problem anew", .0.join("\n"))]
    ChangedInputs(Vec<String>),
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
    /// The command line or the problem file is wrong, or the results folder cannot be written.
    pub const WRONG_USE: u8 = 2;
    /// A recording or robot file is wrong.
    pub const WRONG_DATA: u8 = 3;
    /// No solution.
    pub const NO_SOLUTION: u8 = 4;
    /// A defect of exid.
    pub const DEFECT: u8 = 70;
    pub const INTERRUPTED: u8 = 130;

    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Design(DesignError::Solve(_)) => Self::NO_SOLUTION,
            Self::Design(error) => of_files(error.concerns_data()),
            Self::Fit(FitError::Setup(error)) if error.is_interrupt() => Self::INTERRUPTED,
            Self::Diagnose(DiagnoseError::Setup(error)) if error.is_interrupt() => {
                Self::INTERRUPTED
            }
            Self::Fit(FitError::Setup(error)) => of_files(error.concerns_data()),
            Self::Fit(FitError::Estimate { .. }) => Self::NO_SOLUTION,
            Self::Motors(error) => of_files(error.concerns_data()),
            Self::Diagnose(DiagnoseError::Setup(error)) => of_files(error.concerns_data()),
            Self::Diagnose(DiagnoseError::Fit(_)) => Self::NO_SOLUTION,
            Self::Diagnose(DiagnoseError::Defect(_)) | Self::Fit(FitError::Defect(_)) => {
                Self::DEFECT
            }
            Self::Simulate(error) if error.is_interrupt() => Self::INTERRUPTED,
            Self::Simulate(error) => of_files(error.concerns_data()),
            Self::Rollout(error) if error.is_interrupt() => Self::INTERRUPTED,
            Self::Rollout(error) => of_files(error.concerns_data()),
            Self::Init(error) => of_files(error.concerns_data()),
            Self::Mistakes(_) | Self::ChangedInputs(_) => Self::WRONG_DATA,
            Self::Output(_) => Self::NOT_PRINTED,
            Self::Fleet(_)
            | Self::Problem(_)
            | Self::Outcome(_)
            | Self::Export(_)
            | Self::WrongUse(_) => Self::WRONG_USE,
        }
    }
}

/// Mistakes with their remedies; the word that says what they are stands before them.
fn in_lines(mistakes: &[Finding]) -> String {
    let lines = mistakes.iter().flat_map(text::finding_lines);
    let lines: Vec<String> = lines.collect();
    let text = lines.join("\n");
    text.strip_prefix("error: ").unwrap_or(&text).to_string()
}

/// Whether a recording or robot file is at fault, or the problem file.
fn of_files(concerns_data: bool) -> u8 {
    if concerns_data {
        CliError::WRONG_DATA
    } else {
        CliError::WRONG_USE
    }
}
