//! Priors of a problem file: an earlier fit, and single values with their uncertainty.

use crate::chain::model::{Model, Signal};
use crate::chain::parameter::Role;
use crate::chain::prior::Prior;
use crate::outcome::fit::Posterior;
use crate::problem_file::choices::Inertials;
use crate::problem_file::fit::PriorValue;
use crate::problem_file::{Named, ProblemFile};
use crate::setup::controllers::{self, JointGains};
use crate::setup::earlier_fit::EarlierFit;
use crate::setup::error::SetupError;
use crate::setup::known::single;
use crate::setup::purpose::Purpose;
use crate::setup::robot::Robot;
use crate::setup::signal::signal;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// What is known of parameters before a fit.
#[derive(Debug, Clone, Default)]
pub(super) struct PriorSpec {
    /// An earlier fit, whose values go into the model as starts, or as known values where the inertials are known.
    earlier: Option<Arc<Posterior>>,
    known_inertials: bool,
    /// Single parameters.
    values: Vec<Named<PriorValue>>,
    /// Gains of position controllers.
    gains: Vec<JointGains>,
}

impl PriorSpec {
    /// The prior of a problem file.
    ///
    /// # Errors
    /// An earlier result that cannot be read, or is none of a fit.
    pub(super) fn of(problem: &ProblemFile, robot: &Robot) -> Result<Self, SetupError> {
        let path = problem.robot.parameters.as_ref();
        let earlier = path.map(EarlierFit::read).transpose()?;
        Ok(Self {
            earlier: earlier.map(|earlier| Arc::new(earlier.fit.posterior)),
            known_inertials: problem.robot.inertials.value == Inertials::Known,
            values: problem.fit.prior.values.clone(),
            gains: match signal(problem, Purpose::Estimation) {
                Signal::PositionCommand => controllers::declared(problem, robot)?,
                _ => Vec::new(),
            },
        })
    }

    /// The prior of a model's parameters, which take the values of an earlier fit.
    ///
    /// # Errors
    /// Names that no single parameter has.
    pub(super) fn build(&self, model: &mut Model) -> Result<Prior, SetupError> {
        let mut prior = Prior::none(model.parameters().len());
        if let Some(earlier) = &self.earlier {
            take_values(model, earlier, self.known_inertials);
            prior = prior.and(from_posterior(model, earlier));
        }
        let single = single_values(&self.values, model)?;
        Ok(prior
            .and(single)
            .and(controllers::prior(&self.gains, model)))
    }
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
            let Some(parameter) = model.position(&term.parameter) else {
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
fn single_values(given: &[Named<PriorValue>], model: &Model) -> Result<Prior, SetupError> {
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
