//! What `fleet` adds: how many items, what the types are like, and which robots to look at.

use serde::{Deserialize, Serialize};

use crate::outcome::number;

/// The part of `fleet`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Fleet {
    /// A paragraph in plain words.
    pub summary: String,
    /// Recordings, or groups of them, that were to be fitted or diagnosed.
    pub items: u64,
    /// Different robots among them.
    pub robots: u64,
    /// Items without a result.
    pub set_aside: u64,
    /// Share of robots among those in `look_at` that may have nothing, in the mean over many fleets.
    #[serde(with = "number::nullable")]
    pub rate: f64,
    /// Tests that were made of all robots and parameters.
    pub tests: u64,
    /// The surest first.
    pub look_at: Vec<LookAt>,
    /// Robots of one type each, in the order of their names.
    pub types: Vec<TypeFigures>,
    /// Items that were set aside, the first hundred in the order of the table.
    pub failures: Vec<Failure>,
    /// Files beside this one.
    pub files: Vec<String>,
    /// Anything a reader should know, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// How a parameter of a robot came to be listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// From one night to the next.
    Changed,
    /// A straight line over the nights leaves less than a step.
    Drifts,
    /// It lies outside of what robots of its type scatter.
    UnlikeItsType,
}

impl Reason {
    /// As people read it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Changed => "changed",
            Self::Drifts => "drifts",
            Self::UnlikeItsType => "unlike its type",
        }
    }
}

/// A robot to look at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LookAt {
    /// Name of the robot.
    pub robot: String,
    /// Type of the robot, with whose robots it is compared.
    #[serde(rename = "type")]
    pub kind_of_robot: String,
    /// What it is, such as `friction up`.
    pub kind: String,
    /// Absent where it belongs to no joint.
    pub joint: Option<String>,
    /// What was seen, in words.
    pub sentence: String,
    /// The parameter that shows it most clearly.
    pub evidence: Shown,
    /// Other parameters that are listed.
    pub also: Vec<Shown>,
    /// The parameter over the last nights.
    pub history: Vec<HistoryPoint>,
}

/// A parameter of a robot that is listed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shown {
    /// Name of the parameter.
    pub parameter: String,
    /// SI unit of the means.
    pub unit: String,
    /// How it came to be listed.
    pub reason: Reason,
    /// What the change means, such as `friction up`.
    pub kind: String,
    /// Time of the first recording behind the change; absent of a robot that is unlike its type.
    #[serde(with = "number::optional")]
    pub since: Option<f64>,
    /// Mean before the change, or of the type.
    #[serde(with = "number::nullable")]
    pub before: f64,
    /// Standard error of that mean, or the spread of the type.
    #[serde(with = "number::nullable")]
    pub before_std: f64,
    /// Mean behind the change, or of the robot.
    #[serde(with = "number::nullable")]
    pub after: f64,
    /// Standard error of that mean.
    #[serde(with = "number::nullable")]
    pub after_std: f64,
    /// Size in standard deviations, with its sign.
    #[serde(with = "number::nullable")]
    pub z: f64,
    /// Of this test alone.
    #[serde(with = "number::nullable")]
    pub p_value: f64,
    /// One minus the rate of false discoveries at which it would just be listed.
    #[serde(with = "number::nullable")]
    pub probability: f64,
}

/// A value of one night.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HistoryPoint {
    /// Time of the recording, s since 1970.
    #[serde(with = "number::nullable")]
    pub time: f64,
    /// In the parameter's unit.
    #[serde(with = "number::nullable")]
    pub value: f64,
    /// Standard deviation of the fit.
    #[serde(with = "number::nullable")]
    pub std: f64,
}

/// Robots of one type.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TypeFigures {
    /// Name of the type.
    pub name: String,
    /// Robots of it.
    pub robots: u64,
    /// What their parameters are like.
    pub parameters: Vec<ParameterFigures>,
}

/// A parameter over the robots of a type.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterFigures {
    /// Name of the parameter.
    pub name: String,
    /// SI unit of mean and deviations.
    pub unit: String,
    /// Absent of fewer than five robots.
    #[serde(with = "number::optional")]
    pub mean: Option<f64>,
    /// Standard deviation between robots, of the same.
    #[serde(with = "number::optional")]
    pub between_robots: Option<f64>,
    /// Standard deviation between nights of one robot, beyond that of a fit.
    #[serde(with = "number::nullable")]
    pub between_nights: f64,
    /// Median standard deviation of a fit.
    #[serde(with = "number::nullable")]
    pub of_a_fit: f64,
}

/// An item that was set aside.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Name of the robot.
    pub robot: String,
    /// Time of the recording, s since 1970.
    #[serde(with = "number::nullable")]
    pub time: f64,
    /// Stable code of the fault.
    pub code: String,
    /// What is wrong and what to do about it.
    pub message: String,
}
