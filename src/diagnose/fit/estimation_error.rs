//! Tests of a model against a richer one that know how uncertain its parameters are.

use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::estimate::noise::ResidualSeries;
use crate::recording::split::Split;
use crate::stats::encompassing::Encompassing;
use crate::stats::estimation_error::EstimationError;

/// A larger p-value decides nothing, and what errors of parameters would add to it is not computed.
const DECIDES: f64 = 0.05;

/// A poorer model and the noise in which it was fitted.
pub struct FittedInNoise<'a> {
    /// The recordings.
    pub context: &'a Context<'a>,
    /// The poorer model.
    pub poorer: &'a ModelFit,
    /// What a richer one leaves of the fitted rows.
    pub noise: &'a dyn Fn() -> ResidualSeries,
    /// Held-out rows that are looked at, per channel; all where there is no list.
    pub kept: &'a [Option<Vec<bool>>],
}

impl FittedInNoise<'_> {
    /// A test of held-out residuals, with the errors of the poorer model's parameters where it decides anything and where they are
    /// known.
    pub fn test(
        &self,
        test: &dyn Fn(Option<&EstimationError<'_>>) -> Encompassing,
    ) -> Encompassing {
        let evidence = test(None);
        if evidence.p_value >= DECIDES {
            return evidence;
        }
        self.beside_errors(test).unwrap_or(evidence)
    }

    fn beside_errors(
        &self,
        test: &dyn Fn(Option<&EstimationError<'_>>) -> Encompassing,
    ) -> Option<Encompassing> {
        let [fitted, held_out] =
            [Split::Train, Split::Validation].map(|split| self.context.recordings(split));
        let cache = &self.context.derivatives;
        let derivatives = cache.of(self.poorer, &fitted, &held_out)?;
        let problem = self.poorer.problem(&fitted);
        let sandwich = derivatives.fitted.under(&problem, &(self.noise)());
        Some(test(Some(&EstimationError {
            derivatives: &derivatives.held_out,
            kept: self.kept,
            variance: &|g| sandwich.variance(g),
        })))
    }
}
