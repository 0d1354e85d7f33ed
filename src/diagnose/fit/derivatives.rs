//! Derivatives of a fit over the rows that were fitted and over those that are held out, kept while several others are
//! compared with it.

use crate::chain::dataset::Prepared;
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::estimate::covariance::Sensitivity;
use nalgebra::DVector;
use std::sync::{Arc, Mutex, PoisonError};

/// Derivatives of one fit.
#[derive(Debug)]
pub struct Derivatives {
    /// What they say of the unknowns, over the fitted rows.
    pub fitted: Sensitivity,
    /// `[channel][unknown][row]` over the held-out rows; `None` where a channel does not depend on an unknown.
    pub held_out: Vec<Vec<Option<Vec<f64>>>>,
}

/// Fits whose derivatives are kept, those that were asked for last: the one that others are compared with, and one of these.
const KEPT: usize = 2;

/// With more rows they are not kept: those of sixty unknowns of seven joints take 100 MB.
const MOST_ROWS: usize = 30_000;

/// The latest derivatives.
#[derive(Debug, Default)]
pub struct DerivativesCache {
    latest: Mutex<Vec<Kept>>,
}

/// Derivatives of a model with hypotheses at values of its parameters.
#[derive(Debug)]
struct Kept {
    hypotheses: Vec<Hypothesis>,
    values: DVector<f64>,
    derivatives: Arc<Derivatives>,
}

impl Kept {
    fn is_of(&self, fit: &ModelFit) -> bool {
        self.hypotheses == fit.hypotheses && self.values == fit.values
    }
}

impl DerivativesCache {
    /// The derivatives of a fit over the rows that were fitted and those that are held out; `None` where they are not finite.
    pub fn of(
        &self,
        fit: &ModelFit,
        fitted: &[&Prepared],
        held_out: &[&Prepared],
    ) -> Option<Arc<Derivatives>> {
        if let Some(known) = self.known(fit) {
            return Some(known);
        }
        let problem = fit.problem(fitted);
        let sensitivity = Sensitivity::of(&problem, &fit.solution.x)?;
        let rows = fitted.iter().chain(held_out).map(|r| r.rows());
        let is_kept = rows.sum::<usize>() <= MOST_ROWS;
        let positions = fit.unknowns.positions();
        let series = ChannelSeries::of(&fit.model, &fit.values, &positions, held_out);
        let derivatives = Arc::new(Derivatives {
            fitted: match is_kept {
                true => sensitivity.with_derivatives(&problem),
                false => sensitivity,
            },
            held_out: series.columns,
        });
        if is_kept {
            self.keep(fit, &derivatives);
        }
        Some(derivatives)
    }

    fn known(&self, fit: &ModelFit) -> Option<Arc<Derivatives>> {
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let place = latest.iter().position(|kept| kept.is_of(fit))?;
        let known = latest.remove(place);
        let derivatives = Arc::clone(&known.derivatives);
        latest.push(known);
        Some(derivatives)
    }

    fn keep(&self, fit: &ModelFit, derivatives: &Arc<Derivatives>) {
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        latest.push(Kept {
            hypotheses: fit.hypotheses.clone(),
            values: fit.values.clone(),
            derivatives: Arc::clone(derivatives),
        });
        let surplus = latest.len().saturating_sub(KEPT);
        latest.drain(..surplus);
    }
}
