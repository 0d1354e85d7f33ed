//! Tests of what a search has chosen on rows that took no part in the choice.
//!
//! Each hypothesis that a search has accepted has to forecast, on rows that it never saw, what the
//! model without it leaves there, at the stated significance corrected for the number of hypotheses that are tested
//! (Bonferroni). An error of the search, whatever it chose among, is thus found out at the stated rate.

use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::contexts::Contexts;
use crate::diagnose::fit::hypothesis::channels_of;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::selection::exact_fit::fit_without;
use crate::diagnose::selection::hypothesis_test::HypothesisTest;
use crate::stats::deviation::rms;

/// The hypotheses of a model, each against the model without it, on rows that no choice has seen; p-values are
/// corrected for `count` tests.
pub fn tests(
    contexts: &Contexts<'_>,
    full: &ModelFit,
    count: usize,
) -> Result<Vec<HypothesisTest>, DiagnoseError> {
    let test = |k: usize| {
        let poorer = fit_without(&contexts.selection, full, k)?;
        let hypothesis = full.hypotheses[k].clone();
        let context = contexts.testing(&hypothesis);
        let (poorer, richer) = (poorer.on(context), full.on(context));
        Ok(HypothesisTest::of(context, &poorer, richer, hypothesis).corrected_for(count))
    };
    (0..full.hypotheses.len()).map(test).collect()
}

/// The hypothesis to be struck out: of those that fail the test the one with the weakest evidence.
pub fn failing(tests: &[HypothesisTest], significance: f64) -> Option<usize> {
    let fails = |k: &usize| tests[*k].p_value >= significance;
    let ratio = |k: &usize| tests[*k].evidence.ratio;
    (0..tests.len())
        .filter(fails)
        .min_by(|a, b| ratio(a).total_cmp(&ratio(b)))
}

/// The first hypothesis that raises the error of its own joints in its place in the order, beside those before it alone.
pub fn misplaced(contexts: &Contexts<'_>, prefixes: &[ModelFit]) -> Option<usize> {
    (0..prefixes.len() - 1).find(|&k| raises_error(contexts, prefixes, k))
}

/// Whether the k-th finding raises the error of its joints on rows that no choice has seen.
fn raises_error(contexts: &Contexts<'_>, prefixes: &[ModelFit], k: usize) -> bool {
    let hypothesis = &prefixes[k + 1].hypotheses[k];
    let context = contexts.testing(hypothesis);
    let pooled = |fit: &ModelFit| {
        let seen = fit.on(context);
        let channels = channels_of(&seen.model, &hypothesis.named_joints());
        let squares = channels.iter().map(|&c| rms(&seen.validation[c]).powi(2));
        squares.sum::<f64>()
    };
    pooled(&prefixes[k + 1]) > pooled(&prefixes[k])
}
