//! Cache of fits and score tests, by the hypotheses of a model.

use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::candidate::Screening;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Answers by the hypotheses of a model, in their order.
type Answers<T> = Mutex<Vec<(Vec<Hypothesis>, T)>>;

/// Fits and screenings of one set of recordings.
#[derive(Debug, Default)]
pub struct FitCache {
    fits: Answers<ModelFit>,
    /// Fits from the first start of a search alone.
    first: Answers<ModelFit>,
    screenings: Answers<Screening>,
    /// Hypotheses of models that were fitted from the optimum of a richer one, and the hypotheses of that.
    poorer: Mutex<Vec<(Vec<Hypothesis>, Vec<Hypothesis>)>>,
}

impl FitCache {
    /// The fit of a model with hypotheses, made by `make` the first time.
    pub fn fit_model(
        &self,
        hypotheses: &[Hypothesis],
        make: impl FnOnce() -> Result<ModelFit, DiagnoseError>,
    ) -> Result<ModelFit, DiagnoseError> {
        recall(&self.fits, hypotheses, make)
    }

    /// The fit of a model with hypotheses from the first start of its search, made by `make` the first time; the whole search's
    /// where that was made.
    pub fn first_fit(
        &self,
        hypotheses: &[Hypothesis],
        make: impl FnOnce() -> Result<ModelFit, DiagnoseError>,
    ) -> Result<ModelFit, DiagnoseError> {
        match known(&self.fits, hypotheses) {
            Some(searched) => Ok(searched),
            None => recall(&self.first, hypotheses, make),
        }
    }

    /// Whether a model with hypotheses was fitted from every start that it needs.
    pub fn is_fitted(&self, hypotheses: &[Hypothesis]) -> bool {
        known(&self.fits, hypotheses).is_some()
    }

    /// The fit of a model with hypotheses that `make` makes from the optimum of a `richer` one, or the known one, of
    /// both the better: a law of friction that was once tried alone may have ended in a shallow optimum. What it leads
    /// to is found anew where it is better by more than `least`.
    pub fn fit_from(
        &self,
        hypotheses: &[Hypothesis],
        richer: &[Hypothesis],
        least: f64,
        make: impl FnOnce() -> Result<ModelFit, DiagnoseError>,
    ) -> Result<ModelFit, DiagnoseError> {
        let pair = (hypotheses.to_vec(), richer.to_vec());
        if open(&self.poorer).contains(&pair) {
            return recall(&self.fits, hypotheses, make);
        }
        let made = make()?;
        let known = recall(&self.fits, hypotheses, || Ok(made.clone()))?;
        let better = made.fitted_score() < known.fitted_score();
        if better {
            open(&self.fits).retain(|(of, _)| of != hypotheses);
            open(&self.fits).push((hypotheses.to_vec(), made.clone()));
            if known.fitted_score() - made.fitted_score() > least {
                open(&self.screenings).retain(|(of, _)| of != hypotheses);
            }
        }
        open(&self.poorer).push(pair);
        Ok(if better { made } else { known })
    }

    /// What a model with hypotheses leads to, found by `make` the first time.
    pub fn screening(
        &self,
        hypotheses: &[Hypothesis],
        make: impl FnOnce() -> Result<Screening, DiagnoseError>,
    ) -> Result<Screening, DiagnoseError> {
        recall(&self.screenings, hypotheses, make)
    }

    /// What is made `of` each model whose screening is known, in the order in which they were screened.
    pub fn of_screened<T>(&self, of: impl Fn(&ModelFit, &Screening) -> T) -> Vec<T> {
        let (fits, screenings) = (open(&self.fits), open(&self.screenings));
        let fitted = |hypotheses: &[Hypothesis]| {
            let (_, fit) = fits.iter().find(|(of, _)| of == hypotheses)?;
            Some(fit)
        };
        let known = screenings.iter();
        known
            .filter_map(|(hypotheses, screening)| Some(of(fitted(hypotheses)?, screening)))
            .collect()
    }
}

fn recall<T: Clone>(
    answers: &Answers<T>,
    hypotheses: &[Hypothesis],
    make: impl FnOnce() -> Result<T, DiagnoseError>,
) -> Result<T, DiagnoseError> {
    if let Some(answer) = known(answers, hypotheses) {
        return Ok(answer);
    }
    let answer = make()?;
    open(answers).push((hypotheses.to_vec(), answer.clone()));
    Ok(answer)
}

fn known<T: Clone>(answers: &Answers<T>, hypotheses: &[Hypothesis]) -> Option<T> {
    let answers = open(answers);
    let answer = answers.iter().find(|(of, _)| of == hypotheses);
    answer.map(|(_, answer)| answer.clone())
}

/// A list, also where a thread failed while it held it: entries are whole or absent.
fn open<T>(list: &Mutex<Vec<T>>) -> MutexGuard<'_, Vec<T>> {
    list.lock().unwrap_or_else(PoisonError::into_inner)
}
