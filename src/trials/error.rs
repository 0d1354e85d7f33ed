//! Why a trial has no answer.

use crate::diagnose::error::DiagnoseError;
use crate::problem::defect::Defect;
use crate::problem_file::ProblemFileError;
use crate::setup::error::SetupError;
use crate::simulate::error::SimulateError;
use thiserror::Error;

/// A trial that cannot be simulated or diagnosed.
#[derive(Debug, Error)]
pub enum TrialError {
    /// The temporary folder of a trial cannot be written.
    #[error("no folder for the recordings of a trial: {0}")]
    Scratch(#[from] std::io::Error),
    /// The problem file that a trial writes is refused.
    #[error(transparent)]
    Problem(#[from] ProblemFileError),
    /// Robot or model of the trial cannot be built.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// Its recordings cannot be simulated.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// It cannot be diagnosed.
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    /// A defect of the program.
    #[error(transparent)]
    Defect(#[from] Defect),
}
