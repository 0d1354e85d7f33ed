//! Models that were fitted to the same recordings, side by side: errors with intervals, and which of them
//! predicts best, where the recordings can tell.

use serde::{Deserialize, Serialize};

use crate::outcome::number;

/// The models on one joint, or on all of them together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelComparison {
    /// Absent for all joints together, every one in units of the first model's error.
    pub joint: Option<String>,
    /// Unit of the errors; empty for all joints together.
    pub unit: String,
    /// The fit itself, then the models that it is compared with.
    pub models: Vec<ModelErrors>,
    /// The model that predicts better than every other by more than chance and by more than 1 %, on
    /// recordings that were held out where there are any; absent where none does.
    pub best: Option<String>,
    /// Where none does: the model with the least error and those that the recordings cannot tell from it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub level: Vec<String>,
    /// The same in words.
    pub sentence: String,
}

/// Errors of one model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelErrors {
    /// Name of the model.
    pub name: String,
    /// Root mean square of the residual on what was fitted.
    pub rmse_train: ErrorFigure,
    /// The same on recordings that were not fitted; absent where there are none.
    pub rmse_validation: Option<ErrorFigure>,
    /// Mean size of the residual on what was fitted.
    pub mae_train: ErrorFigure,
    /// The same on recordings that were not fitted.
    pub mae_validation: Option<ErrorFigure>,
}

impl ModelErrors {
    /// The error by which models are ranked.
    pub fn judged(&self) -> ErrorFigure {
        self.rmse_validation.unwrap_or(self.rmse_train)
    }
}

/// An error, and where that of another recording of the same length and kind is expected.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorFigure {
    /// In the unit of the comparison.
    #[serde(with = "number::nullable")]
    pub value: f64,
    /// Absent where the residual has too few independent blocks to tell.
    #[serde(with = "number::interval")]
    pub ci95: Option<[f64; 2]>,
}
