//! Tolerances and limits of sequential quadratic programming.

use crate::solve::error::{SolveError, check_tolerances};

/// When to stop.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Iterations after which it stops with [`Stop::IterationLimit`](crate::problem::solution::Stop).
    pub max_iterations: usize,
    /// Stop when the penalty's model promises a decrease <= cost_tolerance · (1 + |cost|). No unit.
    pub cost_tolerance: f64,
    /// A constraint g >= 0 holds when g >= −feasibility_tolerance, in the constraint's unit.
    pub feasibility_tolerance: f64,
    /// Stop as stalled when the last `patience` iterations together lowered the penalty by
    /// <= progress_tolerance · (1 + |penalty|): smooth minima are reached long before.
    pub progress_tolerance: f64,
    /// Iterations over which progress is judged, > 0.
    pub patience: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            max_iterations: 500,
            cost_tolerance: 1e-9,
            feasibility_tolerance: 1e-7,
            progress_tolerance: 1e-8,
            patience: 10,
        }
    }
}

impl Settings {
    pub(super) fn validate(&self) -> Result<(), SolveError> {
        check_tolerances(&[
            ("cost_tolerance", self.cost_tolerance),
            ("feasibility_tolerance", self.feasibility_tolerance),
            ("progress_tolerance", self.progress_tolerance),
        ])
    }
}
