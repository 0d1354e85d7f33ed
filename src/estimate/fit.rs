//! One fit from recordings to everything that is reported of it.
//!
//! | estimator | weights | transition speeds w |
//! |---|---|---|
//! | ordinary | torque at joint scale counts the same on every channel | given, else 0 |
//! | weighted | every channel by the deviation of its residual, iterated | given, else 0 |
//! | robust | as weighted, and every residual by Tukey's biweight | given, else 0 |
//! | maximum likelihood | the inverse covariance of the residuals across channels, iterated | estimated |

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::{Channel, Model};
use crate::chain::parameter::Role;
use crate::chain::prior::Prior;
use crate::estimate::covariance::of_unknowns;
use crate::estimate::error::EstimateError;
use crate::estimate::figures::{Predictions, figures, predictions};
use crate::estimate::noise::{ResidualSeries, counting_rows, row_covariance};
use crate::estimate::physical::{Estimated, report};
use crate::estimate::problem::FitProblem;
use crate::estimate::realization;
use crate::estimate::unknowns::Unknowns;
use crate::estimate::weights::{RowFactors, Weights};
use crate::linalg::triangular::{ColumnScaling, Triangular};
use crate::outcome::estimate::{Estimate, Solver};
use crate::outcome::fit::{BaseParameter, Combination, Fit, Posterior, Realized, Term};
use crate::problem::form::{Form, Structure};
use crate::problem::solution::{Control, Solution};
use crate::problem::view::LeastSquares;
use crate::problem::{Problem, bounds};
use crate::recording::split::Split;
use crate::solve::{levenberg_marquardt, linear};
use crate::stats::distribution::Distribution;
use crate::stats::robust::{TUKEY_THRESHOLD, mad_scale, tukey_weight};
use nalgebra::{DMatrix, DVector};

/// How parameters follow from recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    Ordinary,
    Weighted,
    Robust,
    MaximumLikelihood,
}

/// A fit as it is reported, and what it predicts.
#[derive(Debug, Clone)]
pub struct Fitted {
    pub estimate: Estimate,
    pub fit: Fit,
    pub predictions: Predictions,
    /// The model with the transition speeds as the estimator took them.
    pub model: Model,
    /// Values of all parameters.
    pub values: DVector<f64>,
}

/// Rounds of reweighting after which the weights change nothing that matters any more.
const MAX_ROUNDS: usize = 20;

/// Reweighting ends when no unknown moves by more than this share of its standard deviation.
const ROUND_TOLERANCE: f64 = 1e-2;

/// Share of the cost that a search may leave. The cost is half the number of residuals, and half a unit of
/// it is a standard deviation: for 1e6 residuals the search ends within 0.03 of one.
const COST_TOLERANCE: f64 = 1e-9;

/// Iterations after which a search has failed.
const ITERATION_LIMIT: usize = 200;

/// Iterations between two estimates of the covariance: both converge together.
const ITERATIONS_PER_ROUND: usize = 5;

/// Fits a model to the training recordings of a dataset.
pub fn fit(
    model: &Model,
    data: &Dataset,
    (estimator, prior): (Estimator, &Prior),
    control: &Control<'_>,
) -> Result<Fitted, EstimateError> {
    let model = with_transition_speeds(model, estimator)?;
    let recordings: Vec<&Prepared> = data.of(Split::Train).collect();
    if recordings.is_empty() {
        return Err(EstimateError::NoTraining);
    }
    let unknowns = Unknowns::find(&model, data, prior);
    check_counts(&model, &unknowns, &recordings)?;
    let (solution, problem) = minimise(
        &model,
        &unknowns,
        (&recordings, prior),
        (estimator, control),
    )?;
    Ok(outcome(&problem, &solution, data))
}

/// Estimators without a nonlinear search take w as given, or 0.
fn with_transition_speeds(model: &Model, estimator: Estimator) -> Result<Model, EstimateError> {
    let mut model = model.clone();
    if estimator != Estimator::MaximumLikelihood {
        let widths: Vec<usize> = model.joints().iter().filter_map(|j| j.width).collect();
        for width in widths {
            if model.parameters()[width].is_free() {
                model.fix(width, 0.0)?;
            }
        }
    }
    Ok(model)
}

fn check_counts(
    model: &Model,
    unknowns: &Unknowns,
    recordings: &[&Prepared],
) -> Result<(), EstimateError> {
    let count = unknowns.positions().len();
    if count == 0 {
        return Err(EstimateError::NothingUnknown);
    }
    let active = model.channels().iter().filter(|c| c.active).count();
    let rows = counting_rows(recordings) * active;
    if rows <= count {
        return Err(EstimateError::TooFewRows {
            rows,
            unknowns: count,
        });
    }
    Ok(())
}

type Training<'a> = (&'a [&'a Prepared], &'a Prior);

fn minimise<'a>(
    model: &'a Model,
    unknowns: &'a Unknowns,
    training: Training<'a>,
    (estimator, control): (Estimator, &Control<'_>),
) -> Result<(Solution, FitProblem<'a>), EstimateError> {
    let ordinary = FitProblem::new(model, unknowns, training, ordinary_weights(model));
    let first = solve(&ordinary, &ordinary.start(), (ITERATION_LIMIT, control))?;
    if estimator == Estimator::Ordinary {
        let scale = residual_deviation(&ordinary, &first);
        let scaled = ordinary.weights.scaled(1.0 / scale);
        let problem = FitProblem::new(model, unknowns, training, scaled);
        return Ok((first, problem));
    }
    let covariance = covariance_at(&ordinary, &first.x);
    let deviations: Vec<f64> = covariance.diagonal().iter().map(|v| v.sqrt()).collect();
    let weighted = FitProblem::new(
        model,
        unknowns,
        training,
        Weights::by_deviation(&deviations),
    );
    let second = solve(&weighted, &first.x, (ITERATIONS_PER_ROUND, control))?;
    match estimator {
        Estimator::Robust => robust(weighted, second, control),
        _ => reweighted(weighted, second, (estimator, control)),
    }
}

/// One weight for the torque of every joint: currents count by their torque constants, and torques of
/// coupled motors as those of the joints that they move, `τ = V⁻ᵀ τ_M`.
fn ordinary_weights(model: &Model) -> Weights {
    let of = |c: &Channel| match c.joint {
        Some(j) if c.active => model.joints()[j].torque_constant.abs(),
        _ => 1.0,
    };
    let channels = model.channels();
    let factors = DVector::from_iterator(channels.len(), channels.iter().map(of));
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

/// Standard deviation of the weighted residual over all channels.
fn residual_deviation(problem: &FitProblem<'_>, solution: &Solution) -> f64 {
    let form: &Form = problem.form();
    let crate::problem::form::Objective::SumOfSquares { rows } = form.objective else {
        return 1.0;
    };
    let freedom = rows.saturating_sub(solution.x.len()).max(1) as f64;
    let deviation = (2.0 * solution.cost / freedom).sqrt();
    if deviation > 0.0 { deviation } else { 1.0 }
}

fn covariance_at(problem: &FitProblem<'_>, x: &DVector<f64>) -> DMatrix<f64> {
    row_covariance(problem.model, &problem.counted_residuals(x), x.len())
}

fn solve(
    problem: &FitProblem<'_>,
    start: &DVector<f64>,
    (max_iterations, control): (usize, &Control<'_>),
) -> Result<Solution, EstimateError> {
    let view = LeastSquares::try_from(problem as &dyn Problem)?;
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

/// Iteratively reweighted least squares: Tukey's biweight of every residual over its channel's robust scale.
fn robust<'a>(
    mut problem: FitProblem<'a>,
    mut solution: Solution,
    control: &Control<'_>,
) -> Result<(Solution, FitProblem<'a>), EstimateError> {
    for _ in 0..MAX_ROUNDS {
        let series = problem.counted_residuals(&solution.x);
        problem = problem.with_factors(biweights(&series));
        let next = solve(&problem, &solution.x, (ITERATION_LIMIT, control))?;
        let settled = settled(&problem, &solution.x, &next.x);
        solution = accumulate(solution, next);
        if settled {
            break;
        }
    }
    Ok((solution, problem))
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

/// Weights and optimum in turn until neither changes: the deviations of the residuals, or for maximum
/// likelihood with an unknown covariance all of it.
fn reweighted<'a>(
    mut problem: FitProblem<'a>,
    mut solution: Solution,
    (estimator, control): (Estimator, &Control<'_>),
) -> Result<(Solution, FitProblem<'a>), EstimateError> {
    for _ in 0..MAX_ROUNDS {
        let covariance = covariance_at(&problem, &solution.x);
        problem.weights = match estimator {
            Estimator::MaximumLikelihood => Weights::by_covariance(&covariance)?,
            _ => Weights::by_deviation(covariance.diagonal().map(f64::sqrt).as_slice()),
        };
        let next = solve(&problem, &solution.x, (ITERATIONS_PER_ROUND, control))?;
        let settled = settled(&problem, &solution.x, &next.x);
        solution = accumulate(solution, next);
        if settled || control.is_interrupted() {
            break;
        }
    }
    let last = solve(&problem, &solution.x, (ITERATION_LIMIT, control))?;
    Ok((accumulate(solution, last), problem))
}

fn settled(problem: &FitProblem<'_>, before: &DVector<f64>, after: &DVector<f64>) -> bool {
    let count = after.len();
    let whole = problem.factor(after).matrix();
    // ‖R d‖ is the change in units of the estimate's standard deviation (white residuals).
    let change = whole.view((0, 0), (count, count)) * (after - before);
    change.amax() <= ROUND_TOLERANCE
}

fn accumulate(before: Solution, after: Solution) -> Solution {
    Solution {
        iterations: before.iterations + after.iterations,
        evaluations: before.evaluations + after.evaluations,
        ..after
    }
}

fn outcome(problem: &FitProblem<'_>, solution: &Solution, data: &Dataset) -> Fitted {
    let (model, unknowns) = (problem.model, problem.unknowns);
    let values = problem.parameters(&solution.x);
    let count = solution.x.len();
    let covariance = of_unknowns(problem, &solution.x)
        .unwrap_or_else(|| DMatrix::from_diagonal_element(count, count, f64::INFINITY));
    let from_prior = determined_by_prior(problem, data);
    let at_bound: Vec<usize> = (0..count)
        .filter(|&k| bounds::side_of(&problem.form().variables[k], solution.x[k]).is_some())
        .collect();
    let estimated = Estimated {
        model,
        unknowns,
        values: &values,
        covariance: &covariance,
        from_prior: &from_prior,
        at_bound: &at_bound,
    };
    let (parameters, reported_covariance) = report(&estimated);
    let predicted = predictions(model, &values, data);
    let member = realization::find(model, unknowns, &values);
    let factor = Triangular::of(
        &problem
            .factor(&solution.x)
            .matrix()
            .columns(0, count)
            .into_owned(),
    );
    let fit = Fit {
        base_parameters: base_parameters(problem, &solution.x, &covariance),
        rank: count,
        condition_number: factor.condition_number(ColumnScaling::UnitNorm),
        feasible: member.as_ref().map(|m| m.feasible),
        min_pseudo_inertia_eigenvalue: member.as_ref().map(|m| m.smallest_eigenvalue),
        realization: member.map_or_else(Vec::new, |m| named(model, &m.values)),
        posterior: posterior(problem, &solution.x, &covariance),
        ..Fit::default()
    };
    let estimate = Estimate {
        parameters,
        joints: figures(model, &values, (data, &predicted)),
        covariance: reported_covariance,
        solver: Some(Solver {
            name: solver_name(problem).to_string(),
            stop: solution.stop.name().to_string(),
            converged: solution.stop.converged(),
            iterations: solution.iterations as u64,
            evaluations: solution.evaluations as u64,
            cost: solution.cost,
        }),
    };
    Fitted {
        estimate,
        fit,
        predictions: predicted,
        model: model.clone(),
        values,
    }
}

fn solver_name(problem: &FitProblem<'_>) -> &'static str {
    match problem.form().structure {
        Structure::Affine => "QR",
        Structure::Smooth => "Levenberg-Marquardt",
    }
}

/// Unknowns that the recordings alone do not determine.
fn determined_by_prior(problem: &FitProblem<'_>, data: &Dataset) -> Vec<usize> {
    if problem.prior.is_empty() {
        return Vec::new();
    }
    let model = problem.model;
    let alone = Unknowns::find(model, data, &Prior::none(model.parameters().len()));
    let kept = alone.base.kept();
    let positions = problem.unknowns.base.kept();
    (0..positions.len())
        .filter(|&k| {
            let same = alone.base.base.iter().find(|b| b.parameter == positions[k]);
            !kept.contains(&positions[k])
                || same.is_some_and(|b| b.others.len() > problem.unknowns.base.base[k].others.len())
        })
        .collect()
}

fn base_parameters(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
    covariance: &DMatrix<f64>,
) -> Vec<BaseParameter> {
    let (model, base) = (problem.model, &problem.unknowns.base);
    let quantile = Distribution::Normal.two_sided(0.95);
    (0..base.base.len())
        .map(|k| {
            let std_dev = covariance[(k, k)].max(0.0).sqrt();
            let half = quantile * std_dev;
            BaseParameter {
                expression: base.expression(model, k),
                unit: model.parameters()[base.base[k].parameter].unit.clone(),
                value: Some(x[k]),
                std_dev: Some(std_dev),
                ci95: Some([x[k] - half, x[k] + half]),
            }
        })
        .collect()
}

fn posterior(problem: &FitProblem<'_>, x: &DVector<f64>, covariance: &DMatrix<f64>) -> Posterior {
    let name = |p: usize| problem.model.parameters()[p].name.clone();
    let base = problem.unknowns.base.base.iter().map(|b| {
        let own = (b.parameter, 1.0);
        let terms = std::iter::once(&own).chain(&b.others);
        terms
            .map(|&(p, coefficient)| Term {
                parameter: name(p),
                coefficient,
            })
            .collect::<Vec<_>>()
    });
    let single = problem.unknowns.nonlinear.iter().map(|&p| {
        vec![Term {
            parameter: name(p),
            coefficient: 1.0,
        }]
    });
    let combinations = base.chain(single).zip(x.iter());
    Posterior {
        combinations: combinations
            .map(|(terms, value)| Combination {
                terms,
                value: *value,
            })
            .collect(),
        covariance: covariance
            .row_iter()
            .map(|row| row.iter().copied().collect())
            .collect(),
    }
}

/// Inertial parameters of a member of the class, by their raw names.
fn named(model: &Model, values: &DVector<f64>) -> Vec<Realized> {
    let inertial = model
        .parameters()
        .iter()
        .enumerate()
        .filter(|(_, p)| matches!(p.role, Role::Inertial { .. } | Role::Payload { .. }));
    inertial
        .map(|(k, p)| Realized {
            name: p.name.clone(),
            value: values[k],
        })
        .collect()
}
