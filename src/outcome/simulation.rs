//! What `simulate` adds: the files it wrote and the noise that was realised in them.

use serde::{Deserialize, Serialize};

use crate::outcome::number;

/// The part of `simulate`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Simulation {
    /// Names of the recordings in the results folder.
    pub files: Vec<String>,
    /// Noise of every channel of every recording.
    pub realised_noise: Vec<RealisedNoise>,
    /// Where the recordings have the positions of the joints that have a channel of the signal.
    #[serde(default)]
    pub positions: Vec<RecordedPosition>,
    /// Anything a reader should know, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// The column of a joint's position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordedPosition {
    /// Name of the joint.
    pub joint: String,
    /// Name of the column of its signal.
    pub channel: String,
    /// Name of the column of its position.
    pub column: String,
    /// rad, or m of a joint that slides.
    pub unit: String,
    /// What the numbers of the column are multiplied by to be in that unit.
    #[serde(with = "number::nullable")]
    pub factor: f64,
}

/// Noise of one channel as it came out of the generator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RealisedNoise {
    /// Name of its column in the recording.
    pub channel: String,
    /// Unit of the deviation.
    pub unit: String,
    /// Standard deviation over the samples written.
    #[serde(with = "number::nullable")]
    pub std_dev: f64,
}
