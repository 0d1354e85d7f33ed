//! Joint angles as noisy as signals: errors in variables.

use crate::bench::{Bench, NAMES, Payload};
use exid::chain::prior::Prior;
use exid::estimate::errors_in_variables;
use exid::estimate::estimator::Estimator;
use exid::estimate::fit::{Fitted, fit};
use exid::problem::solution::Control;
use exid::stats::distribution::Distribution;
use rayon::prelude::*;

const SEEDS: u64 = 12;

/// rad of one angle: of averages over ten periods and after the series of 25 harmonics it moves the torque of gravity
/// by as much as the noise of the currents.
const ENCODER_NOISE: f64 = 0.1;

/// Every harmonic of Table 1 and none above, Hz.
const CUTOFF: &str = "recordings.differentiation.cutoff_hz=0.7";

/// Probability with which the sums of squares below miss their limits by chance.
const FALSE_ALARM: f64 = 1e-3;

/// Errors over true values' standard deviations, and plain errors, of the load's parameters.
fn errors(bench: &Bench, fitted: &Fitted) -> Vec<(f64, f64)> {
    let load = Payload::of(&fitted.estimate.parameters);
    let half = Distribution::Normal.two_sided(0.95);
    let one = |k: usize| {
        let error = load.value[k] - bench.truth.value[k];
        let [low, high] = load.ci95[k].unwrap();
        (error, error / ((high - low) / (2.0 * half)))
    };
    (0..NAMES.len()).map(one).collect()
}

#[test]
fn recovers_known_truth_from_noisy_angles_better_than_by_taking_them_for_exact() {
    let mut bench = Bench::new(&[CUTOFF.to_string()]);
    bench.encoder_noise = ENCODER_NOISE;
    let prior = Prior::none(bench.model.parameters().len());
    let control = Control::default();
    let both: Vec<[Vec<(f64, f64)>; 2]> = (0..SEEDS)
        .into_par_iter()
        .map(|seed| {
            let data = bench.data(seed);
            let estimator = Estimator::MaximumLikelihood;
            let exact = fit(&bench.model, &data, estimator, &prior, &control).unwrap();
            let noisy =
                errors_in_variables::fit::fit(&bench.model, &data, &prior, &control).unwrap();
            assert!(noisy.estimate.solver.as_ref().unwrap().converged);
            [errors(&bench, &exact), errors(&bench, &noisy)]
        })
        .collect();
    let squares = Distribution::ChiSquared {
        freedom: SEEDS as f64,
    };
    let tail = FALSE_ALARM / (2.0 * NAMES.len() as f64);
    let (low, high) = (squares.quantile(tail), squares.upper_quantile(tail));
    let mut gain = 0.0;
    for (k, name) in NAMES.iter().enumerate() {
        let sum = |way: usize| both.iter().map(|b| b[way][k].0.powi(2)).sum::<f64>();
        let normal: f64 = both.iter().map(|b| b[1][k].1.powi(2)).sum();
        let ratio = (sum(1) / sum(0)).sqrt();
        gain += ratio.ln() / NAMES.len() as f64;
        eprintln!(
            "payload.{name}: error {ratio:.3} of that with exact angles, squares {normal:.1} of {SEEDS}"
        );
        assert!(
            (low..=high).contains(&normal),
            "{name}: {normal} outside {low} to {high}"
        );
    }
    assert!(gain < 0.0, "errors grow by a factor of {}", gain.exp());
}
