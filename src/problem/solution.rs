//! What a solver returns (point, why it stopped, its trace) and what it lets its caller control.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use nalgebra::DVector;

use crate::problem::bounds::ActiveBound;
use crate::problem::count::{Count, Done};

/// Why a solver stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stop {
    /// Neither the model nor the last step lowers the cost by more than the tolerance.
    CostTolerance,
    /// The last step changed no variable by more than the tolerance.
    StepTolerance,
    /// The gradient, projected on the bounds, is within the tolerance.
    GradientTolerance,
    /// A direct or interior-point method reached the optimum within its tolerances.
    Optimal,
    /// No point satisfies the constraints.
    Infeasible,
    /// No step lowers the cost although no test of convergence holds.
    Stalled,
    /// So many iterations were allowed, and none of the tests of convergence holds.
    IterationLimit,
    /// The time allowed is over, and none of the tests of convergence holds.
    TimeLimit,
    /// The caller asked to stop.
    Interrupted,
    /// A defect of the program ended the search.
    Defect,
}

impl Stop {
    /// Whether the point is a solution within the solver's tolerances.
    pub fn converged(self) -> bool {
        matches!(
            self,
            Self::CostTolerance | Self::StepTolerance | Self::GradientTolerance | Self::Optimal
        )
    }

    /// The name in results, in kebab-case.
    pub fn name(self) -> &'static str {
        match self {
            Self::CostTolerance => "cost-tolerance",
            Self::StepTolerance => "step-tolerance",
            Self::GradientTolerance => "gradient-tolerance",
            Self::Optimal => "optimal",
            Self::Infeasible => "infeasible",
            Self::Stalled => "stalled",
            Self::IterationLimit => "iteration-limit",
            Self::TimeLimit => "time-limit",
            Self::Interrupted => "interrupted",
            Self::Defect => "defect",
        }
    }
}

/// The end of a run: stopping is a result, not an error.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The point, in the units of the problem's variables.
    pub x: DVector<f64>,
    /// f(x).
    pub cost: f64,
    /// Why it is the last one.
    pub stop: Stop,
    /// Accepted and rejected steps together.
    pub iterations: usize,
    /// Calls of the problem, values and linearisations together.
    pub evaluations: usize,
    /// Variables held at a bound.
    pub active_bounds: Vec<ActiveBound>,
    /// How the run came there.
    pub trace: Trace,
}

impl Solution {
    /// The solver's measure of stationarity at the last point; ∞ of a run without a step.
    pub fn stationarity(&self) -> f64 {
        self.trace
            .rows
            .last()
            .map_or(f64::INFINITY, |row| row.stationarity)
    }

    /// A point to begin at, that no run has come to.
    pub fn untried(x: DVector<f64>) -> Self {
        Self {
            x,
            cost: f64::INFINITY,
            stop: Stop::IterationLimit,
            iterations: 0,
            evaluations: 0,
            active_bounds: Vec::new(),
            trace: Trace::default(),
        }
    }
}

/// The course of a run, one row per iteration.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trace {
    /// In the order of the run.
    pub rows: Vec<TraceRow>,
}

/// One iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceRow {
    /// Its number, one more from row to row.
    pub iteration: usize,
    /// f at the best point so far.
    pub cost: f64,
    /// Largest change of a variable over its scale; zero for a rejected step.
    pub step: f64,
    /// The solver's measure of stationarity; zero at a solution.
    pub stationarity: f64,
    /// Damping, penalty or barrier parameter of the solver.
    pub regularization: f64,
}

/// What a caller may do to a run: stop it, limit its time, watch it.
#[derive(Clone, Default)]
pub struct Control<'a> {
    /// Set from anywhere; the run ends with the best point so far.
    pub interrupt: Option<Arc<AtomicBool>>,
    /// Checked between iterations.
    pub time_limit: Option<Duration>,
    /// Called once per iteration.
    pub progress: Option<&'a (dyn Fn(&TraceRow) + Sync)>,
    /// Called once per part of a run that has many alike.
    pub parts: Option<&'a (dyn Fn(&Done) + Sync)>,
}

impl<'a> Control<'a> {
    /// A count of so many parts, of which the watcher hears.
    pub fn counting(&self, all: usize) -> Count<'a> {
        Count::new(self.parts, all)
    }
}

impl Control<'_> {
    /// Of a run that ends at once, with the point that it would begin at.
    pub fn stopped() -> Self {
        Self {
            interrupt: Some(Arc::new(AtomicBool::new(true))),
            ..Self::default()
        }
    }

    /// Whether the caller has asked for the end, from whichever thread.
    pub fn is_interrupted(&self) -> bool {
        self.interrupt
            .as_ref()
            .is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Tells the watcher, if there is one.
    pub fn report(&self, row: &TraceRow) {
        if let Some(progress) = self.progress {
            progress(row);
        }
    }
}
