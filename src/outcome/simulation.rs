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
    /// Anything a reader should know, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
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
