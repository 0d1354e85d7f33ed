//! Averages of periods end where they begin.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::prior::Prior;
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::fit_problem::problem::NoiseSource;
use crate::estimate::minimisation::fit_setup::FitSetup;
use crate::estimate::minimisation::optimum::Optimum;
use crate::estimate::tests::{DECLARED, RED, TRUE_FRICTION, pendulum, torque, valued};
use crate::estimate::uncertainty::covariance::of_unknowns;
use crate::problem::solution::Control;
use crate::recording::split::Split;
use nalgebra::DMatrix;
use std::sync::Arc;

/// Covariance of the unknowns of a pendulum that is fitted to one recording.
fn covariance(recording: Prepared) -> DMatrix<f64> {
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
    of_unknowns(&problem, &solution.x).unwrap()
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
