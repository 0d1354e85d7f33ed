//! The load as the difference of two fits of the link that carries it (Gilbert, Maina and Byiringiro 2024,
//! Table 5 and what follows it).
//!
//! The first fit is of the recordings without the load. In the second, of those with it, everything but the ten
//! parameters of that link stays as it was, and what they change by is the load δ:
//!
//! ```text
//! δ̂ = argmin ‖W (s − ŝ(β̂) − F δ)‖²,   C = C_δ + G C_β Gᵀ,   G = (FᵀWᵀW F)⁻¹ FᵀWᵀW Y
//! ```
//!
//! with the derivatives F and Y of the second recordings with respect to δ and to the unknowns β of the first fit,
//! whose covariance C_β the second one inherits. The estimate of everything from all recordings together weighs both
//! at once and is the more accurate one; this one needs no recording with and without the load to be fitted anew.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::chain::prior::Prior;
use crate::estimate::derived::goodness_of_fit::{figures, predictions};
use crate::estimate::error::EstimateError;
use crate::estimate::fit::{self, Fitted};
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::minimisation::fit_setup::FitSetup;
use crate::estimate::minimisation::optimum::Optimum;
use crate::estimate::uncertainty::covariance::of_unknowns;
use crate::outcome::estimate::Estimate;
use crate::outcome::parameter::Parameter;
use crate::problem::solution::{Control, Solution};
use crate::recording::split::Split;
use crate::stats::range::within;
use nalgebra::DMatrix;

/// Prefix of the names of a load's parameters.
const OWNER: &str = "payload.";

/// The recordings without the load, for the first fit.
///
/// # Errors
/// No load in the model, or no training recordings of one of both kinds.
pub fn without_load(model: &Model, data: &Dataset) -> Result<Dataset, EstimateError> {
    if model.payload().is_none() || data.loads().len() != 2 {
        return Err(EstimateError::NoDifference);
    }
    Ok(only(data, false))
}

/// Training recordings with the load, or without; every other recording.
fn only(data: &Dataset, loaded: bool) -> Dataset {
    let keep = |r: &&Prepared| r.split != Split::Train || r.loaded == loaded;
    Dataset {
        recordings: data.recordings.iter().filter(keep).cloned().collect(),
    }
}

/// The second fit and the difference, on top of the first.
pub fn second(
    first: Fitted,
    data: &Dataset,
    estimator: Estimator,
    control: &Control<'_>,
) -> Result<Fitted, EstimateError> {
    let loaded = only(data, true);
    let model = all_but_load_known(&first)?;
    let prior = Prior::none(model.parameters().len());
    let setup = FitSetup::of(&model, &loaded, &prior)?;
    let Optimum { solution, problem } = setup.minimisation(estimator, control).run()?;
    let inherited = inherited(&first, &problem, &solution);
    let covariance = of_unknowns(&problem, &solution.x).map(|own| own + inherited);
    let load = fit::outcome_with(&problem, &solution, covariance, &loaded);
    Ok(joined(first, load, data))
}

/// The model with everything but the load as the first fit has it.
fn all_but_load_known(first: &Fitted) -> Result<Model, EstimateError> {
    let mut model = first.model.clone();
    for k in 0..model.parameters().len() {
        let parameter = &model.parameters()[k];
        if parameter.is_free() && !matches!(parameter.role, Role::Payload { .. }) {
            let value = within(first.values[k], [parameter.lower, parameter.upper]);
            model.fix(k, value)?;
        }
    }
    Ok(model)
}

/// `G C_β Gᵀ`: what the uncertainty of the first fit does to the difference.
fn inherited(first: &Fitted, problem: &FitProblem<'_>, solution: &Solution) -> DMatrix<f64> {
    let posterior = &first.fit.posterior;
    let leading = posterior.combinations.iter().enumerate();
    let (rows, columns): (Vec<usize>, Vec<usize>) = leading
        .filter_map(|(row, combination)| {
            let name = &combination.terms.first()?.parameter;
            let finite = posterior.covariance[row][row].is_finite();
            Some((row, first.model.position(name).filter(|_| finite)?))
        })
        .unzip();
    let count = solution.x.len();
    let factor = problem.factor_over(&solution.x, &columns).matrix();
    let own = factor.view((0, 0), (count, count));
    let across = factor.view((0, count), (count, columns.len())).into_owned();
    let Some(gain) = own.solve_upper_triangular(&across) else {
        return DMatrix::from_diagonal_element(count, count, f64::INFINITY);
    };
    let covariance = DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
        posterior.covariance[rows[i]][rows[j]]
    });
    &gain * covariance * gain.transpose()
}

/// The first fit with the load of the second, and the errors of both together.
fn joined(first: Fitted, load: Fitted, data: &Dataset) -> Fitted {
    let is_load = |p: &&Parameter| p.name.starts_with(OWNER);
    let others = first.estimate.parameters.iter().filter(|p| !is_load(p));
    let own = load.estimate.parameters.iter().filter(is_load);
    let parameters: Vec<Parameter> = others.chain(own).cloned().collect();
    let values = load.values.clone();
    let predicted = predictions(&first.model, &values, data);
    let mut fit = first.fit;
    fit.rank += load.fit.rank;
    fit.unknowns = fit::unknown_count(&first.model);
    fit.base_parameters.extend(load.fit.base_parameters);
    fit.posterior = fit.posterior.and(load.fit.posterior);
    fit.realization = fit::named(&first.model, &values);
    fit.notes.push(
        "The load is the difference of two fits of its link, everything else as the recordings without it have it; \
         its intervals hold the uncertainty of both."
            .to_string(),
    );
    Fitted {
        estimate: Estimate {
            parameters,
            joints: figures(&first.model, &values, data, &predicted),
            covariance: first.estimate.covariance.and(load.estimate.covariance),
            solver: first.estimate.solver,
        },
        fit,
        predictions: predicted,
        model: first.model,
        values,
    }
}
