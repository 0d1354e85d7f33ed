//! What `fit` adds: base parameters, identifiability, physical feasibility and comparisons.

use serde::{Deserialize, Serialize};

use crate::outcome::feasibility::Feasibility;
use crate::outcome::joint::JointFigures;
use crate::outcome::load::Load;
use crate::outcome::machine::Machine;
use crate::outcome::model_comparison::ModelComparison;
use crate::outcome::motors::Motors;
use crate::outcome::number;
use crate::outcome::sharing::Sharing;
use crate::outcome::simulator::Simulator;

/// The part of `fit`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// The combinations that the recordings determine.
    pub base_parameters: Vec<BaseParameter>,
    /// The base parameters of the joint-torque model, where they follow from base reactions.
    #[serde(default)]
    pub joint_torque_parameters: Vec<BaseParameter>,
    /// Number of independent columns of the regressor.
    pub rank: usize,
    /// Condition number of the base regressor with columns of unit norm.
    #[serde(with = "number::nullable")]
    pub condition_number: f64,
    /// Whether a member of the equivalence class of the estimate has every pseudo-inertia positive
    /// definite; absent where it was not examined.
    pub feasible: Option<bool>,
    /// Least eigenvalue over the pseudo-inertias of that member.
    #[serde(with = "number::optional")]
    pub min_pseudo_inertia_eigenvalue: Option<f64>,
    /// Certificate and cost of a feasible fit; absent for the others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feasibility: Option<Feasibility>,
    /// Fits of other models to the same recordings.
    pub comparison: Vec<Comparison>,
    /// This fit and those of the comparison on every joint, then on all together; empty without a comparison.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contests: Vec<ModelComparison>,
    /// Number of columns of the regressor: parameters that are not known, of joints that move.
    #[serde(default)]
    pub unknowns: usize,
    /// The load as a body; absent without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<Load>,
    /// The stages of motor constants from motions at constant speed; absent for other estimators.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motors: Option<Motors>,
    /// Parameters that joints with motors of one type have in common, and whether the recordings refuse that; empty where
    /// the problem names no such joints.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sharing: Vec<Sharing>,
    /// What a later fit can start from.
    #[serde(default)]
    pub posterior: Posterior,
    /// A physically feasible member of the equivalence class, complete, for export.
    #[serde(default)]
    pub realization: Vec<Realized>,
    /// Every value of the possible robot that is nearest by the covariance; empty where the realization is possible.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nearest: Vec<Realized>,
    /// The identified robot, with the bodies of the realization: what exports are made from.
    #[serde(default)]
    pub machine: Option<Machine>,
    /// The same with the values of the nearest possible robot: what simulators are given, which refuse others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub possible_machine: Option<Machine>,
    /// The model in full: what forward simulations are made from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<FittedModel>,
    /// What was done to the recordings before the fit.
    #[serde(default)]
    pub preprocessing: Vec<Preprocessing>,
    /// Anything a reader should know, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
    /// The user's simulator beside the robot; absent without recordings of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulator: Option<Simulator>,
}

/// What the fit knows, as the prior of a later one: combinations of parameters, their values and covariance.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Posterior {
    /// Each with a value.
    pub combinations: Vec<Combination>,
    /// Covariance of the combinations, in their order.
    #[serde(with = "number::matrix")]
    pub covariance: Vec<Vec<f64>>,
}

impl Posterior {
    /// Two sets of combinations whose correlation is not recorded.
    pub fn and(mut self, other: Self) -> Self {
        self.covariance = number::block_diagonal(&self.covariance, &other.covariance);
        self.combinations.extend(other.combinations);
        self
    }
}

/// A linear combination of parameters (of the model's raw ones: first moments, inertia about the origin).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Combination {
    /// Parameters with their coefficients; they are summed.
    pub terms: Vec<Term>,
    /// Its value in the fit, in SI units.
    #[serde(with = "number::nullable")]
    pub value: f64,
}

/// One term of a combination.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Term {
    /// Name of the parameter.
    pub parameter: String,
    /// Its factor in the combination.
    #[serde(with = "number::nullable")]
    pub coefficient: f64,
}

/// A combination of parameters that the motion determines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BaseParameter {
    /// The combination, such as `link2.mass + 0.4*link3.mass`.
    pub expression: String,
    /// SI unit of value and deviation.
    #[serde(default)]
    pub unit: String,
    /// Absent where it was not determined.
    #[serde(with = "number::optional")]
    pub value: Option<f64>,
    /// Standard deviation of the value.
    #[serde(with = "number::optional")]
    pub std_dev: Option<f64>,
    /// 95 % confidence interval, lower and upper end.
    #[serde(with = "number::interval", default)]
    pub ci95: Option<[f64; 2]>,
}

/// The same fit with another list of effects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Name that the problem file gives the model.
    pub name: String,
    /// Identifiers of its effects, of all joints.
    pub effects: Vec<String>,
    /// How well it predicts each joint.
    pub joints: Vec<JointFigures>,
}

/// A fitted model beside the problem that declares it: every value, and the effects that the problem does not have.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct FittedModel {
    /// Effects that a diagnosis found.
    pub added: Vec<AddedEffect>,
    /// Every parameter as the program has it, in SI units: masses, first moments, inertias about the origin, effects.
    pub values: Vec<Realized>,
}

/// An effect that a problem does not declare.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AddedEffect {
    /// Identifier of the effect.
    pub effect: String,
    /// Joints at which it acts.
    pub joints: Vec<String>,
    /// Of a kinematic coupling: the joint whose motor moves the other too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other: Option<String>,
}

/// One value of the feasible realization, or of a model, in SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Realized {
    /// Name of the parameter.
    pub name: String,
    /// In its SI unit.
    #[serde(with = "number::nullable")]
    pub value: f64,
}

/// One line on what was done to a channel: rate, bandwidth, trims.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Preprocessing {
    /// Name of the recording.
    pub recording: String,
    /// Absent where the line is about the recording as a whole.
    pub channel: Option<String>,
    /// What was done, in words.
    pub text: String,
}
