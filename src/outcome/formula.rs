//! Formulas that a diagnosis proposes for what has no name.

use crate::outcome::number;
use crate::outcome::parameter::Parameter;
use serde::{Deserialize, Serialize};

/// A formula in the variables of the motion for what has no name, as a law of one's own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProposedFormula {
    /// Identifier of the law.
    pub effect: String,
    /// The joint that it acts on.
    pub joint: String,
    /// With numbers, as people read it: `0.41·tau·sin(8·q)`.
    pub expression: String,
    /// Variables of the motion that it has, as formulas of laws name them: `q`, `v[shoulder]`.
    #[serde(default)]
    pub variables: Vec<String>,
    /// Whether it drives its joint over part of the motion, which friction does not.
    #[serde(default)]
    pub drives: bool,
    /// The law as a table `[[law]]` of a problem file.
    pub law: String,
    /// Number of its parameters.
    pub complexity: usize,
    /// Fitted together with those of the model.
    pub parameters: Vec<Parameter>,
    /// RMS error of the joint's signal on recordings that were not fitted, with the formula in the model.
    #[serde(with = "number::nullable")]
    pub rmse_validation: f64,
    /// Share of the joint's excess over the noise that it takes from the model without the finding.
    #[serde(with = "number::nullable")]
    pub explains: f64,
    /// Of the formula against nothing, corrected for the joints whose formulas are tested.
    #[serde(with = "number::nullable")]
    pub p_value: f64,
    /// That it, and not what else takes the misfit or nothing, is what is there.
    #[serde(with = "number::nullable")]
    pub probability: f64,
    /// What else takes the misfit, the smooth correction or names that resemble it; `None` where nothing does.
    #[serde(default)]
    pub against: Option<String>,
    /// Products of factors that its terms were chosen from.
    pub tried: usize,
    /// Other formulas that were fitted, those that explain most first.
    pub others: Vec<OtherFormula>,
}

/// A formula that was fitted and is not proposed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OtherFormula {
    /// With numbers, as people read it.
    pub expression: String,
    /// Number of its parameters.
    pub complexity: usize,
    /// Share of the joint's excess over the noise that it takes.
    #[serde(with = "number::nullable")]
    pub explains: f64,
}
