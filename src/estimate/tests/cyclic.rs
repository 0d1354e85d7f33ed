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

/// Covariance of the unknowns of a pendulum that is fitted to one recording, and variances of a combination of them over that which
/// it gives.
fn covariance_and_variances(recording: Prepared) -> (DMatrix<f64>, [f64; 2]) {
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
    let covariance = of_unknowns(&problem, &solution.x).unwrap();
    let kept = sensitivity.clone().with_derivatives(&problem);
    assert_eq!(kept.under(&problem, &residuals).covariance(), covariance);
    let g = DVector::from_fn(covariance.nrows(), |k, _| (k as f64 + 1.0).sin());
    let variances = [&sensitivity, &kept].map(|s| s.under(&problem, &residuals).variance(&g));
    let of_covariance = g.dot(&(&covariance * &g));
    (
        covariance,
        variances.map(|variance| variance / of_covariance),
    )
}

/// A recording with every series of its motion and of its signal changed.
fn with_series(recording: &Prepared, change: impl Fn(&mut Vec<f64>)) -> Prepared {
    let mut changed = recording.clone();
    let experiment = Arc::make_mut(&mut changed.experiment);
    let motion = &mut experiment.motion;
    let all = [
        &mut motion.position,
        &mut motion.velocity,
        &mut motion.acceleration,
        &mut experiment.signal,
    ];
    all.into_iter().flatten().for_each(change);
    changed
}

fn covariance(recording: Prepared) -> DMatrix<f64> {
    covariance_and_variances(recording).0
}

/// gᵀ C g without C, of one period and of so many rows that they are cut into segments, with derivatives that are kept and that
/// are not.
#[test]
fn invariant_a_variance_is_that_of_the_covariance() {
    let model = pendulum(&DECLARED);
    let torque = torque(&model, &valued(&model, &TRUE_FRICTION));
    let recording = RED.record(&torque, (1, Split::Train));
    let times = SEGMENT / recording.experiment.rows() + 1;
    let mut whole = with_series(&recording, |series| *series = series.repeat(times));
    let experiment = Arc::make_mut(&mut whole.experiment);
    let step = experiment.t[1] - experiment.t[0];
    let rows = experiment.signal[0].len();
    experiment.t = (0..rows).map(|k| k as f64 * step).collect();
    for recording in [recording, whole.thinned(1)] {
        let (_, variances) = covariance_and_variances(recording);
        // Rounding.
        assert!(
            variances.iter().all(|v| (v - 1.0).abs() < 1e-9),
            "{variances:?}"
        );
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
        let found = covariance(with_series(&recording, |series| series.rotate_left(rows)));
        for (i, variance) in expected.diagonal().iter().enumerate() {
            let off = found[(i, i)] / variance - 1.0;
            // Rounding.
            assert!(off.abs() < 1e-9, "{rows} rows: unknown {i} {off:e}");
        }
    }
}
