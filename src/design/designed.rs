//! What a design gives: its worth, how it ended, and its files.

use crate::design::output::Sampled;
use crate::outcome::design::Design;
use crate::outcome::estimate::Solver;
use crate::problem_file::ProblemFile;

/// Rate of the trajectory where the problem file states none, Hz.
const DEFAULT_RATE: f64 = 200.0;

/// A file of the results folder.
#[derive(Debug, Clone)]
pub struct NamedTrajectory {
    /// Without its end.
    pub name: String,
    pub sampled: Sampled,
}

/// How a design ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    Feasible,
    Infeasible,
    Interrupted,
}

/// What a design gives.
#[derive(Debug)]
pub struct Designed {
    pub design: Design,
    pub solver: Solver,
    pub end: End,
    pub trajectories: Vec<NamedTrajectory>,
    /// The first trajectory with ramps at both ends.
    pub with_ramps: Vec<NamedTrajectory>,
}

/// Rate of the trajectory's file.
pub(super) fn rate(problem: &ProblemFile) -> f64 {
    let recorded = problem.recordings.as_ref().and_then(|r| r.rate.as_ref());
    let simulated = problem.simulate.rate.as_ref();
    recorded.or(simulated).map_or(DEFAULT_RATE, |r| r.value)
}
