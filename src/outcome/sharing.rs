//! Parameters that joints with motors of one type have in common, and whether the recordings refuse that.

use serde::{Deserialize, Serialize};

use crate::outcome::number;

/// An effect whose parameters several joints have in common.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sharing {
    /// Identifier of the effect.
    pub effect: String,
    /// The joints that have it in common.
    pub joints: Vec<String>,
    /// Whether the model is one with common parameters, or the recordings were only asked.
    pub in_model: bool,
    /// The parameters: common, and of every joint.
    pub parameters: Vec<SharedParameter>,
    /// (R θ)ᵀ (R C Rᵀ)⁻¹ (R θ) of the differences R θ between joints; absent where the recordings determine none.
    #[serde(with = "number::optional", default)]
    pub statistic: Option<f64>,
    /// Number of differences.
    pub degrees_of_freedom: usize,
    /// Chance of differences as large where there are none, of this test alone; absent as the statistic is.
    #[serde(with = "number::optional", default)]
    pub p_value: Option<f64>,
    /// Whether the recordings refuse that the joints have the parameters in common.
    pub refused: bool,
    /// The same in words.
    pub sentence: String,
}

/// A parameter that joints may have in common.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SharedParameter {
    /// `<effect>.<parameter>`.
    pub name: String,
    /// SI unit of all values.
    pub unit: String,
    /// The value that is common to the joints; absent where it was not estimated because the recordings refuse it.
    #[serde(with = "number::optional")]
    pub value: Option<f64>,
    /// Standard deviation of the common value.
    #[serde(with = "number::optional")]
    pub std_dev: Option<f64>,
    /// 95 % confidence interval of the common value, lower and upper end.
    #[serde(with = "number::interval")]
    pub ci95: Option<[f64; 2]>,
    /// What every joint says by itself.
    pub separate: Vec<SeparateValue>,
}

/// A parameter of one joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SeparateValue {
    /// Name of the joint.
    pub joint: String,
    /// Estimate where every joint has its own; absent where undetermined.
    #[serde(with = "number::optional")]
    pub value: Option<f64>,
    /// Its standard deviation; absent on a bound too.
    #[serde(with = "number::optional")]
    pub std_dev: Option<f64>,
}
