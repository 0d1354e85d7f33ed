//! The result of a design: its figures of merit, how it ended, and its trajectories.

use crate::design::trajectory::sampled::Sampled;
use crate::outcome::design::Design;
use crate::outcome::estimate::Solver;

/// A file of the results folder.
#[derive(Debug, Clone)]
pub struct NamedTrajectory {
    /// Without its end.
    pub name: String,
    /// Its rows.
    pub sampled: Sampled,
}

/// How a design ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The motion keeps every limit.
    Feasible,
    /// No motion that keeps every limit was found; the one with the least violation is given.
    Infeasible,
    /// The search was interrupted; the best motion until then is given.
    Interrupted,
}

/// What a design gives.
#[derive(Debug)]
pub struct Designed {
    /// The motion and what it is worth, as the result has them.
    pub design: Design,
    /// How the search ended, as the result has it.
    pub solver: Solver,
    /// How the design ended.
    pub end: End,
    /// One period of every trajectory, at the rate of the run.
    pub trajectories: Vec<NamedTrajectory>,
    /// The first trajectory with ramps at both ends.
    pub with_ramps: Vec<NamedTrajectory>,
}
