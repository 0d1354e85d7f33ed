//! How well the model predicts one joint: errors of prediction minus recording.

use serde::{Deserialize, Serialize};

use crate::outcome::number;

/// Errors of one joint (or channel of a wrench), in the unit of its signal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointFigures {
    /// Name of the joint, or of the channel of a wrench.
    pub joint: String,
    /// Unit of every `rmse`, `mae` and of `noise_rms`.
    pub unit: String,
    /// Root mean square of the residual, `sqrt(mean(r²))`, after preprocessing, over rows at which the joint does not rest, where
    /// static friction is any.
    #[serde(with = "number::nullable")]
    pub rmse_train: f64,
    /// The same on recordings that were not fitted.
    #[serde(with = "number::optional")]
    pub rmse_validation: Option<f64>,
    /// Root mean square over every recorded sample, unfiltered, at rest too.
    #[serde(with = "number::nullable")]
    pub rmse_train_raw: f64,
    /// The same on recordings that were not fitted; absent where there are none.
    #[serde(with = "number::optional")]
    pub rmse_validation_raw: Option<f64>,
    /// Mean of `|r|`, after preprocessing.
    #[serde(with = "number::nullable")]
    pub mae_train: f64,
    /// The same on recordings that were not fitted; absent where there are none.
    #[serde(with = "number::optional")]
    pub mae_validation: Option<f64>,
    /// `‖residual‖ / ‖signal‖`, without unit.
    #[serde(with = "number::nullable")]
    pub relative_train: f64,
    /// The same on recordings that were not fitted; absent where there are none.
    #[serde(with = "number::optional")]
    pub relative_validation: Option<f64>,
    /// Standard deviation of one preprocessed sample by evidence that needs no model.
    #[serde(with = "number::optional")]
    pub noise_rms: Option<f64>,
    /// `mean(r²) / noise_rms²`, held out where there is such a recording; 1 means nothing is left.
    #[serde(with = "number::optional")]
    pub lack_of_fit: Option<f64>,
}
