//! What was estimated: parameters, errors by joint, covariance, and how the solver ended.

use serde::{Deserialize, Serialize};

use crate::outcome::joint::JointFigures;
use crate::outcome::number;
use crate::outcome::parameter::Parameter;

/// The estimate of a run; empty for a verb that estimates nothing.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    pub parameters: Vec<Parameter>,
    pub joints: Vec<JointFigures>,
    pub covariance: Covariance,
    /// Absent where nothing was solved.
    pub solver: Option<Solver>,
}

/// Covariance of the estimated parameters, symmetric; entry units are the products of the units.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Covariance {
    /// Names of the rows and columns.
    pub parameters: Vec<String>,
    /// By rows.
    #[serde(with = "number::matrix")]
    pub matrix: Vec<Vec<f64>>,
}

impl Covariance {
    /// Two sets of parameters whose correlation is not recorded.
    pub fn and(mut self, other: Self) -> Self {
        self.matrix = number::block_diagonal(&self.matrix, &other.matrix);
        self.parameters.extend(other.parameters);
        self
    }
}

/// How the solver ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Solver {
    pub name: String,
    /// Why it stopped, in snake_case: `cost_tolerance`, `iteration_limit`, `interrupted`, ...
    pub stop: String,
    pub converged: bool,
    pub iterations: u64,
    pub evaluations: u64,
    /// Value of the objective at the end.
    #[serde(with = "number::nullable")]
    pub cost: f64,
}
