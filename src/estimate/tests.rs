//! Calibration of estimators: errors over stated standard deviations, from thousands of recordings of a pendulum whose
//! truth is known; and that rows which are held out take no part in any fit.
//!
//! ```text
//! z = (found − true) / std_dev,   mean z² = 1,   P(true in the 95 % interval) = 0.95
//! ```
//!
//! Standard deviations that are 5 % too short make the mean of z² 1.108, 5 % too long 0.907.

use crate::chain::base_parameters::BaseParameters;
use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect;
use crate::chain::evaluate::{Evaluator, Segment};
use crate::chain::model::{Model, ModelSettings, Signal};
use crate::chain::prior::Prior;
use crate::estimate::estimator::Estimator;
use crate::estimate::feasible::{self, Form, Settings};
use crate::estimate::fit::{Fitted, fit};
use crate::problem::solution::Control;
use crate::problem_file::choices::FeasibleBy;
use crate::recording::preprocess::prepare;
use crate::recording::samples::Recording;
use crate::recording::settings::Preparation;
use crate::recording::split::Split;
use crate::robot::batch::Trajectory;
use crate::robot::random::generator;
use crate::robot::urdf;
use nalgebra::DVector;
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::path::Path;

const PENDULUM: &str = r#"<robot name="pendulum"><link name="base"/>
<link name="bob"><inertial><origin xyz="0.2 0.0 -0.1"/><mass value="3.0"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/></joint>
</robot>"#;

/// Rows of one period, and periods.
const ROWS: usize = 240;
const PERIODS: usize = 10;
const PERIOD_S: f64 = 2.4;

/// N·m of one sample.
const NOISE: f64 = 0.3;

const SEEDS: u64 = 1200;

/// By how much the mean of z² may be off: 3 % of a standard deviation.
const OFF: f64 = 0.06;

#[derive(Debug, Clone, Copy)]
enum Way {
    Free(Estimator),
    Feasible(Form),
}

impl Way {
    fn fit(self, model: &Model, data: &Dataset) -> Fitted {
        let prior = Prior::none(model.parameters().len());
        let control = Control::default();
        match self {
            Self::Free(estimator) => fit(model, data, (estimator, &prior), &control),
            Self::Feasible(form) => {
                let settings = Settings {
                    form,
                    by: FeasibleBy::Cones,
                    prior: None,
                    limits: Vec::new(),
                };
                feasible::fit(model, data, (&prior, &settings), &control)
            }
        }
        .unwrap()
    }
}

const WAYS: [Way; 6] = [
    Way::Free(Estimator::Ordinary),
    Way::Free(Estimator::Weighted),
    Way::Free(Estimator::Robust),
    Way::Free(Estimator::MaximumLikelihood),
    Way::Feasible(Form::Weighted),
    Way::Feasible(Form::MaximumLikelihood),
];

/// Ways and the correlation of neighbouring samples of noise; the periods tell maximum likelihood how noise is coloured.
const CALIBRATED: [(Way, f64); 8] = [
    (Way::Free(Estimator::Ordinary), 0.0),
    (Way::Free(Estimator::Weighted), 0.0),
    (Way::Free(Estimator::Robust), 0.0),
    (Way::Feasible(Form::Weighted), 0.0),
    (Way::Free(Estimator::MaximumLikelihood), 0.0),
    (Way::Free(Estimator::MaximumLikelihood), 0.7),
    (Way::Feasible(Form::MaximumLikelihood), 0.0),
    (Way::Feasible(Form::MaximumLikelihood), 0.7),
];

/// A pendulum with effects whose parameters enter linearly.
fn pendulum(effects: &[&str]) -> Model {
    let effects = effects.iter().map(|id| effect::find(id).unwrap());
    let tree = urdf::parse(PENDULUM, Path::new("pendulum.urdf")).unwrap();
    Model::new(ModelSettings {
        effects: vec![effects.collect()],
        ..ModelSettings::bodies(tree, Signal::Torque)
    })
    .unwrap()
}

const DECLARED: [&str; 2] = ["viscous_friction", "torque_offset"];

/// Values of a pendulum by name, beside those of its body.
fn valued(model: &Model, named: &[(&str, f64)]) -> DVector<f64> {
    let mut values = model.values();
    for (p, value) in model.tree().parameters().into_iter().enumerate() {
        values[p] = value;
    }
    for (name, value) in named {
        values[model.find(&format!("hinge.{name}")).unwrap()] = *value;
    }
    values
}

const TRUE_FRICTION: [(&str, f64); 2] =
    [("viscous_friction.Fv", 1.5), ("torque_offset.offset", 0.4)];

/// Position, velocity and acceleration of one period, three harmonics: `[order][row]`.
fn motion() -> [Vec<f64>; 3] {
    let terms = [(0.8, 1.0, 0.2), (0.3, 2.0, 1.3), (0.15, 3.0, -0.7)];
    [0, 1, 2].map(|order: i32| {
        let at = |row: usize| {
            let term = |(size, harmonic, phase): &(f64, f64, f64)| {
                let rate = TAU * harmonic / PERIOD_S;
                let angle = TAU * harmonic * row as f64 / ROWS as f64 + phase;
                size * rate.powi(order) * (angle + f64::from(order) * TAU / 4.0).sin()
            };
            terms.iter().map(term).sum()
        };
        (0..ROWS).map(at).collect()
    })
}

/// Torque of one period without noise.
fn torque(model: &Model, values: &DVector<f64>) -> Vec<f64> {
    let [q, dq, ddq] = motion().map(|series| vec![series]);
    let motors = Trajectory {
        q: &q,
        dq: &dq,
        ddq: &ddq,
    };
    let segment = Segment::states(motors, false);
    let mut evaluator = Evaluator::along(model, values, &[], ROWS);
    evaluator.evaluate(segment, 0..ROWS).value(0).to_vec()
}

/// A recording of all periods with noise that remembers so much of the sample before.
fn recorded(torque: &[f64], correlation: f64, (seed, split): (u64, Split)) -> Prepared {
    let mut rng = generator(seed);
    let mut last: f64 = rng.sample(StandardNormal);
    let samples = PERIODS * ROWS;
    let noisy = torque.iter().cycle().take(samples).map(|torque| {
        let fresh: f64 = rng.sample(StandardNormal);
        last = correlation * last + (1.0 - correlation * correlation).sqrt() * fresh;
        torque + NOISE * last
    });
    let noisy = noisy.collect();
    let position = motion()[0].iter().cycle().take(samples).copied().collect();
    let recording = Recording::of_samples(format!("seed {seed}"), vec![position], vec![noisy]);
    let preparation = Preparation {
        rate: Some(ROWS as f64 / PERIOD_S),
        period: Some(PERIOD_S),
        ..Preparation::default()
    };
    let experiment = prepare(recording, &preparation).unwrap();
    Prepared::new(format!("seed {seed}"), split, false, experiment)
}

/// Values of the base parameters that parameters have.
fn base(model: &Model, values: &DVector<f64>) -> Vec<f64> {
    let none = Prior::none(model.parameters().len());
    let structural = BaseParameters::structural(model, &[false], none.rows());
    let of = |b: &crate::chain::base_parameters::BaseParameter| {
        values[b.parameter] + b.others.iter().map(|&(p, c)| c * values[p]).sum::<f64>()
    };
    structural.base.iter().map(of).collect()
}

/// Mean of z² over seeds and parameters, its standard error over the seeds, and the share of 95 % intervals that cover.
struct Calibration {
    square: f64,
    error: f64,
    covered: f64,
}

impl Calibration {
    fn of(way: Way, correlation: f64) -> Self {
        let model = pendulum(&DECLARED);
        let values = valued(&model, &TRUE_FRICTION);
        let (truth, torque) = (base(&model, &values), torque(&model, &values));
        let of_seed = |seed: u64| {
            let recordings = vec![recorded(&torque, correlation, (seed, Split::Train))];
            let fitted = way.fit(&model, &Dataset { recordings });
            let found = fitted.fit.base_parameters;
            assert_eq!(found.len(), truth.len());
            let (mut square, mut covered) = (0.0, 0.0);
            for (found, truth) in found.iter().zip(&truth) {
                let [low, high] = found.ci95.unwrap();
                square += ((found.value.unwrap() - truth) / found.std_dev.unwrap()).powi(2);
                covered += f64::from(u8::from((low..=high).contains(truth)));
            }
            let count = truth.len() as f64;
            (square / count, covered / count)
        };
        let all: Vec<(f64, f64)> = (0..SEEDS).into_par_iter().map(of_seed).collect();
        let seeds = SEEDS as f64;
        let square = all.iter().map(|(s, _)| s).sum::<f64>() / seeds;
        let spread = all.iter().map(|(s, _)| (s - square).powi(2)).sum::<f64>() / seeds;
        Self {
            square,
            error: (spread / seeds).sqrt(),
            covered: all.iter().map(|(_, c)| c).sum::<f64>() / seeds,
        }
    }
}

#[test]
fn standard_deviations_are_as_long_as_the_errors_of_estimators() {
    let mut wrong = Vec::new();
    for (way, correlation) in CALIBRATED {
        let Calibration {
            square,
            error,
            covered,
        } = Calibration::of(way, correlation);
        let said =
            format!("{way:?}, {correlation}: z² {square:.3} ± {error:.3}, covered {covered:.4}");
        eprintln!("{said}");
        if (square - 1.0).abs() > OFF || (covered - 0.95).abs() > 0.012 {
            wrong.push(said);
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Parameters of a model that lacks a law, against what it comes to without noise: errors are those of the noise and what is
/// missing is none of them, so that intervals may be too long and must not be too short.
#[test]
fn standard_deviations_are_not_too_short_where_the_model_is_not_the_truth() {
    let rich = pendulum(&["viscous_friction", "torque_offset", "joint_spring"]);
    let spring = [("joint_spring.k", 1.0), ("joint_spring.q0", 0.0)];
    let truth = valued(&rich, &[&TRUE_FRICTION[..], &spring[..]].concat());
    let (torque, model) = (torque(&rich, &truth), pendulum(&DECLARED));
    for way in WAYS {
        let fitted = |torque: &[f64], seed: u64| {
            let recordings = vec![recorded(torque, 0.0, (seed, Split::Train))];
            let found = way.fit(&model, &Dataset { recordings }).fit.base_parameters;
            let pairs = found.iter().map(|b| (b.value.unwrap(), b.std_dev.unwrap()));
            pairs.collect::<Vec<(f64, f64)>>()
        };
        let all: Vec<Vec<(f64, f64)>> = (0..300)
            .into_par_iter()
            .map(|seed| fitted(&torque, seed))
            .collect();
        let count = all.len() as f64;
        let mut squares = Vec::new();
        for k in 0..all[0].len() {
            let mean = all.iter().map(|found| found[k].0).sum::<f64>() / count;
            let z = all
                .iter()
                .map(|found| ((found[k].0 - mean) / found[k].1).powi(2));
            squares.push(z.sum::<f64>() / (count - 1.0));
        }
        let largest = squares.iter().copied().fold(0.0, f64::max);
        eprintln!("{way:?}: z² of each {squares:.3?}");
        // Three standard errors of a mean of 300 squares.
        assert!(
            largest < 1.0 + 3.0 * (2.0 / count).sqrt(),
            "{way:?}: {squares:?}"
        );
    }
}

/// A held-out recording of another torque leaves every value of the fit as it is, to the bit.
#[test]
fn invariant_rows_that_are_held_out_take_no_part_in_a_fit() {
    let model = pendulum(&DECLARED);
    let torque = torque(&model, &valued(&model, &TRUE_FRICTION));
    let other: Vec<f64> = torque.iter().map(|torque| 1.5 * torque + 1.0).collect();
    for way in WAYS {
        let fitted = |held_out: &[f64]| {
            let recordings = vec![
                recorded(&torque, 0.0, (1, Split::Train)),
                recorded(held_out, 0.0, (2, Split::Validation)),
            ];
            way.fit(&model, &Dataset { recordings })
        };
        let (one, another) = (fitted(&torque), fitted(&other));
        assert_eq!(one.values, another.values, "{way:?}");
        let [right, wrong] = [&one, &another].map(|f| f.estimate.joints[0].rmse_validation);
        assert!(wrong.unwrap() > 5.0 * right.unwrap(), "{way:?}");
    }
}
