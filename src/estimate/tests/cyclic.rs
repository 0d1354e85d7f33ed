//! Averages of periods end where they begin.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::prior::Prior;
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::fit_problem::problem::NoiseSource;
use crate::estimate::minimisation::fit_setup::FitSetup;
use crate::estimate::minimisation::optimum::Optimum;
use crate::estimate::tests::{DECLARED, RED, TRUE_FRICTION, pendulum, torque, valued};
use crate::estimate::uncertainty::covariance::{Sensitivity, of_unknowns};
use crate::estimate::uncertainty::spectrum::SEGMENT;
use crate::problem::solution::Control;
use crate::recording::split::Split;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Covariance of the unknowns of a pendulum that is fitted to one recording, and the variance of a combination of them.
fn covariance_and_variance(recording: Prepared) -> (DMatrix<f64>, [f64; 2]) {
    let model = pendulum(&DECLARED);
    let data = Dataset {
        recordings: vec![recording],
    };
    let prior = Prior::none(model.parameters().len());
    let setup = FitSetup::of(&model, &data, &prior).unwrap();
    let control = Control::default();
    let minimisation = setup.minimisation(Estimator::MaximumLikelihood, &control);
    let Optimum { solution, problem } = minimisation.run().unwrap();
    assert_eq!(problem.noise, NoiseSource::Periods);
    let sensitivity = Sensitivity::of(&problem, &solution.x).unwrap();
    let residuals = problem.counted_residuals(&solution.x);
    let sandwich = sensitivity.under(&problem, &residuals);
    let covariance = sandwich.covariance();
    assert_eq!(of_unknowns(&problem, &solution.x).unwrap(), covariance);
    let g = DVector::from_fn(covariance.nrows(), |k, _| (k as f64 + 1.0).sin());
    let variances = [sandwich.variance(&g), g.dot(&(&covariance * &g))];
    (covariance, variances)
}

fn covariance(recording: Prepared) -> DMatrix<f64> {
    covariance_and_variance(recording).0
}

/// gᵀ C g without C, of one period and of so many rows that they are cut into segments.
#[test]
fn invariant_a_variance_is_that_of_the_covariance() {
    let model = pendulum(&DECLARED);
    let torque = torque(&model, &valued(&model, &TRUE_FRICTION));
    let recording = RED.record(&torque, (1, Split::Train));
    let mut whole = recording.clone();
    let experiment = Arc::make_mut(&mut whole.experiment);
    let times = SEGMENT / experiment.rows() + 1;
    let step = experiment.t[1] - experiment.t[0];
    let motion = &mut experiment.motion;
    let all = [
        &mut motion.position,
        &mut motion.velocity,
        &mut motion.acceleration,
        &mut experiment.signal,
    ];
    for series in all.into_iter().flatten() {
        *series = series.repeat(times);
    }
    let rows = experiment.signal[0].len();
    experiment.t = (0..rows).map(|k| k as f64 * step).collect();
    for recording in [recording, whole.thinned(1)] {
        let (_, [direct, of_covariance]) = covariance_and_variance(recording);
        let off = direct / of_covariance - 1.0;
        // Rounding.
        assert!(off.abs() < 1e-9, "{off:e}");
    }
}

/// Wherever a period is cut, the estimate is as uncertain: noise at its end is remembered at its beginning.
#[test]
fn invariant_a_period_may_begin_anywhere() {
    let model = pendulum(&DECLARED);
    let torque = torque(&model, &valued(&model, &TRUE_FRICTION));
    let recording = RED.record(&torque, (1, Split::Train));
    let expected = covariance(recording.clone());
    for rows in [7, 100] {
        let mut later = recording.clone();
        let experiment = Arc::make_mut(&mut later.experiment);
        let motion = &mut experiment.motion;
        let all = [
            &mut motion.position,
            &mut motion.velocity,
            &mut motion.acceleration,
            &mut experiment.signal,
        ];
        for series in all.into_iter().flatten() {
            series.rotate_left(rows);
        }
        let found = covariance(later);
        for (i, variance) in expected.diagonal().iter().enumerate() {
            let off = found[(i, i)] / variance - 1.0;
            // Rounding.
            assert!(off.abs() < 1e-9, "{rows} rows: unknown {i} {off:e}");
        }
    }
}
