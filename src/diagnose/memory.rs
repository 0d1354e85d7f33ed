//! What a diagnosis has worked out once: fits by the hypotheses in them, and what each of them leads to.

use crate::diagnose::error::DiagnoseError;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::refit::Refit;
use crate::diagnose::screen::Lead;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Answers by the hypotheses of a model, in their order.
type Answers<T> = Mutex<Vec<(Vec<Hypothesis>, T)>>;

/// Fits and leads of one set of recordings.
#[derive(Debug, Default)]
pub struct Memory {
    refits: Answers<Refit>,
    leads: Answers<Vec<Lead>>,
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

/// The list, also where a thread failed while it held it: entries are whole or absent.
fn open<T>(answers: &Answers<T>) -> MutexGuard<'_, Vec<(Vec<Hypothesis>, T)>> {
    answers.lock().unwrap_or_else(PoisonError::into_inner)
}
