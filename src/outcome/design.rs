//! What `design` adds: the motion, what it is worth, how close it comes to every limit, and what it shows.

use serde::{Deserialize, Serialize};

use crate::outcome::number;
use crate::outcome::skeleton::Skeleton;

/// The part of `design`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Design {
    /// `fourier` or `constant_velocity`.
    pub kind: String,
    /// Word of the criterion.
    pub criterion: String,
    /// What the value of the criterion is, and of which matrix.
    pub criterion_meaning: String,
    #[serde(with = "number::nullable")]
    pub criterion_value: f64,
    /// Condition number of the observation matrix under the scaling of the design.
    #[serde(with = "number::nullable")]
    pub condition_number: f64,
    /// log det of the information matrix under the scaling of the design.
    #[serde(with = "number::nullable")]
    pub log_det: f64,
    /// What the scaling is, in words.
    pub scaling: String,
    /// Columns of the observation matrix: the base parameters.
    pub columns: Vec<String>,
    pub coefficients: Coefficients,
    pub expected_std_dev: Vec<ExpectedDeviation>,
    /// The motion that `design.reference` names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// The robot and the walls around it, for the picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skeleton: Option<Skeleton>,
    /// Ways of points of the robot.
    #[serde(default)]
    pub ways: Vec<Way>,
    pub worst_margins: Vec<WorstMargin>,
    /// How the margins were checked.
    pub verification: String,
    /// What the motion shows of every effect that the problem lists.
    pub coverage: Vec<Coverage>,
    /// Best value against time.
    pub convergence: Vec<Progress>,
    /// Starts of the search.
    pub starts: u64,
    /// Names of the files in the results folder.
    pub files: Vec<String>,
    #[serde(default)]
    pub notes: Vec<String>,
}

/// The Fourier coefficients of all trajectories.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Coefficients {
    /// The series in plain text.
    pub formula: String,
    /// s.
    #[serde(with = "number::nullable")]
    pub period: f64,
    pub harmonics: usize,
    pub trajectories: Vec<Vec<JointCoefficients>>,
}

/// The series of one joint in both usual forms.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct JointCoefficients {
    pub joint: String,
    pub unit: String,
    pub q0: f64,
    /// Amplitudes of velocity: `q̇ = Σ a_l cos(lωt) + b_l sin(lωt)`.
    pub a: Vec<f64>,
    pub b: Vec<f64>,
    /// Amplitudes of position: `q = q0 + Σ sine_l sin(lωt) + cosine_l cos(lωt)`.
    pub sine: Vec<f64>,
    pub cosine: Vec<f64>,
    /// Limits of the position, and of the size of velocity and acceleration.
    pub limits: [f64; 4],
}

/// Standard deviation of a parameter that a recording of one period would give.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExpectedDeviation {
    pub name: String,
    pub unit: String,
    #[serde(with = "number::optional")]
    pub std_dev: Option<f64>,
    /// The value that the prediction was made with.
    #[serde(with = "number::nullable", default)]
    pub value: f64,
}

/// A motion that a design is compared with, at as many samples and with the same noise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    pub file: String,
    #[serde(with = "number::nullable")]
    pub criterion_value: f64,
    pub expected_std_dev: Vec<ExpectedDeviation>,
    pub worst_margins: Vec<WorstMargin>,
}

/// Where a point of the robot goes, over the trajectories one after the other.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Way {
    /// Name of the link or frame.
    pub frame: String,
    /// m, in the base frame.
    pub points: Vec<[f64; 3]>,
}

/// The least margin of one limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorstMargin {
    pub constraint: String,
    /// Absent for limits that are not one joint's.
    pub joint: Option<String>,
    /// Trajectory, from 1.
    pub trajectory: usize,
    /// s.
    pub time: f64,
    /// Distance to the limit in its unit; negative beyond it.
    #[serde(with = "number::nullable")]
    pub margin: f64,
    /// The same as a share of the limit.
    #[serde(with = "number::nullable")]
    pub relative: f64,
    #[serde(with = "number::nullable")]
    pub limit: f64,
    pub unit: String,
}

/// What a motion shows of an effect on a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    pub joint: String,
    pub effect: String,
    pub shown: bool,
    /// In words, with the figures.
    pub sentence: String,
}

/// The best value at one time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    pub elapsed_s: f64,
    pub starts: u64,
    #[serde(with = "number::nullable")]
    pub value: f64,
}
