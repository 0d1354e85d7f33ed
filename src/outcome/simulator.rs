//! What the recordings of a simulator say beside those of the robot: what agrees, what differs, and what is in one alone.

use serde::{Deserialize, Serialize};

use crate::outcome::finding::Finding;
use crate::outcome::joint::JointFigures;
use crate::outcome::number;
use crate::outcome::parameter::Parameter;

/// A simulator beside the robot, both identified from the model that the problem declares.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Simulator {
    /// In plain words.
    pub summary: String,
    /// What the simulator's own recordings say of it.
    pub parameters: Vec<Parameter>,
    /// What its model leaves of them: a simulator without noise leaves the error of its numbers.
    pub joints: Vec<JointFigures>,
    /// Physics in the simulator that the problem does not declare.
    pub findings: Vec<Finding>,
    /// In both, and not the same; what makes most of the signal first.
    pub differences: Vec<Contrast>,
    /// Physics that the robot has and the simulator does not.
    pub only_robot: Vec<OneSided>,
    /// Physics that the simulator has and the robot does not.
    pub only_simulator: Vec<OneSided>,
    /// In both, and not told apart, or too close to matter.
    pub agree: Vec<Contrast>,
    /// Quantities that were compared: p-values and intervals are corrected for so many.
    pub compared: usize,
    /// Chance of calling anything different where nothing is.
    #[serde(with = "number::nullable")]
    pub level: f64,
    /// Anything a reader should know, one sentence each.
    pub notes: Vec<String>,
}

/// A parameter, or a combination that the recordings determine, in the simulator and on the robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contrast {
    /// Name of the parameter, or the combination as an expression.
    pub parameter: String,
    /// SI unit of values, deviations and interval.
    pub unit: String,
    /// Value in the simulator.
    #[serde(with = "number::nullable")]
    pub simulated: f64,
    /// Its standard deviation; zero where it is known.
    #[serde(with = "number::nullable")]
    pub simulated_std_dev: f64,
    /// Value on the robot.
    #[serde(with = "number::nullable")]
    pub robot: f64,
    /// Its standard deviation; zero where it is known.
    #[serde(with = "number::nullable")]
    pub robot_std_dev: f64,
    /// Robot minus simulator.
    #[serde(with = "number::nullable")]
    pub difference: f64,
    /// Of the difference; all intervals of a result hold the truth together with 95 %.
    #[serde(with = "number::interval")]
    pub ci95: Option<[f64; 2]>,
    /// Corrected for the number of quantities compared.
    #[serde(with = "number::nullable")]
    pub p_value: f64,
    /// What the difference makes of the robot's signal, as share of its root mean square, where it makes most.
    #[serde(with = "number::nullable")]
    pub share_of_signal: f64,
    /// The same in words.
    pub sentence: String,
}

/// Physics that one of the two has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OneSided {
    /// Identifier of the effect.
    pub effect: String,
    /// Joints at which it acts.
    pub joints: Vec<String>,
    /// Of the one that has it.
    pub parameters: Vec<Parameter>,
    /// The other's value of its size, where the other's model could have had it.
    pub contrasts: Vec<Contrast>,
    /// What it means, in words.
    pub sentence: String,
}
