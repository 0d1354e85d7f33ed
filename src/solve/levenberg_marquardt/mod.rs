//! Levenberg-Marquardt for min 1/2 |r(x)|² subject to lower <= x <= upper.
//!
//! A step d minimises |J d + r|² + lambda |D d|² within the bounds, by QR of [R; sqrt(lambda) D], where R is
//! the triangular factor of J and D holds the largest column norms seen. It is accepted if the nonlinear cost
//! falls; lambda follows the ratio of actual to predicted decrease. Sources: Moré (1978) for D, Nielsen
//! (1999) for lambda, Bates and Watts (1981) for the test of convergence. The iterations run in argmin.

use argmin::core::{Executor, State, TerminationReason, TerminationStatus};
use nalgebra::DVector;

use crate::problem::bounds;
use crate::problem::solution::{Control, Solution, Stop};
use crate::problem::view::LeastSquares;
use crate::solve::admissible_start;
use crate::solve::error::{SolveError, SolveErrorKind};
use crate::solve::levenberg_marquardt::iteration::{Iterate, Iteration};
use crate::solve::levenberg_marquardt::model::Model;

mod iteration;
mod model;
mod settings;

pub use crate::solve::levenberg_marquardt::settings::Settings;

/// Minimises from a start, which is first projected on the bounds.
pub fn minimize(
    view: LeastSquares,
    start: &DVector<f64>,
    settings: &Settings,
    control: &Control,
) -> Result<Solution, SolveError> {
    settings.validate()?;
    let x = admissible_start(view.problem().form(), start)?;
    let model = Model::at(view.problem(), &x)?
        .ok_or_else(|| SolveError::whole(SolveErrorKind::ModelNotFinite))?;
    let iteration = Iteration::new(settings, control, model);
    let mut executor = Executor::new(view, iteration)
        .configure(|state: Iterate| state.param(x).max_iters(settings.max_iterations as u64))
        .ctrlc(false);
    if let Some(limit) = control.time_limit {
        executor = executor.timeout(limit);
    }
    let mut result = executor.run().map_err(defect)?;
    let x = result
        .state
        .take_best_param()
        .ok_or_else(|| defect("no best point"))?;
    let iteration = result.solver;
    Ok(Solution {
        active_bounds: bounds::active(view.problem().form(), &x),
        x,
        cost: iteration.cost(),
        stop: iteration
            .stop()
            .unwrap_or_else(|| stop_of(result.state.get_termination_status())),
        iterations: result.state.get_iter() as usize,
        // The linearisation at the start comes before argmin counts.
        evaluations: 1 + result.problem.counts.values().sum::<u64>() as usize,
        trace: iteration.into_trace(),
    })
}

fn stop_of(status: &TerminationStatus) -> Stop {
    match status {
        TerminationStatus::Terminated(TerminationReason::Timeout) => Stop::TimeLimit,
        TerminationStatus::Terminated(TerminationReason::Interrupt) => Stop::Interrupted,
        _ => Stop::IterationLimit,
    }
}

fn defect(error: impl std::fmt::Display) -> SolveError {
    SolveError::whole(SolveErrorKind::Defect {
        message: error.to_string(),
    })
}

#[cfg(test)]
mod nist;
#[cfg(test)]
mod tests;
