//! What was estimated: parameters, errors by joint, covariance, and how the solver ended.

use serde::{Deserialize, Serialize};

use crate::outcome::joint::JointFigures;
use crate::outcome::number;
use crate::outcome::parameter::Parameter;

/// The estimate of a run; empty for a verb that estimates nothing.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Estimated, known and undetermined parameters in the order of the model.
    pub parameters: Vec<Parameter>,
    /// Errors of every joint, or channel of a wrench.
    pub joints: Vec<JointFigures>,
    /// Covariance of what was estimated.
    pub covariance: Covariance,
    /// Absent where nothing was solved.
    pub solver: Option<Solver>,
}

impl Estimate {
    /// The parameter with this name, `<joint>.<effect>.<parameter>` or `<link>.<quantity>`.
    pub fn find(&self, name: &str) -> Option<&Parameter> {
        self.parameters
            .iter()
            .find(|parameter| parameter.is_called(name))
    }
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
    /// Name of the method.
    pub name: String,
    /// Why it stopped, in snake_case: `cost_tolerance`, `iteration_limit`, `interrupted`, ...
    pub stop: String,
    /// The point is a solution within the solver's tolerances. Of a design that was cut off, or whose motion was made smaller to keep
    /// its limits, it is false, though the motion can be used: the exit code is 0 and `stop` is `iteration_limit` or `time_limit`.
    pub converged: bool,
    /// Steps, accepted or not; 1 of a direct solution.
    pub iterations: u64,
    /// Evaluations of residual or cost, those with derivatives included.
    pub evaluations: u64,
    /// Value of the objective at the end.
    #[serde(with = "number::nullable")]
    pub cost: f64,
}
