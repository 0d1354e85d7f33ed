//! Models that were fitted to the same recordings, side by side: errors with intervals, and which of them
//! predicts best, where the recordings can tell.

use serde::{Deserialize, Serialize};

use crate::outcome::number;

/// The models on one joint, or on all of them together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contest {
    /// Absent for all joints together, every one in units of the first model's error.
    pub joint: Option<String>,
    /// Unit of the errors; empty for all joints together.
    pub unit: String,
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
    pub name: String,
    pub rmse_train: ErrorFigure,
    pub rmse_validation: Option<ErrorFigure>,
    pub mae_train: ErrorFigure,
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
    #[serde(with = "number::nullable")]
    pub value: f64,
    #[serde(with = "number::interval")]
    pub ci95: Option<[f64; 2]>,
}
