//! A fit with errors in variables: maximum likelihood with exact motion first, then parameters and motion together.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::chain::prior::Prior;
use crate::estimate::error::EstimateError;
use crate::estimate::errors_in_variables::problem::ErrorsInVariables;
use crate::estimate::fit::{Fitted, outcome_with};
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::fit_problem::problem::NoiseSource;
use crate::estimate::minimisation::fit_setup::FitSetup;
use crate::estimate::minimisation::optimum::Optimum;
use crate::estimate::minimisation::reweight::weights_of_periods;
use crate::estimate::solve::least_squares::{ITERATION_LIMIT, solve};
use crate::estimate::uncertainty::covariance::of_unknowns;
use crate::problem::solution::{Control, Solution};
use nalgebra::DVector;

/// Fits a model to the training recordings of a dataset, joint angles and signals both noisy.
///
/// The covariance of the parameters is that along the corrected motion plus what the corrections add to it.
/// Predictions and errors are along the motion as recorded.
///
/// # Errors
/// Those of a fit; a recording that is no average over periods; a law with memory.
pub fn fit(
    model: &Model,
    data: &Dataset,
    prior: &Prior,
    control: &Control<'_>,
) -> Result<Fitted, EstimateError> {
    let setup = FitSetup::of(model, data, prior)?;
    let Optimum {
        solution: first,
        mut problem,
    } = setup
        .minimisation(Estimator::MaximumLikelihood, control)
        .run()?;
    if let Some(weights) = weights_of_periods(&problem)? {
        problem.reweigh(weights);
        problem.noise = NoiseSource::Periods;
    }
    let noisy = ErrorsInVariables::new(&problem)?;
    let count = noisy.parameters();
    let start = first.x.clone().resize_vertically(noisy.unknowns(), 0.0);
    let found = solve(&noisy, &start, ITERATION_LIMIT, control)?;
    let corrected = noisy.corrected(&found.x);
    let corrected: Vec<&Prepared> = corrected.iter().collect();
    let along = problem.along(&corrected);
    let parameters: DVector<f64> = found.x.rows(0, count).into_owned();
    let added = noisy.added_covariance(&found.x);
    let covariance = of_unknowns(&along, &parameters)
        .zip(added)
        .map(|(a, b)| a + b);
    let solution = Solution {
        x: parameters,
        iterations: first.iterations + found.iterations,
        evaluations: first.evaluations + found.evaluations,
        ..found
    };
    Ok(outcome_with(&along, &solution, covariance, data))
}
