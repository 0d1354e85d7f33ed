//! What was run: version, seed, problem and input files, so that a result can be made again.

use serde::{Deserialize, Serialize};

use crate::outcome::input::Input;
use crate::outcome::number;
use crate::outcome::provenance::Provenance;

/// What was run, on what, and how long it took.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Version of the program, [`VERSION`](crate::outcome::provenance::VERSION).
    pub version: String,
    /// Seed of every random number of the run.
    pub seed: u64,
    /// The problem file as read, overrides included.
    pub problem: serde_json::Value,
    /// Every file that was read, with its hash; the problem file is the first.
    pub inputs: Vec<Input>,
    /// Wall time in s; it and `provenance` alone differ between repetitions.
    #[serde(with = "number::nullable")]
    pub wall_s: f64,
    /// Who ran it, when and on what; empty in results of versions that did not say.
    #[serde(default)]
    pub provenance: Provenance,
}
