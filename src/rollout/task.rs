//! The settings of a rollout, and its result.

use crate::outcome::Outcome;
use crate::outcome::rollout::Rollout;
use crate::problem_file::ProblemFile;
use crate::rollout::window::Window;

/// Rollouts with the windows that tables are written of.
#[derive(Debug)]
pub struct RolloutRun {
    /// The part of `rollout` of a result.
    pub rollout: Rollout,
    /// The windows that are shown sample by sample.
    pub examples: Vec<Window>,
}

/// What is rolled out.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// The problem that the result keeps.
    pub problem: &'a ProblemFile,
    /// The result whose models are rolled out.
    pub outcome: &'a Outcome,
    /// The result, as given, and overrides of its problem.
    pub source: &'a str,
    /// The overrides, `key=value`.
    pub set: &'a [String],
    /// Of the noise with which the model is compared.
    pub seed: u64,
}
