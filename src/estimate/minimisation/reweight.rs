//! Iteratively reweighted least squares, by robust weights of the residuals and by the covariance of repeated periods.
//!
//! Maximum likelihood takes the covariance Σ of a period average across channels from the scatter of P
//! periods about it, which has (P − 1) N degrees of freedom for N rows (Swevers et al. 2002, section 4.3), as
//! long as the residuals agree with it. Where they are larger the model lacks something, the scatter no
//! longer says how far a row is off. What correlates the residuals of two joints is then mostly what the model lacks on
//! both, and to count it as noise would give one joint's misfit to the other: Σ is diagonal, with the variances of the
//! residuals, iterated.

use crate::chain::dataset::Prepared;
use crate::chain::model::Model;
use crate::estimate::error::EstimateError;
use crate::estimate::fit_problem::estimator::Training;
use crate::estimate::fit_problem::problem::{FitProblem, NoiseSource};
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::estimate::minimisation::optimum::{Optimum, searched};
use crate::estimate::residual::noise::{ResidualSeries, counting_rows};
use crate::estimate::residual::weights::{RowFactors, Weights};
use crate::estimate::solve::least_squares::{
    ITERATION_LIMIT, ITERATIONS_PER_ROUND, covariance_at, solve,
};
use crate::estimate::solve::smoothing_method::{accumulate, search};
use crate::problem::solution::{Control, Solution};
use crate::stats::distribution::Distribution;
use crate::stats::robust::{TUKEY_THRESHOLD, mad_scale, tukey_weight};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Rounds of reweighting after which the weights change nothing that matters any more.
const MAX_ROUNDS: usize = 20;

/// Reweighting ends when no unknown moves by more than this share of its standard deviation.
const ROUND_TOLERANCE: f64 = 1e-2;

/// Iteratively reweighted least squares: Tukey's biweight of every residual over its channel's robust scale.
pub(in crate::estimate) fn robust<'a>(
    from: Optimum<'a>,
    control: &Control<'_>,
) -> Result<Optimum<'a>, EstimateError> {
    let Optimum {
        mut solution,
        mut problem,
    } = from;
    for _ in 0..MAX_ROUNDS {
        let series = problem.counted_residuals(&solution.x);
        problem = problem.with_factors(biweights(&series));
        let next = search(&problem, &solution.x, ITERATION_LIMIT, control)?;
        let settled = settled(&problem, &solution.x, &next.x);
        solution = accumulate(solution, next);
        if settled {
            break;
        }
    }
    Ok(Optimum { solution, problem })
}

/// Square roots of the biweights: factors of residuals.
fn biweights(series: &ResidualSeries) -> RowFactors {
    let channels = series.first().map_or(0, Vec::len);
    let scales: Vec<f64> = (0..channels)
        .map(|c| {
            let moving = series.iter().flat_map(|r| r[c].iter().copied());
            let all: Vec<f64> = moving.filter(|e| *e != 0.0).collect();
            mad_scale(&all).filter(|s| *s > 0.0).unwrap_or(1.0)
        })
        .collect();
    let of = |recording: &Vec<Vec<f64>>| {
        let channel = |(c, e): (usize, &Vec<f64>)| {
            let weight = |e: &f64| tukey_weight(e / scales[c], TUKEY_THRESHOLD).sqrt();
            e.iter().map(weight).collect()
        };
        recording.iter().enumerate().map(channel).collect()
    };
    series.iter().map(of).collect()
}

/// The optimum under the covariance that the scatter of the periods gives, from where another search ended or from
/// the linear start; its noise source says whether the residuals agree with that. `None` unless every recording is
/// an average.
pub(super) fn by_periods<'a>(
    model: &'a Model,
    unknowns: &'a Unknowns,
    training: Training<'a>,
    begun: Option<&Solution>,
    control: &Control<'_>,
) -> Result<Option<Optimum<'a>>, EstimateError> {
    let Some(covariance) = scatter_of_periods(model, training.recordings) else {
        return Ok(None);
    };
    let weights = Weights::by_covariance(&covariance)?;
    let mut problem = FitProblem::new(model, unknowns, training, weights);
    let solution = searched(&problem, begun, control)?;
    if agrees(&problem, &solution.x, &covariance) {
        problem.noise = NoiseSource::Periods;
    }
    Ok(Some(Optimum { solution, problem }))
}

/// Weights and optimum in turn until neither changes: the deviations of the residuals.
pub(super) fn reweighted<'a>(
    from: Optimum<'a>,
    control: &Control<'_>,
) -> Result<Optimum<'a>, EstimateError> {
    let Optimum {
        mut solution,
        mut problem,
    } = from;
    for round in 0..MAX_ROUNDS {
        let covariance = covariance_at(&problem, &solution.x);
        let weights = Weights::by_deviation(covariance.diagonal().map(f64::sqrt).as_slice());
        if round > 0 && solution.stop.converged() && weights.is_near(problem.weights()) {
            break;
        }
        problem.reweigh(weights);
        let next = solve(&problem, &solution.x, ITERATIONS_PER_ROUND, control)?;
        let settled = settled(&problem, &solution.x, &next.x);
        solution = accumulate(solution, next);
        if settled || control.is_interrupted() {
            break;
        }
    }
    let last = search(&problem, &solution.x, ITERATION_LIMIT, control)?;
    Ok(Optimum {
        solution: accumulate(solution, last),
        problem,
    })
}

/// The weights that the scatter of the periods gives; `None` unless every recording is an average.
pub(in crate::estimate) fn weights_of_periods(
    problem: &FitProblem<'_>,
) -> Result<Option<Weights>, EstimateError> {
    let covariance = scatter_of_periods(problem.model, problem.recordings);
    covariance.map(|c| Weights::by_covariance(&c)).transpose()
}

/// Covariance of a row across channels that the scatter of the periods shows, pooled over the recordings by
/// their rows; `None` unless every recording is an average.
fn scatter_of_periods(model: &Model, recordings: &[&Prepared]) -> Option<DMatrix<f64>> {
    let mut sum: Option<DMatrix<f64>> = None;
    let mut rows = 0.0;
    for recording in recordings {
        let own = &recording.experiment.noise.as_ref()?.signal_covariance * recording.rows() as f64;
        sum = Some(match sum {
            Some(sum) => sum + own,
            None => own,
        });
        rows += recording.rows() as f64;
    }
    with_locked(model, sum? / rows)
}

/// The same with unit variance for channels that are not active; `None` where an active one never
/// scatters, as without noise.
fn with_locked(model: &Model, mut covariance: DMatrix<f64>) -> Option<DMatrix<f64>> {
    for (c, channel) in model.channels().iter().enumerate() {
        if !channel.active {
            covariance.row_mut(c).fill(0.0);
            covariance.column_mut(c).fill(0.0);
            covariance[(c, c)] = 1.0;
        }
    }
    let scatters = covariance.diagonal().iter().all(|v| *v > 0.0);
    (scatters && Cholesky::new(covariance.clone()).is_some()).then_some(covariance)
}

/// Probability with which one channel's residuals are called too large for their noise by chance.
const FALSE_DOUBT: f64 = 1e-3;

/// Whether the residuals of every channel are as small as the scatter of the periods says: F test of both
/// variances.
fn agrees(problem: &FitProblem<'_>, x: &DVector<f64>, scatter: &DMatrix<f64>) -> bool {
    let found = covariance_at(problem, x);
    let channels = problem.model.channels();
    let active = channels.iter().filter(|c| c.active).count().max(1);
    let rows = counting_rows(problem.recordings) as f64;
    let differences = |r: &&Prepared| r.experiment.noise.as_ref().map_or(0.0, |n| n.degrees);
    let ratio = Distribution::FisherF {
        numerator: (rows - x.len() as f64 / active as f64).max(1.0),
        denominator: problem
            .recordings
            .iter()
            .map(differences)
            .sum::<f64>()
            .max(1.0),
    };
    let most = ratio.upper_quantile(FALSE_DOUBT);
    (0..channels.len())
        .filter(|&c| channels[c].active)
        .all(|c| found[(c, c)] <= most * scatter[(c, c)])
}

fn settled(problem: &FitProblem<'_>, before: &DVector<f64>, after: &DVector<f64>) -> bool {
    let count = after.len();
    let whole = problem.factor(after).matrix();
    // ‖R d‖ is the change in units of the estimate's standard deviation (white residuals).
    let change = whole.view((0, 0), (count, count)) * (after - before);
    change.amax() <= ROUND_TOLERANCE
}
