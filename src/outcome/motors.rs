//! Motor constants from motions at constant speed, speed by speed.

use serde::{Deserialize, Serialize};

use crate::outcome::number;

/// What the fit of motor constants adds.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Motors {
    /// Joint by joint.
    pub joints: Vec<MotorJoint>,
    /// Joints whose motors the problem says are of one type.
    pub same_type: Vec<SameType>,
}

/// The stages for one joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MotorJoint {
    /// Name of the joint.
    pub joint: String,
    /// Steady parts that were found.
    pub parts: usize,
    /// The slowest first.
    pub speeds: Vec<MotorSpeed>,
    /// Friction that grows with the load, where the motion tells; absent from the constants above.
    pub load_dependence: Option<MotorLoad>,
    /// Why the torque constant is not determined, and what to do; absent where it is.
    pub advice: Option<String>,
}

/// The first stage at one speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MotorSpeed {
    /// rad/s (m/s).
    #[serde(with = "number::nullable")]
    pub speed: f64,
    /// Rows of the steady parts at that speed.
    pub samples: usize,
    /// N·m/A, by the linear solution; absent where the load does not vary.
    #[serde(with = "number::optional")]
    pub torque_constant: Option<f64>,
    /// By the linear solution, N·m/A.
    #[serde(with = "number::optional")]
    pub torque_constant_std_dev: Option<f64>,
    /// N·m/A, by the simplex of Nelder and Mead.
    #[serde(with = "number::optional")]
    pub torque_constant_simplex: Option<f64>,
    /// N·m, with the torque constant of the joint.
    #[serde(with = "number::optional")]
    pub friction: Option<f64>,
    /// The same by the simplex, N·m.
    #[serde(with = "number::optional")]
    pub friction_simplex: Option<f64>,
    /// Torque constant of each steady part by itself, N·m/A.
    #[serde(with = "number::list")]
    pub of_parts: Vec<f64>,
}

/// mu in `mu·|τ|·sign(v)`, and the torque constant with it in the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MotorLoad {
    /// Without unit.
    #[serde(with = "number::nullable")]
    pub mu: f64,
    /// Without unit.
    #[serde(with = "number::nullable")]
    pub mu_std_dev: f64,
    /// N·m/A.
    #[serde(with = "number::nullable")]
    pub torque_constant: f64,
    /// N·m/A.
    #[serde(with = "number::nullable")]
    pub torque_constant_std_dev: f64,
}

/// Joints with motors of one type, compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SameType {
    /// The joints whose constants are determined.
    pub joints: Vec<String>,
    /// Mean of their torque constants weighted by inverse variances, N·m/A.
    #[serde(with = "number::nullable")]
    pub mean: f64,
    /// Sum of squared distances from the mean, each over its variance.
    #[serde(with = "number::nullable")]
    pub chi_squared: f64,
    /// Of equal constants.
    #[serde(with = "number::nullable")]
    pub p_value: f64,
}
