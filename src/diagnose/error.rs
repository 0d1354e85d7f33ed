//! Why a diagnosis gives no result.

use crate::estimate::error::EstimateError;
use crate::problem::defect::Defect;
use crate::setup::error::SetupError;
use thiserror::Error;

/// A diagnosis that cannot start or finish.
#[derive(Debug, Error)]
pub enum DiagnoseError {
    /// The problem, its robot or its recordings.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The declared model cannot be fitted.
    #[error(transparent)]
    Fit(Box<EstimateError>),
    /// Nothing was found before it.
    #[error(transparent)]
    Defect(#[from] Defect),
}

impl From<EstimateError> for DiagnoseError {
    fn from(error: EstimateError) -> Self {
        Self::Fit(Box::new(error))
    }
}
