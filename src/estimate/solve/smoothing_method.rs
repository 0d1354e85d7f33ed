//! Smoothing method for least squares whose model has kinks.
//!
//! An efficiency or load-dependent friction has `|τ_M|` in it, whose slope jumps where the transmitted torque changes
//! sign. The sum of squares then has a kink in every sample, and where a gear transmits hardly more than the noise
//! steps by derivatives end at one of them, up to two standard deviations from the optimum. A search that does is
//! made again from its start with the law smoothed,
//!
//! ```text
//! |τ_M| → τ_M²/(2s) + s/2   for |τ_M| < s,
//! ```
//!
//! with s a share of the deviation of the residuals, and the share falls to a hundredth: that is what the estimate
//! then minimises, and it differs from the law itself where a gear transmits less than a hundredth of the noise.

use crate::chain::model::Model;
use crate::estimate::error::EstimateError;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::solve::least_squares::{covariance_at, solve};
use crate::problem::Problem;
use crate::problem::form::Objective;
use crate::problem::solution::{Control, Solution, Stop};
use crate::problem::view::LeastSquares;
use crate::solve::levenberg_marquardt;
use nalgebra::DVector;

/// s over the deviation of the residuals, from search to search.
const SHARES: [f64; 5] = [1.0, 0.3, 0.1, 0.03, 0.01];

/// A search with smoothed switches ends within this many standard deviations of its optimum.
const NEAR: f64 = 0.03;

/// A search that ends at its limit of iterations is at its optimum within this many standard deviations: an interval of two on either side
/// is shifted by a fortieth of its width at most.
const NEAR_ENOUGH: f64 = 0.1;

/// The optimum from a start: of the law itself where steps by derivatives reach it, else of the law with its
/// switches smoothed below the noise. The cost is that of the law itself.
pub(in crate::estimate) fn search(
    problem: &FitProblem<'_>,
    start: &DVector<f64>,
    max_iterations: usize,
    control: &Control<'_>,
) -> Result<Solution, EstimateError> {
    let mut found = solve(problem, start, max_iterations, control)?;
    if found.stop == Stop::IterationLimit && found.stationarity() <= tolerance(problem, NEAR_ENOUGH)
    {
        found.stop = Stop::CostTolerance;
    }
    let caught = matches!(found.stop, Stop::Stalled | Stop::IterationLimit);
    if !caught || !problem.model.has_switches() {
        return Ok(found);
    }
    let mut deviations = vec![f64::INFINITY; problem.model.joints().len()];
    let mut from = start.clone();
    for share in SHARES {
        // Far from the optimum residuals are more than noise.
        let met = torque_deviations(problem, &from);
        let pairs = deviations.iter_mut().zip(met);
        pairs.for_each(|(d, met)| *d = d.min(met));
        let widths: Vec<f64> = deviations.iter().map(|d| share * d).collect();
        let smoothed = problem.smoothed(&widths);
        let next = minimise_smoothed(&smoothed, &from, max_iterations, control)?;
        from.copy_from(&next.x);
        found = accumulate(found, next);
    }
    if let Ok(values) = problem.values(&found.x) {
        found.cost = values.cost;
    }
    Ok(found)
}

/// Share of the cost that is left so many standard deviations from the optimum: a promise of p lies `√(2p)` of them from it, and the
/// cost is half the number of rows in units of the noise.
fn tolerance(problem: &FitProblem<'_>, deviations: f64) -> f64 {
    let rows = match problem.form().objective {
        Objective::SumOfSquares { rows } => rows.max(1),
        Objective::Smooth => 1,
    };
    deviations * deviations / rows as f64
}

/// Levenberg-Marquardt to within [`NEAR`] of the optimum.
fn minimise_smoothed(
    problem: &FitProblem<'_>,
    start: &DVector<f64>,
    max_iterations: usize,
    control: &Control<'_>,
) -> Result<Solution, EstimateError> {
    let settings = levenberg_marquardt::Settings {
        cost_tolerance: tolerance(problem, NEAR),
        max_iterations,
        ..levenberg_marquardt::Settings::default()
    };
    let view = LeastSquares::try_from(problem as &dyn Problem)?;
    Ok(levenberg_marquardt::minimize(
        view, start, &settings, control,
    )?)
}

/// Torque of each joint's motor that changes its signal by the deviation of its residuals, N·m (N).
fn torque_deviations(problem: &FitProblem<'_>, x: &DVector<f64>) -> Vec<f64> {
    let covariance = covariance_at(problem, x);
    let values = problem.parameters(x);
    let mut deviations = vec![0.0; problem.model.joints().len()];
    for (c, channel) in problem.model.channels().iter().enumerate() {
        if let (Some(joint), true) = (channel.joint, channel.active) {
            let torque = torque_per_signal(problem.model, joint, &values);
            deviations[joint] = torque * covariance[(c, c)].sqrt();
        }
    }
    deviations
}

/// Torque per signal of a motor at small signals, N·m/A, or no unit where the signal is a torque.
fn torque_per_signal(model: &Model, joint: usize, values: &DVector<f64>) -> f64 {
    let joint = &model.joints()[joint];
    let constant = match joint.polynomial {
        Some(first) => values[first + 1],
        None => joint.torque_constant,
    };
    let gain = joint.gain.map_or(1.0, |at| values[at]);
    (constant * gain).abs()
}

/// One search after another, as one.
pub(in crate::estimate) fn accumulate(before: Solution, after: Solution) -> Solution {
    Solution {
        iterations: before.iterations + after.iterations,
        evaluations: before.evaluations + after.evaluations,
        ..after
    }
}
