//! Minimisation for each estimator: weights of the residuals, iterated where they follow from the residuals.

use crate::chain::dataset::Prepared;
use crate::chain::model::{Channel, Model};
use crate::estimate::error::EstimateError;
use crate::estimate::fit_problem::estimator::{Estimator, Training};
use crate::estimate::fit_problem::problem::{FitProblem, NoiseSource};
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::estimate::minimisation::optimum::{Optimum, searched};
use crate::estimate::minimisation::reweight::{by_periods, reweighted, robust};
use crate::estimate::residual::weights::Weights;
use crate::estimate::solve::least_squares::{ITERATIONS_PER_ROUND, covariance_at, solve};
use crate::problem::Problem;
use crate::problem::form::Form;
use crate::problem::solution::{Control, Solution};
use nalgebra::{DMatrix, DVector};

/// What is minimised: over unknowns of a model, by an estimator, from recordings.
pub(in crate::estimate) struct Minimisation<'a, 'c> {
    pub model: &'a Model,
    pub unknowns: &'a Unknowns,
    pub training: Training<'a>,
    pub estimator: Estimator,
    pub control: &'c Control<'c>,
}

impl<'a> Minimisation<'a, '_> {
    /// The optimum, from where a search over fewer rows ended or else from the start that the recordings suggest.
    pub fn from(&self, begun: Option<Solution>) -> Result<Optimum<'a>, EstimateError> {
        let Self {
            model,
            unknowns,
            training,
            estimator,
            control,
        } = *self;
        if estimator == Estimator::MaximumLikelihood
            && let Some(optimum) = by_periods(model, unknowns, training, begun.as_ref(), control)?
        {
            return match optimum.problem.noise {
                NoiseSource::Periods => Ok(optimum),
                NoiseSource::Residuals => reweighted(optimum, control),
            };
        }
        let ordinary = FitProblem::new(
            model,
            unknowns,
            training,
            ordinary_weights(model, training.recordings),
        );
        let first = match begun {
            Some(begun) if estimator != Estimator::Ordinary => begun,
            begun => searched(&ordinary, begun.as_ref(), control)?,
        };
        if estimator == Estimator::Ordinary {
            let scale = residual_deviation(&ordinary, &first);
            let scaled = ordinary.weights().scaled(1.0 / scale);
            let problem = FitProblem::new(model, unknowns, training, scaled);
            return Ok(Optimum {
                solution: first,
                problem,
            });
        }
        let covariance = covariance_at(&ordinary, &first.x);
        let deviations: Vec<f64> = covariance.diagonal().iter().map(|v| v.sqrt()).collect();
        let weighted = FitProblem::new(
            model,
            unknowns,
            training,
            Weights::by_deviation(&deviations),
        );
        match estimator {
            Estimator::Robust => {
                let solution = solve(&weighted, &first.x, ITERATIONS_PER_ROUND, control)?;
                let second = Optimum {
                    solution,
                    problem: weighted,
                };
                robust(second, control)
            }
            _ => {
                let first = Optimum {
                    solution: first,
                    problem: weighted,
                };
                reweighted(first, control)
            }
        }
    }
}

/// One weight for the torque of every joint: currents count by their torque constants, and torques of
/// coupled motors as those of the joints that they move, `τ = V⁻ᵀ τ_M`.
pub(super) fn ordinary_weights(model: &Model, recordings: &[&Prepared]) -> Weights {
    let of = |(k, c): (usize, &Channel)| match (c.joint, model.platform().accuracy) {
        (Some(j), _) if c.active => model.torque_per_signal(j).abs(),
        (None, Some(accuracy)) => 1.0 / (accuracy * root_mean_square(recordings, k)),
        _ => 1.0,
    };
    let channels = model.channels();
    let factors = channels.iter().enumerate().map(of);
    let factors = DVector::from_iterator(channels.len(), factors);
    let torques = channels.iter().filter(|c| c.joint.is_some()).count();
    let coupling = model.coupling(&model.values());
    match coupling.transpose().try_inverse() {
        Some(to_joints) if !model.is_uncoupled() && torques > 0 => {
            let mut whole = DMatrix::identity(channels.len(), channels.len());
            whole
                .view_mut((0, 0), (torques, torques))
                .copy_from(&to_joints);
            Weights::Full(whole * DMatrix::from_diagonal(&factors))
        }
        _ => Weights::PerChannel(factors),
    }
}

/// Root mean square of a channel over all rows, 1 where it is zero.
pub(in crate::estimate) fn root_mean_square(recordings: &[&Prepared], channel: usize) -> f64 {
    let all = recordings.iter().flat_map(|r| r.signal(channel));
    let (count, squares) = all.fold((0.0, 0.0), |(n, s), x| (n + 1.0, s + x * x));
    if squares > 0.0 {
        f64::sqrt(squares / count)
    } else {
        1.0
    }
}

/// Standard deviation of the weighted residual over all channels.
pub(super) fn residual_deviation(problem: &FitProblem<'_>, solution: &Solution) -> f64 {
    let form: &Form = problem.form();
    let crate::problem::form::Objective::SumOfSquares { rows } = form.objective else {
        return 1.0;
    };
    let freedom = rows.saturating_sub(solution.x.len()).max(1) as f64;
    let deviation = (2.0 * solution.cost / freedom).sqrt();
    if deviation > 0.0 { deviation } else { 1.0 }
}
