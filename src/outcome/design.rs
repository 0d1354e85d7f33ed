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
    /// Its value at the motion.
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
    /// The motion as Fourier series; empty for a plan of constant velocities.
    pub coefficients: Coefficients,
    /// Deviations to expect of the parameters that count, where the noise is stated.
    pub expected_std_dev: Vec<ExpectedDeviation>,
    /// The motion that `design.reference` names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// The robot and the walls around it, for the picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skeleton: Option<Skeleton>,
    /// Positions of joints without a motor, which closed loops move, for the picture.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub carried: Vec<CarriedJoint>,
    /// Ways of points of the robot.
    #[serde(default)]
    pub ways: Vec<Way>,
    /// The least margin of every limit, over all times and not only at samples.
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
    /// Anything a reader should know, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// A joint that closed loops move.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CarriedJoint {
    /// Name of the joint.
    pub joint: String,
    /// By trajectory: positions at equal steps of the period, from its start, rad (m).
    pub positions: Vec<Vec<f64>>,
}

/// The Fourier coefficients of all trajectories.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Coefficients {
    /// The series in plain text.
    pub formula: String,
    /// s.
    #[serde(with = "number::nullable")]
    pub period: f64,
    /// Terms of the longest series.
    pub harmonics: usize,
    /// By trajectory, then by joint.
    pub trajectories: Vec<Vec<JointCoefficients>>,
}

/// The series of one joint in both usual forms.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct JointCoefficients {
    /// Name of the joint.
    pub joint: String,
    /// Unit of its position: rad or m.
    pub unit: String,
    /// Mean position.
    pub q0: f64,
    /// Amplitudes of velocity: `q̇ = Σ a_l cos(lωt) + b_l sin(lωt)`.
    pub a: Vec<f64>,
    /// The b_l of the same sum, in the unit of velocity.
    pub b: Vec<f64>,
    /// Amplitudes of position: `q = q0 + Σ sine_l sin(lωt) + cosine_l cos(lωt)`.
    pub sine: Vec<f64>,
    /// The cosine_l of the same sum, in the unit of position.
    pub cosine: Vec<f64>,
    /// Limits of the position, and of the size of velocity and acceleration.
    pub limits: [f64; 4],
}

/// Standard deviation of a parameter that a recording of one period would give.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExpectedDeviation {
    /// Name of the parameter or combination.
    pub name: String,
    /// SI unit of value and deviation.
    pub unit: String,
    /// Absent where the motion does not determine it, or the noise is not stated.
    #[serde(with = "number::optional")]
    pub std_dev: Option<f64>,
    /// The value that the prediction was made with; absent where nothing states one.
    #[serde(with = "number::optional", default)]
    pub value: Option<f64>,
}

/// A motion that a design is compared with, at as many samples and with the same noise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// The file that holds the motion, as the user wrote it.
    pub file: String,
    /// The criterion at that motion.
    #[serde(with = "number::nullable")]
    pub criterion_value: f64,
    /// As of the design.
    pub expected_std_dev: Vec<ExpectedDeviation>,
    /// As of the design.
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
    /// What is limited, in words.
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
    /// The limit itself.
    #[serde(with = "number::nullable")]
    pub limit: f64,
    /// Unit of limit and margin.
    pub unit: String,
}

/// What a motion shows of an effect on a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// Name of the joint.
    pub joint: String,
    /// Identifier of the effect.
    pub effect: String,
    /// The motion determines its parameters.
    pub shown: bool,
    /// In words, with the figures.
    pub sentence: String,
}

/// The best value at one time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Time since the search began, s.
    pub elapsed_s: f64,
    /// Starts that had been tried.
    pub starts: u64,
    /// Least value of the criterion so far.
    #[serde(with = "number::nullable")]
    pub value: f64,
}
