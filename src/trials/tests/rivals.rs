//! Rivals of a finding: which are worth a fit, and which the held-out rows set aside.

use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::{noise_level, reversal_mask};
use crate::diagnose::selection::exact_fit::taken;
use crate::diagnose::selection::hypothesis_test::HypothesisTest;
use crate::diagnose::selection::rival_models::separation;
use crate::diagnose::selection::stepwise::{AlreadyTried, Rules, Stepwise};
use crate::recording::split::Split;
use crate::trials::tests::bench::{Bench, SIGNIFICANCE, offset};

/// Beside an offset which a rival that takes half of it would be told from, only those are fitted that may take so much.
#[test]
fn what_cannot_rival_a_finding_is_not_fitted() {
    let bench = Bench::control();
    let data = bench.with_signals(&[Split::Train, Split::Validation], |s| s + 1.0);
    let context = bench.context(&data);
    let full = bench.fit(&data, &[1, 2, 0].map(offset));
    let stepwise = Stepwise {
        context: &context,
        rules: Rules {
            sought: None,
            significance: SIGNIFICANCE,
        },
        progress: &|_| (),
    };
    let noise_level = noise_level::of_rows(&context, &full, &[]);
    let comparison = stepwise.rivals(&full, 2, &noise_level).unwrap();
    let without = &comparison.without;
    let by_finding = taken(FitPair {
        poorer: without,
        richer: &full,
    });
    let mut open = stepwise.rules.open(&context, without);
    open.retain(|h| *h != offset(0));
    let already = AlreadyTried {
        by_finding,
        ..AlreadyTried::default()
    };
    let all = stepwise.tests(without, &open, already).unwrap();
    let share = |test: &HypothesisTest| {
        let pair = FitPair {
            poorer: without,
            richer: &test.fit,
        };
        taken(pair) / by_finding
    };
    let shares: Vec<f64> = all.iter().map(share).collect();
    let rivals = comparison.alternatives.iter().map(|a| &a.test);
    let tried: Vec<f64> = rivals.map(share).collect();
    assert!(tried.len() < all.len(), "{tried:?} of {shares:?}");
    assert!(tried.iter().all(|share| *share > 0.2), "{tried:?}");
}

/// What every model leaves about reversals does not hide that a rival is worse where the joint is under way; what they leave there
/// does.
#[test]
fn rows_about_reversals_leave_no_rival_open() {
    let bench = Bench::control();
    let data = bench.with_signals(&[Split::Train, Split::Validation], |s| s + 1.0);
    let context = bench.context(&data);
    let (poorer, richer) = (bench.declared(&data), bench.fit(&data, &[offset(0)]));
    let noise_level = noise_level::of_rows(&context, &richer, &[]);
    assert!(noise_level.measured);
    let moves = reversal_mask::rows(&context, &richer, 0).unwrap();
    assert!(moves.iter().any(|moves| !moves));
    let is_separable = |off: &dyn Fn(bool) -> f64| {
        let [poorer, richer] = [&poorer, &richer].map(|fit: &ModelFit| {
            let mut fit = fit.clone();
            let rows = fit.validation[0].iter_mut().zip(&moves).enumerate();
            for (k, (e, moves)) in rows {
                *e += if k % 2 == 0 {
                    off(*moves)
                } else {
                    -off(*moves)
                };
            }
            fit
        });
        let pair = FitPair {
            poorer: &poorer,
            richer: &richer,
        };
        separation(&context, &noise_level, pair, &[0]).separable
    };
    assert!(is_separable(&|_| 0.0));
    assert!(is_separable(&|moves| if moves { 0.0 } else { 1e3 }));
    assert!(!is_separable(&|moves| if moves { 1e3 } else { 0.0 }));
}
