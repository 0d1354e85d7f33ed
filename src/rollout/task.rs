//! What is rolled out, and what comes of it.

use crate::outcome::Outcome;
use crate::outcome::rollout::Rollout;
use crate::problem_file::ProblemFile;
use crate::rollout::window::Window;

/// Rollouts with the windows that tables are written of.
#[derive(Debug)]
pub struct RolloutRun {
    pub rollout: Rollout,
    pub examples: Vec<Window>,
}

/// What is rolled out.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    pub problem: &'a ProblemFile,
    pub outcome: &'a Outcome,
    /// The result, as given, and overrides of its problem.
    pub source: &'a str,
    pub set: &'a [String],
    pub seed: u64,
}
