//! What `rollout` adds: how far a model that is simulated forward under the recorded torques or commands strays from the recording.

use serde::{Deserialize, Serialize};

use crate::outcome::number;
use crate::outcome::skeleton::Skeleton;

/// The part of `rollout`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Rollout {
    /// The result whose models were simulated, as given.
    pub source: String,
    /// Overrides of the problem that it keeps.
    #[serde(default)]
    pub set: Vec<String>,
    /// Verb of that result.
    pub source_verb: String,
    /// What `before` is; absent without such a model.
    pub before: Option<Before>,
    /// Whether the windows lie in what was fitted.
    pub held_out: HeldOutRows,
    /// A paragraph in plain words.
    pub summary: String,
    /// Errors of position by horizon, the shortest first.
    pub horizons: Vec<Horizon>,
    /// The same at more instants, for the picture.
    #[serde(default)]
    pub curves: Vec<ErrorCurve>,
    /// Windows of one recording each.
    pub recordings: Vec<RolledRecording>,
    /// Two windows, sample by sample: one in the middle of all by its error, and the worst.
    #[serde(default)]
    pub examples: Vec<Example>,
    /// The robot, for the picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skeleton: Option<Skeleton>,
    /// How the motion was computed.
    pub integrator: Integrator,
    /// Anything a reader should know, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// The model that the final one is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Before {
    /// The values that the files declare, nothing estimated.
    DeclaredValues,
    /// The declared model, its parameters fitted.
    DeclaredFitted,
}

impl Before {
    /// As people read it.
    pub fn words(self) -> &'static str {
        match self {
            Self::DeclaredValues => "the model with the values that its files declare",
            Self::DeclaredFitted => "the declared model, its parameters fitted",
        }
    }
}

/// Where the windows lie.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeldOutRows {
    /// In the recordings that are kept for validation.
    #[default]
    Validation,
    /// In blocks of the training recordings that were not fitted.
    Blocks,
    /// In what was fitted: nothing is held out.
    Train,
}

impl HeldOutRows {
    /// As people read it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Validation => "recordings that were not fitted",
            Self::Blocks => "blocks of the training recordings that were not fitted",
            Self::Train => "the recordings that were fitted, as none is held out",
        }
    }
}

/// Errors at one time after the start of the windows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Horizon {
    /// s.
    #[serde(with = "number::nullable")]
    pub horizon: f64,
    /// Errors of every joint at that time.
    pub joints: Vec<JointErrors>,
}

/// Errors of position of one joint at a horizon.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointErrors {
    /// Name of the joint.
    pub joint: String,
    /// rad or m.
    pub unit: String,
    /// Of the model before; absent without one.
    pub before: Option<Spread>,
    /// Of the final model.
    pub after: Spread,
    /// What the final model would give were it right: its own torques with the noise of the signal, from starts with the
    /// errors of the estimated motion.
    pub noise: Spread,
    /// RMS change of the position of the final model when every step is halved.
    #[serde(with = "number::nullable")]
    pub integration: f64,
}

/// Sizes of an error over windows. A window that is lost has an error without limit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Windows that reach the horizon.
    pub windows: usize,
    /// Of these, windows in which the model is lost: further than half a turn (1 m) from the recording, or no number.
    pub lost: usize,
    /// Over the windows that are not lost; absent where all are.
    #[serde(with = "number::optional")]
    pub rms: Option<f64>,
    /// Of the size of the error; absent where it has no limit.
    #[serde(with = "number::optional")]
    pub lower_quartile: Option<f64>,
    /// Of the size of the error; absent where it has no limit.
    #[serde(with = "number::optional")]
    pub median: Option<f64>,
    /// Of the size of the error; absent where it has no limit.
    #[serde(with = "number::optional")]
    pub upper_quartile: Option<f64>,
}

/// Sizes of the errors of a joint over the time since the start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ErrorCurve {
    /// Name of the joint.
    pub joint: String,
    /// rad or m.
    pub unit: String,
    /// s.
    pub t: Vec<f64>,
    /// Of the model before, by instant; empty without one.
    pub before: Vec<Spread>,
    /// Of the final model, by instant.
    pub after: Vec<Spread>,
    /// Of the final model were it right, by instant: see [`JointErrors::noise`].
    pub noise: Vec<Spread>,
}

/// The windows of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RolledRecording {
    /// Name of the recording.
    pub recording: String,
    /// How many of its windows were simulated.
    pub windows: usize,
    /// From one start to the next, s.
    #[serde(with = "number::nullable")]
    pub every: f64,
}

/// One window.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Example {
    /// `median` or `worst`.
    pub kind: String,
    /// Name of the recording in which it lies.
    pub recording: String,
    /// Of the start in the recording, s.
    #[serde(with = "number::nullable")]
    pub start: f64,
    /// s since the start, some of the samples.
    pub t: Vec<f64>,
    /// Joint by joint, sample by sample.
    pub joints: Vec<ExampleJoint>,
}

/// Positions of a joint in a window, rad or m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExampleJoint {
    /// Name of the joint.
    pub joint: String,
    /// rad or m.
    pub unit: String,
    /// As recorded.
    #[serde(with = "number::list")]
    pub recorded: Vec<f64>,
    /// By the model before; empty without one.
    #[serde(with = "number::list")]
    pub before: Vec<f64>,
    /// By the final model.
    #[serde(with = "number::list")]
    pub after: Vec<f64>,
}

/// How motions were integrated.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Integrator {
    /// Name of the method and its order.
    pub name: String,
    /// Longest step, s.
    #[serde(with = "number::nullable")]
    pub step: f64,
    /// Windows that were simulated again with every step halved.
    pub checked: usize,
}
