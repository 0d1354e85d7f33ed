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
    #[error("no folder for the recordings of a trial: {0}")]
    Scratch(#[from] std::io::Error),
    #[error(transparent)]
    Problem(#[from] ProblemFileError),
    #[error(transparent)]
    Setup(#[from] SetupError),
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    #[error(transparent)]
    Defect(#[from] Defect),
}
