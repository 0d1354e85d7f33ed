//! Priors of a problem file: an earlier fit, and single values with their uncertainty.

use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::chain::prior::Prior;
use crate::outcome::fit::Posterior;
use crate::outcome::{Outcome, Part};
use crate::problem_file::ProblemFile;
use crate::problem_file::choices::Inertials;
use crate::setup::controllers;
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::known::single;
use crate::setup::robot::Robot;
use nalgebra::{DMatrix, DVector};

/// The prior of a problem file; values of an earlier fit go into the model as starts, or as known values
/// where the inertials are known.
pub fn build(problem: &ProblemFile, robot: &Robot, model: &mut Model) -> Result<Prior, SetupError> {
    let mut prior = Prior::none(model.parameters().len());
    if let Some(path) = &problem.robot.parameters {
        let earlier =
            Outcome::read(&path.resolved).map_err(|e| SetupError::Earlier(Box::new(e)))?;
        let Part::Fit(fit) = &earlier.part else {
            return Err(SetupError::mismatch(&path.place, Mismatch::NotAFit));
        };
        take_values(
            model,
            &fit.posterior,
            problem.robot.inertials.value == Inertials::Known,
        );
        prior = prior.and(from_posterior(model, &fit.posterior));
    }
    let single = single_values(problem, model)?;
    let gains = controllers::prior(problem, robot, model)?;
    Ok(prior.and(single).and(gains))
}

/// Values of the earlier fit: starts of free parameters, or known inertials.
fn take_values(model: &mut Model, posterior: &Posterior, known: bool) {
    for combination in &posterior.combinations {
        for (position, term) in combination.terms.iter().enumerate() {
            // The first term of a combination carries its value; what it stands for is zero.
            let value = if position == 0 {
                combination.value
            } else {
                0.0
            };
            let Ok(parameter) = model.find(&term.parameter) else {
                continue;
            };
            let inertial = matches!(model.parameters()[parameter].role, Role::Inertial { .. });
            if known && inertial {
                // Raw inertial parameters have no bounds that a value could miss.
                let _ = model.fix(parameter, value);
            } else if position == 0 {
                model.start(parameter, value);
            }
        }
    }
}

/// The combinations of the earlier fit whose parameters this model has and does not know.
fn from_posterior(model: &Model, posterior: &Posterior) -> Prior {
    let count = model.parameters().len();
    let mut rows: Vec<(usize, DVector<f64>, f64)> = Vec::new();
    for (index, combination) in posterior.combinations.iter().enumerate() {
        let mut row = DVector::zeros(count);
        let mut mean = combination.value;
        let mut complete = true;
        let mut free = false;
        for term in &combination.terms {
            match model.find(&term.parameter).map(|p| model.estimated_as(p)) {
                Ok(p) if model.parameters()[p].is_free() => {
                    row[p] += term.coefficient;
                    free = true;
                }
                Ok(p) => mean -= term.coefficient * model.parameters()[p].value,
                Err(_) => complete = false,
            }
        }
        // What the earlier fit left open says nothing.
        if complete && free && posterior.covariance[index][index].is_finite() {
            rows.push((index, row, mean));
        }
    }
    let size = rows.len();
    let covariance = DMatrix::from_fn(size, size, |i, j| {
        posterior.covariance[rows[i].0][rows[j].0]
    });
    let combinations = DMatrix::from_fn(size, count, |i, p| rows[i].1[p]);
    let mean = DVector::from_fn(size, |i, _| rows[i].2);
    Prior::new(&combinations, &mean, &covariance)
}

/// `[fit.prior.values]`: parameters of effects and masses.
fn single_values(problem: &ProblemFile, model: &Model) -> Result<Prior, SetupError> {
    let given = &problem.fit.prior.values;
    let count = model.parameters().len();
    let mut rows = DMatrix::zeros(given.len(), count);
    let mut mean = DVector::zeros(given.len());
    let mut covariance = DMatrix::zeros(given.len(), given.len());
    for (k, entry) in given.iter().enumerate() {
        let place = &entry.value.place;
        let instead = "give priors of masses and of parameters of effects; an earlier fit under \
                       `robot.parameters` carries all of a body";
        let parameter = single(model, &entry.name, place, "a prior", instead)?;
        rows[(k, model.estimated_as(parameter))] = 1.0;
        mean[k] = entry.value.value.value;
        covariance[(k, k)] = entry.value.value.std_dev.powi(2);
    }
    Ok(Prior::new(&rows, &mean, &covariance))
}
