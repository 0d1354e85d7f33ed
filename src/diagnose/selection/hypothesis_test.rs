//! Tests of single hypotheses: does the model that has one forecast what the model without it leaves, and by how much?

use crate::chain::effect::{Lasts, Law};
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::effect_size::{self, MATTERS};
use crate::diagnose::selection::forecast::{forecast, under_way};
use crate::recording::split::Split;
use crate::stats::encompassing::Encompassing;
use crate::stats::likelihood_ratio::is_beyond_chance;

/// The physics that a model was fitted to has a slope of 1 on other recordings; what is twice as large there is
/// something else, with which it has some shape in common.
const STEEPEST: f64 = 2.0;

/// Confidence with which a model is preferred to another that has fewer parameters, and with which a rival is set
/// aside: several rivals are compared with each finding, so that each may err but once in a hundred.
pub const CONFIDENCE: f64 = 0.99;

/// A hypothesis fitted beside what a model has already.
#[derive(Debug, Clone)]
pub struct HypothesisTest {
    /// What was tried.
    pub hypothesis: Hypothesis,
    /// The model that has it.
    pub fit: ModelFit,
    /// Against the model without it.
    pub evidence: Encompassing,
    /// p corrected for all hypotheses that were examined.
    pub p_value: f64,
    /// Largest share by which the held-out error of a joint falls.
    pub error_reduction: f64,
}

impl HypothesisTest {
    /// Of a model that has one hypothesis more than another; of one test.
    pub fn of(
        context: &Context<'_>,
        without: &ModelFit,
        fit: ModelFit,
        hypothesis: Hypothesis,
    ) -> Self {
        let pair = FitPair {
            poorer: without,
            richer: &fit,
        };
        // At reversals the errors of differentiation look like a delay.
        let mut evidence = match hypothesis.effect.law {
            Law::Delay => under_way(context, pair, None),
            _ => forecast(context, pair),
        };
        if matches!(hypothesis.effect.law, Law::Motor(_)) && is_smoothed(context) {
            let away = under_way(context, pair, None);
            evidence.p_value = evidence.p_value.max(away.p_value);
        }
        if hypothesis.effect.needs.lasts == Lasts::OneRecording {
            let parameters = hypothesis.effect.parameters.len();
            let rows = fit.validation.iter().map(Vec::len).max().unwrap_or(0);
            let own = evidence.of_own_parameters(parameters, rows);
            evidence.p_value = evidence.p_value.max(own);
        }
        Self {
            p_value: evidence.p_value,
            error_reduction: effect_size::error_reduction(context, &hypothesis, pair),
            hypothesis,
            evidence,
            fit,
        }
    }

    /// One of so many tests (Bonferroni).
    pub fn corrected_for(self, tests: usize) -> Self {
        Self {
            p_value: (self.evidence.p_value * tests as f64).min(1.0),
            ..self
        }
    }

    /// Whether it is significant, matters, and forecasts what it was fitted to.
    pub fn is_needed(&self, significance: f64) -> bool {
        let forecasts = self.evidence.slope <= STEEPEST;
        self.p_value < significance && self.error_reduction >= MATTERS && forecasts
    }
}

/// Whether a smoother has estimated the motion of held-out rows: what friction does at a reversal, which the controller answers
/// within some samples, is faster than that, and the rows about every reversal are off in the same way, whatever the model.
fn is_smoothed(context: &Context<'_>) -> bool {
    let held_out = context.recordings(Split::Validation);
    held_out.iter().any(|r| r.experiment.periods.is_none())
}

/// Whether a richer model fits better than a poorer one by more than parameters without a meaning would, with
/// [`CONFIDENCE`] (Wilks 1938): held-out rows that go beyond the fitted ones may favour it by chance, where what the
/// poorer model learned too little about happens to look like one of its parameters.
pub fn fits_better(pair: FitPair<'_>) -> bool {
    let freedom = pair.richer.freedom().saturating_sub(pair.poorer.freedom());
    let gain = pair.poorer.fitted_score() - pair.richer.fitted_score();
    is_beyond_chance(gain, freedom.max(1), CONFIDENCE)
}
