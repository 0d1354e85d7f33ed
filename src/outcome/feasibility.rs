//! What a feasible fit adds: how far inside the possible bodies the answer lies, its certificate, and what
//! being possible costs.

use serde::{Deserialize, Serialize};

use crate::outcome::number;

/// Certificate and cost of a feasible fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Feasibility {
    /// Every eigenvalue of `D J D` is at least this, kg; D = diag(1/ℓ, 1/ℓ, 1/ℓ, 1).
    #[serde(with = "number::nullable")]
    pub margin: f64,
    /// ℓ, m.
    #[serde(with = "number::nullable")]
    pub length: f64,
    /// The smallest such eigenvalue, kg.
    #[serde(with = "number::nullable")]
    pub least_eigenvalue: f64,
    /// Duality gap, in units of the cost; none where a chart kept the bodies possible.
    #[serde(with = "number::nullable")]
    pub gap: f64,
    /// Largest imbalance of gradient and multipliers, relative.
    #[serde(with = "number::nullable")]
    pub stationarity: f64,
    /// The constraints change nothing: least squares has a possible member with the same torques.
    pub inactive: bool,
    /// Half the sum of squares of the weighted residual, least squares and feasible.
    #[serde(with = "number::nullable")]
    pub cost_unconstrained: f64,
    /// The same of the feasible answer; never below the former.
    #[serde(with = "number::nullable")]
    pub cost: f64,
    /// The prior on the bodies and its strength.
    pub prior: Option<BodyPrior>,
    /// Errors by joint of least squares with the same weights.
    pub unconstrained: Vec<Unconstrained>,
    /// Bodies at the edge of what is possible.
    pub bodies: Vec<BodyAtBound>,
    /// Parameters and combinations at a limit.
    pub at_limit: Vec<String>,
}

/// A prior on the bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyPrior {
    /// Word of the problem file: `euclidean`, `entropic`, ...
    pub kind: String,
    /// Weight of the prior beside half the squares of the weighted residual.
    #[serde(with = "number::nullable")]
    pub strength: f64,
    /// `held_out`, `noise` or `number`.
    pub chosen_by: String,
    /// Mean squared weighted error of held-out blocks of the training recordings, by strength.
    pub path: Vec<HeldOut>,
}

/// One strength that was tried.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// Weight of the prior that was tried.
    #[serde(with = "number::nullable")]
    pub strength: f64,
    /// Mean square of the weighted residual of the blocks that were held out with it, without unit.
    #[serde(with = "number::nullable")]
    pub error: f64,
}

/// Errors of one joint without constraints, in the unit of its signal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unconstrained {
    /// Name of the joint or channel.
    pub joint: String,
    /// Unit of the errors.
    pub unit: String,
    /// Root mean square of the residual on what was fitted.
    #[serde(with = "number::nullable")]
    pub rmse_train: f64,
    /// The same on recordings that were not fitted; absent where there are none.
    #[serde(with = "number::optional")]
    pub rmse_validation: Option<f64>,
}

/// A body whose constraint holds the answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyAtBound {
    /// Name of the link, or of the load.
    pub body: String,
    /// Smallest eigenvalue of `D J D` that the data ask for when the other bodies alone must be possible, kg.
    #[serde(with = "number::nullable")]
    pub wanted: f64,
    /// Share of the rise of the cost that goes away with this body's constraint alone.
    #[serde(with = "number::nullable")]
    pub share: f64,
    /// What would be impossible about it, in words.
    pub sentence: String,
}
