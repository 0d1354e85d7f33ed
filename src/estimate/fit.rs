//! A fit: estimation, covariance, and everything that is reported of it.
//!
//! | estimator | weights |
//! |---|---|
//! | ordinary | torque at joint scale counts the same on every channel |
//! | weighted | every channel by the deviation of its residual, iterated |
//! | robust | as weighted, and every residual by Tukey's biweight |
//! | maximum likelihood | the inverse covariance across channels by the scatter of periods, else as weighted |
//!
//! All of them estimate the transition speed w of `sign(v) = v/(|v| + w)` together with the rest where it is not given:
//! a w of zero in place of the true one biases Coulomb friction by many of its standard deviations.

use crate::chain::base_parameters::scan_order;
use crate::chain::dataset::Dataset;
use crate::chain::model::{JointModel, Model};
use crate::chain::parameter::{Parameter, Role};
use crate::chain::prior::Prior;
use crate::estimate::derived::goodness_of_fit::{Predictions, figures, predictions};
use crate::estimate::derived::physical::{Estimated, PhysicalEstimate, report};
use crate::estimate::derived::realization;
use crate::estimate::error::EstimateError;
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::fit_problem::problem::{FitProblem, NoiseSource};
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::estimate::minimisation::fit_setup::FitSetup;
use crate::estimate::minimisation::optimum::Optimum;
use crate::estimate::minimisation::run_away;
use crate::estimate::uncertainty::covariance::of_unknowns;
use crate::estimate::uncertainty::{gain_intervals, ratios, torque_constants};
use crate::linalg::triangular::{ColumnScaling, Triangular};
use crate::outcome::estimate::{Estimate, Solver};
use crate::outcome::fit::{
    BaseParameter, Combination, Fit, FittedModel, Posterior, Realized, Term,
};
use crate::problem::form::Structure;
use crate::problem::solution::{Control, Solution};
use crate::problem::{Problem, bounds};
use crate::stats::distribution::Distribution;
use nalgebra::{DMatrix, DVector};

/// A fit as it is reported, and what it predicts.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Parameters, errors and covariance, as results have them.
    pub estimate: Estimate,
    /// Base parameters and what else the verb adds to a result.
    pub fit: Fit,
    /// What the model predicts of every recording.
    pub predictions: Predictions,
    /// The model, transition speeds and limits as the fit had them.
    pub model: Model,
    /// Values of all parameters.
    pub values: DVector<f64>,
}

/// Fits a model to the training recordings of a dataset.
pub fn fit(
    model: &Model,
    data: &Dataset,
    estimator: Estimator,
    prior: &Prior,
    control: &Control<'_>,
) -> Result<Fitted, EstimateError> {
    let mut setup = FitSetup::of(model, data, prior)?;
    let Optimum { solution, problem } = setup.minimisation(estimator, control).run()?;
    let lost = run_away::unknowns(&problem, &solution.x);
    if lost.is_empty() {
        return Ok(outcome(&problem, &solution, data));
    }
    let stayed = (0..solution.x.len()).filter(|k| !lost.contains(k));
    let near: Vec<f64> = stayed.map(|k| solution.x[k]).collect();
    setup.unknowns = setup.unknowns.without(&lost);
    let minimisation = setup.minimisation(estimator, control);
    let Optimum { solution, problem } = minimisation.near(DVector::from_vec(near))?;
    Ok(outcome(&problem, &solution, data))
}

/// Everything that is reported of a fit at its optimum.
pub fn outcome(problem: &FitProblem<'_>, solution: &Solution, data: &Dataset) -> Fitted {
    let covariance = of_unknowns(problem, &solution.x);
    outcome_with(problem, solution, covariance, data)
}

/// The same where the covariance is known: `covariance` is that of the unknowns, absent where the
/// derivatives do not determine them all.
pub fn outcome_with(
    problem: &FitProblem<'_>,
    solution: &Solution,
    covariance: Option<DMatrix<f64>>,
    data: &Dataset,
) -> Fitted {
    let (model, unknowns) = (problem.model, problem.unknowns);
    let values = problem.parameters(&solution.x);
    let count = solution.x.len();
    let covariance =
        covariance.unwrap_or_else(|| DMatrix::from_diagonal_element(count, count, f64::INFINITY));
    let stated: Vec<f64> = model
        .joints()
        .iter()
        .map(|j| j.torque_constant_std)
        .collect();
    let of_constants = torque_constants::covariance(problem, &solution.x, &stated);
    let total = match &of_constants {
        Some(of_constants) => &covariance + of_constants,
        None => covariance.clone(),
    };
    let open = ratios::find(problem, &solution.x, &total);
    let marked = ratios::without_scaled(total.clone(), &open);
    let intervals = gain_intervals::find(problem, &solution.x, &marked);
    let from_prior = determined_by_prior(problem, data);
    let at_bound: Vec<usize> = (0..count)
        .filter(|&k| bounds::side_of(&problem.form().variables[k], solution.x[k]).is_some())
        .collect();
    let estimated = Estimated {
        model,
        unknowns,
        values: &values,
        covariance: &marked,
        statistical: of_constants.as_ref().map(|_| &covariance),
        from_prior: &from_prior,
        at_bound: &at_bound,
        intervals: &intervals,
    };
    let PhysicalEstimate {
        parameters,
        covariance: reported_covariance,
    } = report(&estimated);
    let predicted = predictions(model, &values, data);
    let member = realization::find(model, unknowns, &values);
    let nearest = match &member {
        Some(member) if !member.feasible => {
            realization::nearest(model, unknowns, &values, &covariance)
        }
        _ => None,
    };
    let fit = Fit {
        base_parameters: ratios::in_ratio(
            base_parameters(problem, &solution.x, &total, &intervals),
            problem,
            &total,
            &open,
        ),
        rank: count,
        unknowns: unknown_count(model),
        notes: noise_note(problem)
            .into_iter()
            .chain(load_from_currents(problem, &solution.x, &estimated))
            .chain(ratios::notes(model, &open, &unknowns.positions()))
            .collect(),
        condition_number: condition_number(problem, &solution.x),
        feasible: member.as_ref().map(|m| m.feasible),
        min_pseudo_inertia_eigenvalue: member.as_ref().map(|m| m.smallest_eigenvalue),
        nearest: nearest.map_or_else(Vec::new, |values| in_full(model, &values).values),
        realization: member.map_or_else(Vec::new, |m| named(model, &m.values)),
        posterior: posterior(problem, &solution.x, &marked),
        ..Fit::default()
    };
    let estimate = Estimate {
        parameters,
        joints: figures(model, &values, data, &predicted),
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

/// A model at values of its parameters as a result keeps it, beside what its problem declares.
pub fn in_full(model: &Model, values: &DVector<f64>) -> FittedModel {
    let of = |(parameter, value): (&Parameter, &f64)| Realized {
        name: parameter.name.clone(),
        value: *value,
    };
    FittedModel {
        added: Vec::new(),
        values: model
            .parameters()
            .iter()
            .zip(values.iter())
            .map(of)
            .collect(),
    }
}

/// Condition number of the derivatives at x with columns of unit norm.
fn condition_number(problem: &FitProblem<'_>, x: &DVector<f64>) -> f64 {
    let whole = problem.factor(x).matrix();
    let own = whole.columns(0, x.len()).into_owned();
    Triangular::of(&own).condition_number(ColumnScaling::UnitNorm)
}

/// Parameters that are not known, of joints that move.
pub(crate) fn unknown_count(model: &Model) -> usize {
    let moves = |p: &usize| match model.parameters()[*p].role {
        Role::Effect { joint, .. } => !model.joints()[joint].locked,
        Role::Coupling { row, .. } => !model.joints()[row].locked,
        _ => true,
    };
    let linear = scan_order(model).into_iter();
    let all = 0..model.parameters().len();
    let nonlinear = all.filter(|&p| model.parameters()[p].is_nonlinear_unknown());
    linear.chain(nonlinear).filter(moves).count()
}

/// Says where the weights come from if not from the residuals, as usual.
fn noise_note(problem: &FitProblem<'_>) -> Vec<String> {
    match problem.noise {
        NoiseSource::Residuals => Vec::new(),
        NoiseSource::Periods => vec![
            "The covariance across channels is that of the period averages, from the scatter of the periods; the \
             residuals agree with it."
                .to_string(),
        ],
    }
}

/// Says how uncertain the mass of a load is by the torque constants, where nothing is stated of these.
fn load_from_currents(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
    estimated: &Estimated<'_>,
) -> Option<String> {
    let model = problem.model;
    model.payload()?;
    let is_stated = |j: &JointModel| j.torque_constant_std > 0.0;
    if model.joints().iter().any(is_stated) {
        return None;
    }
    let assumed = vec![torque_constants::OF_DATA_SHEETS; model.joints().len()];
    let of_constants = torque_constants::covariance(problem, x, &assumed)?;
    let PhysicalEstimate { parameters, .. } = report(&Estimated {
        covariance: &(estimated.covariance + of_constants),
        ..*estimated
    });
    let mass = parameters.iter().find(|p| p.name == "payload.mass")?;
    let (value, std_dev, [low, high]) = (mass.value?, mass.std_dev?, mass.ci95?);
    Some(format!(
        "A load from currents is as uncertain as the torque constants, and its intervals leave that out. With constants \
         known to {:.0} %, as data sheets give them (95 % within ±10 %), its mass is {value:.3} kg ± {std_dev:.3} (95 %: \
         {low:.3} to {high:.3}); `drive.torque_constant_std` states how well they are known, and is then part of every \
         interval.",
        100.0 * torque_constants::OF_DATA_SHEETS
    ))
}

fn solver_name(problem: &FitProblem<'_>) -> &'static str {
    match problem.form().structure {
        Structure::Affine => "QR",
        Structure::Smooth => "Levenberg-Marquardt",
    }
}

/// Unknowns that the recordings alone do not determine.
pub(crate) fn determined_by_prior(problem: &FitProblem<'_>, data: &Dataset) -> Vec<usize> {
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

pub(crate) fn base_parameters(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
    covariance: &DMatrix<f64>,
    intervals: &[Option<[f64; 2]>],
) -> Vec<BaseParameter> {
    let (model, base) = (problem.model, &problem.unknowns.base);
    let quantile = Distribution::Normal.two_sided(0.95);
    (0..base.base.len())
        .map(|k| {
            let std_dev = covariance[(k, k)].max(0.0).sqrt();
            let half = quantile * std_dev;
            let own = intervals.get(k).copied().flatten();
            BaseParameter {
                expression: base.expression(model, k),
                unit: model.parameters()[base.base[k].parameter].unit.clone(),
                value: Some(x[k]),
                std_dev: Some(std_dev),
                ci95: Some(own.unwrap_or([x[k] - half, x[k] + half])),
            }
        })
        .collect()
}

pub(crate) fn posterior(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
    covariance: &DMatrix<f64>,
) -> Posterior {
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
    let mut combinations: Vec<Combination> = combinations
        .map(|(terms, value)| Combination {
            terms,
            value: *value,
        })
        .collect();
    // A later model may have for every joint what is shared here: it is known of each of them.
    let mut places: Vec<usize> = (0..x.len()).collect();
    for (k, &p) in problem.unknowns.positions().iter().enumerate() {
        for &other in problem.model.sharing(p).iter().skip(1) {
            let mut terms = combinations[k].terms.clone();
            terms[0].parameter = name(other);
            let value = x[k];
            combinations.push(Combination { terms, value });
            places.push(k);
        }
    }
    Posterior {
        combinations,
        covariance: places
            .iter()
            .map(|&i| places.iter().map(|&j| covariance[(i, j)]).collect())
            .collect(),
    }
}

/// Inertial parameters of a member of the class, by their raw names.
pub(crate) fn named(model: &Model, values: &DVector<f64>) -> Vec<Realized> {
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
