//! Errors over stated standard deviations, from thousands of recordings.
//!
//! ```text
//! z = (found − true) / std_dev,   mean z² = 1,   P(true in the 95 % interval) = 0.95
//! ```
//!
//! Standard deviations that are 5 % too short make the mean of z² 1.108, 5 % too long 0.907.

use crate::chain::base_parameters::BaseParameters;
use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::chain::prior::Prior;
use crate::estimate::feasible::Form;
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::tests::{
    DECLARED, NOISE, PERIODS, RED, Recorder, SPARSE, TRUE_FRICTION, USUAL, WAYS, Way, pendulum,
    torque, valued,
};
use crate::recording::split::Split;
use nalgebra::DVector;
use rayon::prelude::*;

const SEEDS: u64 = 1200;

/// By how much the mean of z² may be off: 3 % of a standard deviation.
const OFF: f64 = 0.06;

/// Ways and recordings; the periods tell maximum likelihood how noise is coloured.
const CALIBRATED: [(Way, Recorder); 8] = [
    (Way::Free(Estimator::Ordinary), USUAL),
    (Way::Free(Estimator::Weighted), USUAL),
    (Way::Free(Estimator::Robust), USUAL),
    (Way::Feasible(Form::Weighted), USUAL),
    (Way::Free(Estimator::MaximumLikelihood), USUAL),
    (Way::Free(Estimator::MaximumLikelihood), RED),
    (Way::Feasible(Form::MaximumLikelihood), USUAL),
    (Way::Feasible(Form::MaximumLikelihood), RED),
];

/// Values of the base parameters that parameters have.
fn base(model: &Model, values: &DVector<f64>) -> Vec<f64> {
    let none = Prior::none(model.parameters().len());
    let structural = BaseParameters::structural(model, &[false], none.rows());
    let of = |b: &crate::chain::base_parameters::BaseParameter| {
        values[b.parameter] + b.others.iter().map(|&(p, c)| c * values[p]).sum::<f64>()
    };
    structural.base.iter().map(of).collect()
}

/// How far estimates of many recordings are off, beside their standard deviations.
struct Calibration {
    /// Mean of z² over seeds and parameters, and its standard error over the seeds.
    square: f64,
    error: f64,
    /// Share of 95 % intervals that cover.
    covered: f64,
    /// Mean square of the errors over the mean variance, of the parameters on the average.
    variance: f64,
}

/// An estimate beside the truth.
#[derive(Debug, Clone, Copy)]
struct Compared {
    off: f64,
    std_dev: f64,
    covers: bool,
}

impl Compared {
    fn square(self) -> f64 {
        (self.off / self.std_dev).powi(2)
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

impl Calibration {
    fn of(way: Way, recorder: Recorder) -> Self {
        let model = pendulum(&DECLARED);
        let values = valued(&model, &TRUE_FRICTION);
        let (truth, torque) = (base(&model, &values), torque(&model, &values));
        let of_seed = |seed: u64| -> Vec<Compared> {
            let recordings = vec![recorder.record(&torque, (seed, Split::Train))];
            let fitted = way.fit(&model, &Dataset { recordings });
            let found = fitted.fit.base_parameters;
            assert_eq!(found.len(), truth.len());
            let pairs = found.iter().zip(&truth);
            let compared = pairs.map(|(found, truth)| {
                let [low, high] = found.ci95.unwrap();
                Compared {
                    off: found.value.unwrap() - truth,
                    std_dev: found.std_dev.unwrap(),
                    covers: (low..=high).contains(truth),
                }
            });
            compared.collect()
        };
        let all: Vec<Vec<Compared>> = (0..SEEDS).into_par_iter().map(of_seed).collect();
        let squares = all.iter().map(|of| mean(of.iter().map(|c| c.square())));
        let square = mean(squares.clone());
        let spread = mean(squares.map(|s| (s - square).powi(2)));
        let variance = |k: usize| {
            let errors = mean(all.iter().map(|of| of[k].off.powi(2)));
            errors / mean(all.iter().map(|of| of[k].std_dev.powi(2)))
        };
        let covering = |of: &Vec<Compared>| mean(of.iter().map(|c| f64::from(u8::from(c.covers))));
        Self {
            square,
            error: (spread / SEEDS as f64).sqrt(),
            covered: mean(all.iter().map(covering)),
            variance: mean((0..truth.len()).map(variance)),
        }
    }
}

#[test]
fn standard_deviations_are_as_long_as_the_errors_of_estimators() {
    let mut wrong = Vec::new();
    for (way, recorder) in CALIBRATED {
        let Calibration {
            square,
            error,
            covered,
            ..
        } = Calibration::of(way, recorder);
        let said =
            format!("{way:?}, {recorder:?}: z² {square:.3} ± {error:.3}, covered {covered:.4}");
        eprintln!("{said}");
        if (square - 1.0).abs() > OFF || (covered - 0.95).abs() > 0.012 {
            wrong.push(said);
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Residuals of few rows are smaller than noise by what the fit follows of it, which variances make up for.
#[test]
fn variances_are_those_of_errors_on_the_average_where_rows_are_few() {
    for way in [
        Way::Free(Estimator::Weighted),
        Way::Feasible(Form::Weighted),
    ] {
        let variance = Calibration::of(way, SPARSE).variance;
        eprintln!("{way:?}: squares of errors over variances {variance:.3}");
        assert!((variance - 1.0).abs() < OFF, "{way:?}: {variance}");
    }
}

/// A pendulum with a spring, and the torque of it.
fn sprung(stiffness: f64) -> Vec<f64> {
    let rich = pendulum(&["viscous_friction", "torque_offset", "joint_spring"]);
    let spring = [("joint_spring.k", stiffness), ("joint_spring.q0", 0.0)];
    let values = valued(&rich, &[&TRUE_FRICTION[..], &spring[..]].concat());
    torque(&rich, &values)
}

/// Mean z² of each parameter of a model that lacks the law behind a torque, of errors about what it comes to on the average.
fn squares(way: Way, torque: &[f64], seeds: u64) -> Vec<f64> {
    let model = pendulum(&DECLARED);
    let fitted = |seed: u64| {
        let recordings = vec![USUAL.record(torque, (seed, Split::Train))];
        let found = way.fit(&model, &Dataset { recordings }).fit.base_parameters;
        let pairs = found.iter().map(|b| (b.value.unwrap(), b.std_dev.unwrap()));
        pairs.collect::<Vec<(f64, f64)>>()
    };
    let all: Vec<Vec<(f64, f64)>> = (0..seeds).into_par_iter().map(fitted).collect();
    let count = all.len() as f64;
    let of = |k: usize| {
        let mean = all.iter().map(|found| found[k].0).sum::<f64>() / count;
        let z = all
            .iter()
            .map(|found| ((found[k].0 - mean) / found[k].1).powi(2));
        z.sum::<f64>() / (count - 1.0)
    };
    (0..all[0].len()).map(of).collect()
}

/// What is missing is none of the noise, so that intervals may be too long and must not be too short.
#[test]
fn standard_deviations_are_not_too_short_where_much_is_missing() {
    const SEEDS: u64 = 300;
    let torque = sprung(1.0);
    for way in WAYS {
        let squares = squares(way, &torque, SEEDS);
        let largest = squares.iter().copied().fold(0.0, f64::max);
        eprintln!("{way:?}: z² of each {squares:.3?}");
        // Three standard errors of a mean of so many squares.
        assert!(
            largest < 1.0 + 3.0 * (2.0 / SEEDS as f64).sqrt(),
            "{way:?}: {squares:?}"
        );
    }
}

/// RMS torque of a spring that the model lacks, over the noise of a row: an average over the periods.
const LACKING: f64 = 0.15;

/// Where little is missing, which a fit takes for noise, z² lies between 1/(1 + share) and 1, with its share of the variance.
#[test]
fn standard_deviations_are_as_long_as_errors_where_little_is_missing() {
    let row = NOISE / (PERIODS as f64).sqrt();
    let silent = Recorder {
        noise: 0.0,
        ..USUAL
    };
    // What a fit leaves of a spring is in proportion to its stiffness.
    let left = |stiffness: f64| {
        let recording = silent.record(&sprung(stiffness), (0, Split::Train));
        let data = Dataset {
            recordings: vec![recording],
        };
        let fitted = Way::Free(Estimator::Ordinary).fit(&pendulum(&DECLARED), &data);
        fitted.estimate.joints[0].rmse_train
    };
    let stiffness = LACKING * row / left(1.0);
    approx::assert_relative_eq!(left(stiffness), LACKING * row, max_relative = 1e-3);
    let torque = sprung(stiffness);
    let mut wrong = Vec::new();
    for way in WAYS {
        let squares = squares(way, &torque, SEEDS);
        let square = squares.iter().sum::<f64>() / squares.len() as f64;
        let said = format!("{way:?}: z² {square:.3}");
        eprintln!("{said}");
        let least = 1.0 / (1.0 + LACKING * LACKING);
        if !(least - OFF..=1.0 + OFF).contains(&square) {
            wrong.push(said);
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
