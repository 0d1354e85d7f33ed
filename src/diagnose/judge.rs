//! Tests of what a search has chosen on rows that took no part in the choice.
//!
//! Each hypothesis that a search has accepted has to forecast, on rows that it never saw, what the
//! model without it leaves there, at the stated significance corrected for the number of hypotheses that are tested
//! (Bonferroni). An error of the search, whatever it chose among, is thus found out at the stated rate.

use crate::diagnose::bench::Bench;
use crate::diagnose::benches::Benches;
use crate::diagnose::conclude::{chance, channels_of};
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::evidence::encompassing;
use crate::diagnose::floor::Floor;
use crate::diagnose::probability::{Alternatives, Probabilities};
use crate::diagnose::refit::Refit;
use crate::diagnose::rivals::Contest;
use crate::diagnose::rows::rms;
use crate::diagnose::search::{Trial, compare, fit_without};
use crate::diagnose::underway;

/// The hypotheses of a model, each against the model without it, on rows that no choice has seen; p-values are
/// corrected for `count` tests.
pub fn tests(
    benches: &Benches<'_>,
    full: &Refit,
    count: usize,
) -> Result<Vec<Trial>, DiagnoseError> {
    let test = |k: usize| {
        let poorer = fit_without(&benches.selection, full, k)?;
        let hypothesis = full.hypotheses[k].clone();
        let bench = benches.testing(&hypothesis);
        let pair = (&poorer.on(bench), full.on(bench));
        Ok(compare(bench, pair, (hypothesis, count)))
    };
    (0..full.hypotheses.len()).map(test).collect()
}

/// The hypothesis to be struck out: of those that fail the test the one with the weakest evidence, or else one that
/// raises the error of its own joints, in its place in the order in which they were found.
pub fn failing(
    benches: &Benches<'_>,
    (prefixes, tests): (&[Refit], &[Trial]),
    significance: f64,
) -> Option<usize> {
    let fails = |k: &usize| tests[*k].p_value >= significance;
    let ratio = |k: &usize| tests[*k].evidence.ratio;
    let weakest = (0..tests.len())
        .filter(fails)
        .min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    weakest.or_else(|| (0..tests.len()).find(|&k| raises_error(benches, prefixes, k)))
}

/// Whether the k-th finding raises the error of its joints on rows that no choice has seen.
fn raises_error(benches: &Benches<'_>, prefixes: &[Refit], k: usize) -> bool {
    let hypothesis = &prefixes[k + 1].hypotheses[k];
    let bench = benches.testing(hypothesis);
    let pooled = |refit: &Refit| {
        let seen = refit.on(bench);
        let channels = channels_of(&seen.model, &hypothesis.named_joints());
        let squares = channels.iter().map(|&c| rms(&seen.validation[c]).powi(2));
        squares.sum::<f64>()
    };
    pooled(&prefixes[k + 1]) > pooled(&prefixes[k])
}

/// Probabilities of a finding and of what may be there in its place; `rows` are those of its test, and so is the contest.
pub fn probabilities(
    rows: &Bench<'_>,
    (test, contest): (&Trial, &Contest),
    floor: &Floor,
) -> Probabilities {
    let found = &test.refit.validation;
    let against = |rival: &Refit| encompassing((&rival.validation, found), None, rows.samples());
    let rivals = contest.alternatives.iter().map(|a| against(&a.trial.refit));
    let channels = channels_of(&test.refit.model, &test.hypothesis.named_joints());
    // At reversals every model leaves more than noise.
    let kept = |c: usize| underway::residual(rows, &test.refit, c, &found[c]);
    let left = channels
        .into_iter()
        .filter(|_| floor.measured)
        .filter_map(|c| chance(&kept(c), floor.rms[c]))
        .fold(1.0, f64::min);
    Alternatives {
        rivals: rivals.collect(),
        nothing: test.evidence,
        left,
    }
    .probabilities()
}
