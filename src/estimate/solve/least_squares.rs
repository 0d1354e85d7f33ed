//! One least-squares solution of a fit problem, and the covariance of its residuals.

use crate::estimate::error::EstimateError;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::residual::noise::row_covariance;
use crate::problem::Problem;
use crate::problem::form::Structure;
use crate::problem::solution::{Control, Solution};
use crate::problem::view::LeastSquares;
use crate::solve::{levenberg_marquardt, linear};
use nalgebra::{DMatrix, DVector};

/// Share of the cost that a search may leave. The cost is half the number of residuals, and half a unit of
/// it is a standard deviation: for 1e6 residuals the search ends within 0.001 of one, so that two ways to write a law come to the
/// same.
pub(in crate::estimate) const COST_TOLERANCE: f64 = 1e-12;

/// Iterations after which a search has failed.
pub(in crate::estimate) const ITERATION_LIMIT: usize = 200;

/// Iterations between two estimates of the covariance: both converge together.
pub(in crate::estimate) const ITERATIONS_PER_ROUND: usize = 5;

pub(crate) fn covariance_at(problem: &FitProblem<'_>, x: &DVector<f64>) -> DMatrix<f64> {
    row_covariance(problem.model, &problem.counted_residuals(x), x.len())
}

pub(in crate::estimate) fn solve(
    problem: &dyn Problem,
    start: &DVector<f64>,
    max_iterations: usize,
    control: &Control<'_>,
) -> Result<Solution, EstimateError> {
    let view = LeastSquares::try_from(problem)?;
    if problem.form().structure == Structure::Affine {
        let solved = linear::solve(view, start, &linear::Settings::default())?;
        return Ok(solved.solution);
    }
    let settings = levenberg_marquardt::Settings {
        cost_tolerance: COST_TOLERANCE,
        max_iterations,
        ..levenberg_marquardt::Settings::default()
    };
    Ok(levenberg_marquardt::minimize(
        view, start, &settings, control,
    )?)
}
