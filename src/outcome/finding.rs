//! Physics that the declared model lacks, and the other physics that would explain the same.

use crate::outcome::formula::ProposedFormula;
use crate::outcome::number;
use crate::outcome::parameter::Parameter;
use serde::{Deserialize, Serialize};

/// The effect of a finding that no effect of the vocabulary explains.
pub const UNNAMED: &str = "unnamed";

/// Physics that the declared model lacks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Identifier of the effect.
    pub effect: String,
    /// Joints, or channels of a wrench, at which it acts; of an effect of an ordered pair the joint that it acts on, then the
    /// other.
    pub joints: Vec<String>,
    /// Its estimated parameters.
    pub parameters: Vec<Parameter>,
    /// Root mean square of the residual on held-out rows without it, over its channels together, in the unit of the signal.
    #[serde(with = "number::nullable")]
    pub rmse_validation_before: f64,
    /// The same with it.
    #[serde(with = "number::nullable")]
    pub rmse_validation_after: f64,
    /// Share of the squares beyond the noise that it takes from the held-out residual of its channels, 0 to 1.
    #[serde(with = "number::nullable")]
    pub explained_share: f64,
    /// Probability that a model that is no better forecasts the held-out residual as well.
    #[serde(with = "number::nullable")]
    pub p_value: f64,
    /// What it means, for the people who look after the robot.
    pub sentence: String,
    /// Other physics that explains about as much, those that cannot be set aside first.
    pub rivals: Vec<Rival>,
    /// That this, and not a rival, something without a name or nothing, is what is there.
    #[serde(default, with = "number::nullable")]
    pub probability: f64,
    /// That something which the vocabulary has no name for is what is there.
    #[serde(default, with = "number::nullable")]
    pub probability_unnamed: f64,
    /// That there is nothing, and noise made the finding.
    #[serde(default, with = "number::nullable")]
    pub probability_nothing: f64,
    /// The formula that was found for what has no name, or for what an improbable name resembles; absent where none has earned it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub formula: Option<ProposedFormula>,
}

impl Finding {
    /// Whether no effect of the vocabulary explains it.
    pub fn has_no_name(&self) -> bool {
        self.effect == UNNAMED
    }
}

/// Other physics that explains the same misfit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rival {
    /// Identifier of the effect.
    pub effect: String,
    /// Joints at which it would act, in the same order.
    pub joints: Vec<String>,
    /// Share that it takes in the place of the finding, 0 to 1.
    #[serde(with = "number::nullable")]
    pub explained_share: f64,
    /// Whether these recordings tell it from the finding.
    pub separable: bool,
    /// That it is what is there in the place of the finding.
    #[serde(default, with = "number::nullable")]
    pub probability: f64,
    /// Of a rival that is not separable: recordings of fewer than so many times the length do not tell it apart but by
    /// chance, once in twenty times; `None` where no length does, because the two are the same torque.
    #[serde(default, with = "number::optional")]
    pub times_longer: Option<f64>,
}
