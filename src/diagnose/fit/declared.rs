//! The declared model of a diagnosis, with the transitions and the noise that the recordings tell.

use crate::chain::dataset::Prepared;
use crate::chain::model::Model;
use crate::chain::transition_limits::{TransitionFit, TransitionLimits};
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::contexts::HeldOutHalves;
use crate::diagnose::fit::fitting::fit_declared;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::estimate::goodness_of_fit::noise_rms;
use crate::problem::solution::Control;
use crate::recording::split::Split;
use crate::setup::model_spec::ModelSpec;
use nalgebra::DVector;

/// The declared model, fitted.
pub struct Declared {
    /// The fit.
    pub fit: ModelFit,
    /// Of the transition speeds of all models.
    pub limits: TransitionLimits,
    /// RMS noise of one row per channel; `None` where nothing repeats.
    pub noise: Option<Vec<f64>>,
}

impl Declared {
    /// Fits the declared model to the recordings that are not held out.
    ///
    /// # Errors
    /// Those of building and fitting the model.
    pub fn fit(
        declared: &ModelSpec,
        halves: &HeldOutHalves,
        control: &Control<'_>,
    ) -> Result<Self, DiagnoseError> {
        let settled = TransitionLimits::of(&halves.whole).settle(control, |limits| {
            let mut contexts = halves.contexts(declared, control);
            contexts.set(limits, None);
            let fit = fit_declared(&contexts.selection)?;
            Ok::<_, DiagnoseError>(Attempt { fit, halves })
        })?;
        let fit = settled.fit.fit;
        let noise = noise_rms(&fit.model, &fit.values, &halves.whole);
        Ok(Self {
            fit,
            limits: settled.limits,
            noise,
        })
    }
}

/// A fit within some limits.
struct Attempt<'a> {
    fit: ModelFit,
    halves: &'a HeldOutHalves,
}

impl TransitionFit for Attempt<'_> {
    fn model(&self) -> &Model {
        &self.fit.model
    }

    fn values(&self) -> &DVector<f64> {
        &self.fit.values
    }

    fn deviations(&self) -> Vec<Option<f64>> {
        let recordings: Vec<&Prepared> = self.halves.whole.of(Split::Train).collect();
        self.fit.parameter_deviations(&recordings)
    }
}
