//! What a fit is of: a model, its training recordings, and the unknowns that these determine.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::chain::prior::Prior;
use crate::estimate::error::EstimateError;
use crate::estimate::fit_problem::estimator::{Estimator, Training};
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::estimate::minimisation::minimise::Minimisation;
use crate::estimate::residual::noise::counting_rows;
use crate::problem::solution::Control;
use crate::recording::split::Split;

/// A model with recordings to be fitted to.
pub(in crate::estimate) struct FitSetup<'a> {
    model: &'a Model,
    prior: &'a Prior,
    recordings: Vec<&'a Prepared>,
    /// What is estimated, and in which order.
    pub unknowns: Unknowns,
}

impl<'a> FitSetup<'a> {
    /// A model with the training recordings of a dataset.
    ///
    /// # Errors
    /// No such recordings, nothing unknown, or no more rows than unknowns.
    pub fn of(
        model: &'a Model,
        data: &'a Dataset,
        prior: &'a Prior,
    ) -> Result<Self, EstimateError> {
        let recordings: Vec<&Prepared> = data.of(Split::Train).collect();
        if recordings.is_empty() {
            return Err(EstimateError::NoTraining);
        }
        let unknowns = Unknowns::find(model, data, prior);
        let count = unknowns.positions().len();
        if count == 0 {
            return Err(EstimateError::NothingUnknown);
        }
        let active = model.channels().iter().filter(|c| c.active).count();
        let rows = counting_rows(&recordings) * active;
        if rows <= count {
            return Err(EstimateError::TooFewRows {
                rows,
                unknowns: count,
            });
        }
        Ok(Self {
            model,
            prior,
            recordings,
            unknowns,
        })
    }

    /// The same by an estimator.
    pub fn minimisation<'b>(
        &'b self,
        estimator: Estimator,
        control: &'b Control<'b>,
    ) -> Minimisation<'b, 'b> {
        Minimisation {
            model: self.model,
            unknowns: &self.unknowns,
            training: Training {
                recordings: &self.recordings,
                prior: self.prior,
            },
            estimator,
            control,
        }
    }
}
