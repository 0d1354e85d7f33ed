//! What a diagnosis has worked out once: fits by the hypotheses in them, and what each of them leads to.

use crate::diagnose::error::DiagnoseError;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::lead::Lead;
use crate::diagnose::refit::Refit;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Answers by the hypotheses of a model, in their order.
type Answers<T> = Mutex<Vec<(Vec<Hypothesis>, T)>>;

/// Fits and leads of one set of recordings.
#[derive(Debug, Default)]
pub struct Memory {
    refits: Answers<Refit>,
    leads: Answers<Vec<Lead>>,
    /// Hypotheses of models that were fitted from the optimum of a richer one, and the hypotheses of that.
    poorer: Mutex<Vec<(Vec<Hypothesis>, Vec<Hypothesis>)>>,
}

impl Memory {
    /// The fit of a model with hypotheses, made by `make` the first time.
    pub fn refit(
        &self,
        hypotheses: &[Hypothesis],
        make: impl FnOnce() -> Result<Refit, DiagnoseError>,
    ) -> Result<Refit, DiagnoseError> {
        recall(&self.refits, hypotheses, make)
    }

    /// The fit of a model with hypotheses that `make` makes from the optimum of a `richer` one, or the known one, of
    /// both the better: a law of friction that was once tried alone may have ended in a shallow optimum.
    pub fn refit_from(
        &self,
        (hypotheses, richer): (&[Hypothesis], &[Hypothesis]),
        make: impl FnOnce() -> Result<Refit, DiagnoseError>,
    ) -> Result<Refit, DiagnoseError> {
        let pair = (hypotheses.to_vec(), richer.to_vec());
        if open(&self.poorer).contains(&pair) {
            return recall(&self.refits, hypotheses, make);
        }
        let made = make()?;
        let known = recall(&self.refits, hypotheses, || Ok(made.clone()))?;
        let better = made.fitted_score() < known.fitted_score();
        if better {
            open(&self.refits).retain(|(of, _)| of != hypotheses);
            open(&self.refits).push((hypotheses.to_vec(), made.clone()));
            open(&self.leads).retain(|(of, _)| of != hypotheses);
        }
        open(&self.poorer).push(pair);
        Ok(if better { made } else { known })
    }

    /// What a model with hypotheses leads to, found by `make` the first time.
    pub fn leads(
        &self,
        hypotheses: &[Hypothesis],
        make: impl FnOnce() -> Result<Vec<Lead>, DiagnoseError>,
    ) -> Result<Vec<Lead>, DiagnoseError> {
        recall(&self.leads, hypotheses, make)
    }
}

fn recall<T: Clone>(
    answers: &Answers<T>,
    hypotheses: &[Hypothesis],
    make: impl FnOnce() -> Result<T, DiagnoseError>,
) -> Result<T, DiagnoseError> {
    let known = open(answers)
        .iter()
        .find(|(of, _)| of == hypotheses)
        .map(|(_, answer)| answer.clone());
    if let Some(answer) = known {
        return Ok(answer);
    }
    let answer = make()?;
    open(answers).push((hypotheses.to_vec(), answer.clone()));
    Ok(answer)
}

/// A list, also where a thread failed while it held it: entries are whole or absent.
fn open<T>(list: &Mutex<Vec<T>>) -> MutexGuard<'_, Vec<T>> {
    list.lock().unwrap_or_else(PoisonError::into_inner)
}
