//! Fits of recordings of a pendulum whose truth is known: what they report, how sure they are of it, and what they are not fitted
//! to.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect;
use crate::chain::evaluate::{Evaluator, Segment};
use crate::chain::model::{Model, ModelSettings, Signal};
use crate::chain::prior::Prior;
use crate::estimate::error::EstimateError;
use crate::estimate::feasible::{self, Form, Settings};
use crate::estimate::fit::{Fitted, fit};
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::fit_problem::problem::NoiseSource;
use crate::estimate::minimisation::fit_setup::FitSetup;
use crate::outcome::parameter::Source;
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
use std::f64::consts::TAU;
use std::path::Path;

mod calibration;
mod channels;
mod cyclic;
mod errors_in_variables;
mod held_out;
mod starts;
mod undetermined;
mod unfinished;

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
            Self::Free(estimator) => fit(model, data, estimator, &prior, &control),
            Self::Feasible(form) => {
                let settings = Settings {
                    form,
                    by: FeasibleBy::Cones,
                    prior: None,
                    limits: Vec::new(),
                };
                feasible::fit(model, data, &prior, &settings, &control)
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
    motion_in(ROWS)
}

/// The same with so many rows.
fn motion_in(rows: usize) -> [Vec<f64>; 3] {
    let terms = [(0.8, 1.0, 0.2), (0.3, 2.0, 1.3), (0.15, 3.0, -0.7)];
    [0, 1, 2].map(|order: i32| {
        let at = |row: usize| {
            let term = |(size, harmonic, phase): &(f64, f64, f64)| {
                let rate = TAU * harmonic / PERIOD_S;
                let angle = TAU * harmonic * row as f64 / rows as f64 + phase;
                size * rate.powi(order) * (angle + f64::from(order) * TAU / 4.0).sin()
            };
            terms.iter().map(term).sum()
        };
        (0..rows).map(at).collect()
    })
}

/// Torque of one period without noise.
fn torque(model: &Model, values: &DVector<f64>) -> Vec<f64> {
    torque_along(motion(), model, values)
}

/// Torque of a motion that repeats, without noise.
fn torque_along(motion: [Vec<f64>; 3], model: &Model, values: &DVector<f64>) -> Vec<f64> {
    let rows = motion[0].len();
    let [q, dq, ddq] = motion.map(|series| vec![series]);
    let motors = Trajectory {
        q: &q,
        dq: &dq,
        ddq: &ddq,
    };
    let step = PERIOD_S / rows as f64;
    let time: Vec<f64> = (0..rows).map(|row| row as f64 * step).collect();
    let segment = Segment {
        time: &time,
        cyclic: true,
        ..Segment::states(motors, false)
    };
    let mut evaluator = Evaluator::along(model, values, &[], rows);
    evaluator.evaluate(segment, 0..rows).value(0).to_vec()
}

/// How a torque is recorded.
#[derive(Debug, Clone, Copy)]
struct Recorder {
    /// N·m of one sample.
    noise: f64,
    /// rad of one sample.
    shake: f64,
    /// Of neighbouring samples of noise.
    correlation: f64,
    /// One row of so many is a sample.
    every: usize,
}

const USUAL: Recorder = Recorder {
    noise: NOISE,
    shake: 0.0,
    correlation: 0.0,
    every: 1,
};

const RED: Recorder = Recorder {
    correlation: 0.7,
    ..USUAL
};

/// With so few samples the five parameters take 8 % of the variance of what a fit leaves.
const SPARSE: Recorder = Recorder { every: 4, ..USUAL };

impl Recorder {
    /// A recording of all periods.
    fn record(self, torque: &[f64], (seed, split): (u64, Split)) -> Prepared {
        let Self {
            noise,
            shake,
            correlation,
            every,
        } = self;
        let mut rng = generator(seed);
        let mut last: f64 = rng.sample(StandardNormal);
        let over_periods = |series: &[f64]| -> Vec<f64> {
            let all = series.iter().cycle().take(PERIODS * ROWS);
            all.step_by(every).copied().collect()
        };
        let noisy = over_periods(torque).into_iter().map(|torque| {
            let fresh: f64 = rng.sample(StandardNormal);
            last = correlation * last + (1.0 - correlation * correlation).sqrt() * fresh;
            torque + noise * last
        });
        let noisy = noisy.collect();
        let mut position = over_periods(&motion()[0]);
        for q in &mut position {
            let fresh: f64 = rng.sample(StandardNormal);
            *q += shake * fresh;
        }
        let recording = Recording::of_samples(format!("seed {seed}"), vec![position], vec![noisy]);
        let preparation = Preparation {
            rate: Some(ROWS as f64 / every as f64 / PERIOD_S),
            period: Some(PERIOD_S),
            ..Preparation::default()
        };
        let experiment = prepare(recording, &preparation).unwrap();
        Prepared::new(format!("seed {seed}"), split, false, experiment)
    }
}

/// What a problem file says is zero is known and has no deviation, whatever is known of the mass; what stands beside it is
/// determined all the same.
#[test]
fn what_is_zero_by_construction_is_known() {
    let mut model = pendulum(&DECLARED);
    let values = valued(&model, &TRUE_FRICTION);
    let torque = torque(&model, &values);
    let zero = ["bob.mcy", "bob.Ixy"];
    for name in zero {
        let index = model.find(name).unwrap();
        model.fix(index, 0.0).unwrap();
    }
    let mass = model.find("bob.m").unwrap();
    let mut weighed = model.clone();
    weighed.fix(mass, 3.0).unwrap();
    for (model, determined) in [(model, Source::Undetermined), (weighed, Source::Data)] {
        for way in WAYS {
            let recordings = vec![USUAL.record(&torque, (1, Split::Train))];
            let found = way.fit(&model, &Dataset { recordings }).estimate.parameters;
            let of = |name: &str| found.iter().find(|p| p.name == name).unwrap();
            for name in ["bob.com_y", "bob.inertia_xy"] {
                let known = of(name);
                assert_eq!(known.source, Source::Known, "{name}, {way:?}");
                assert_eq!(
                    (known.value, known.std_dev, known.ci95),
                    (Some(0.0), None, None)
                );
            }
            if matches!(way, Way::Free(_)) {
                assert_eq!(of("bob.com_x").source, determined, "{way:?}");
            }
        }
    }
}

/// A sine of negative amplitude is one of positive amplitude half a turn further.
#[test]
fn amplitudes_of_sines_are_reported_positive() {
    let mut model = pendulum(&["viscous_friction", "torque_ripple"]);
    let order = model.find("hinge.torque_ripple.order").unwrap();
    model.fix(order, 6.0).unwrap();
    // Searches start at quarter turns from zero, from which these are nearer to the sine of the other sign.
    let sines = [
        ("amplitude", "phase", 0.8, 3.4),
        ("amplitude2", "phase2", 0.5, -3.0),
    ];
    let mut named = vec![("viscous_friction.Fv", 1.5), ("torque_ripple.order", 6.0)];
    let full = |name: &str| format!("torque_ripple.{name}");
    let names: Vec<(String, f64)> = sines
        .iter()
        .flat_map(|(a, p, size, angle)| [(full(a), *size), (full(p), *angle)])
        .collect();
    named.extend(names.iter().map(|(name, value)| (name.as_str(), *value)));
    let torque = torque(&model, &valued(&model, &named));
    for way in WAYS {
        let recordings = vec![USUAL.record(&torque, (1, Split::Train))];
        let fitted = way.fit(&model, &Dataset { recordings });
        for (amplitude, phase, size, angle) in sines {
            let of = |name: &str| {
                let name = format!("hinge.torque_ripple.{name}");
                let all = &fitted.estimate.parameters;
                all.iter().find(|p| p.name == name).unwrap()
            };
            let [low, high] = of(amplitude).ci95.unwrap();
            let half = 0.5 * (high - low);
            // Five standard deviations of what one recording tells.
            let off = (of(amplitude).value.unwrap() - size).abs();
            assert!(off < 2.5 * half, "{way:?}: {:?}", of(amplitude));
            let turns = (of(phase).value.unwrap() - angle) / TAU;
            let deviation = of(phase).std_dev.unwrap() / TAU;
            assert!(of(phase).value.unwrap().abs() <= 0.5 * TAU);
            assert!(
                (turns - turns.round()).abs() < 5.0 * deviation,
                "{way:?}: {:?}",
                of(phase)
            );
        }
    }
}

/// White noise of two periods of so many rows, N·m of one sample.
fn densely_recorded(rows: usize) -> Fitted {
    let model = pendulum(&DECLARED);
    let values = valued(&model, &TRUE_FRICTION);
    let torque = torque_along(motion_in(rows), &model, &values);
    let mut rng = generator(1);
    let noisy = torque.iter().cycle().take(2 * rows).map(|torque| {
        let fresh: f64 = rng.sample(StandardNormal);
        torque + NOISE * fresh
    });
    let noisy = noisy.collect();
    let position = motion_in(rows)[0].repeat(2);
    let recording = Recording::of_samples("dense".to_string(), vec![position], vec![noisy]);
    let preparation = Preparation {
        rate: Some(rows as f64 / PERIOD_S),
        period: Some(PERIOD_S),
        ..Preparation::default()
    };
    let experiment = prepare(recording, &preparation).unwrap();
    let recordings = vec![Prepared::new(
        "dense".to_string(),
        Split::Train,
        false,
        experiment,
    )];
    Way::Free(Estimator::Ordinary).fit(&model, &Dataset { recordings })
}

/// Recordings that are longer than a segment are taken in several: four times the rows of white noise halve every standard
/// deviation, but for a tenth of it, as closely as so many rows tell the noise at the frequencies of the motion.
#[test]
fn standard_deviations_are_the_same_in_segments() {
    let [whole, cut] = [2400, 9600].map(|rows| {
        let found = densely_recorded(rows).fit.base_parameters;
        let all = found.iter().map(|b| b.std_dev.unwrap());
        all.collect::<Vec<f64>>()
    });
    assert_eq!(whole.len(), 5);
    for (whole, cut) in whole.iter().zip(&cut) {
        assert!((2.0 * cut / whole - 1.0).abs() < 0.1, "{whole} {cut}");
    }
}

/// A model of which nothing is open, and recordings with fewer rows than unknowns, cannot be fitted.
#[test]
fn nothing_to_estimate_and_too_few_rows_are_errors() {
    let mut model = pendulum(&DECLARED);
    let values = valued(&model, &TRUE_FRICTION);
    let recordings = vec![USUAL.record(&torque(&model, &values), (1, Split::Train))];
    let data = Dataset { recordings };
    let fitted = |model: &Model, data: &Dataset| {
        let prior = Prior::none(model.parameters().len());
        fit(
            model,
            data,
            Estimator::Ordinary,
            &prior,
            &Control::default(),
        )
        .map(|_| ())
    };
    assert!(fitted(&model, &data).is_ok());
    let few = |rows: usize| {
        let part = data.recordings[0].part(Split::Train, |row| row < rows);
        fitted(
            &model,
            &Dataset {
                recordings: vec![part],
            },
        )
    };
    assert!(matches!(
        few(5),
        Err(EstimateError::TooFewRows {
            rows: 5,
            unknowns: 5
        })
    ));
    assert!(few(6).is_ok());
    for (index, value) in values.iter().enumerate() {
        model.fix(index, *value).unwrap();
    }
    assert!(matches!(
        fitted(&model, &data),
        Err(EstimateError::NothingUnknown)
    ));
}

/// The scatter of the periods is the noise where the residuals are no larger; where physics is missing the residuals are.
#[test]
fn noise_is_that_of_periods_where_residuals_agree_with_it() {
    let source = |declared: &[&str]| {
        let truth = pendulum(&DECLARED);
        let model = pendulum(declared);
        let torque = torque(&truth, &valued(&truth, &TRUE_FRICTION));
        let data = Dataset {
            recordings: vec![USUAL.record(&torque, (1, Split::Train))],
        };
        let prior = Prior::none(model.parameters().len());
        let setup = FitSetup::of(&model, &data, &prior).unwrap();
        let control = Control::default();
        let minimisation = setup.minimisation(Estimator::MaximumLikelihood, &control);
        minimisation.run().unwrap().problem.noise
    };
    assert_eq!(source(&DECLARED), NoiseSource::Periods);
    assert_eq!(source(&["torque_offset"]), NoiseSource::Residuals);
}

/// Among robots of the same torque one is possible, unless the torque is that of a negative moment of inertia.
#[test]
fn a_torque_is_that_of_a_possible_robot_or_of_none() {
    let model = pendulum(&DECLARED);
    let inertia = model.find("bob.Iyy").unwrap();
    let right = valued(&model, &TRUE_FRICTION);
    let mut wrong = right.clone();
    wrong[inertia] = -0.5;
    for (values, possible) in [(right, true), (wrong, false)] {
        let torque = torque(&model, &values);
        for way in WAYS {
            let recordings = vec![USUAL.record(&torque, (1, Split::Train))];
            let found = way.fit(&model, &Dataset { recordings }).fit.feasible;
            // A feasible fit has a possible robot whatever the torque.
            let expected = possible || matches!(way, Way::Feasible(_));
            assert_eq!(found, Some(expected), "{way:?}");
        }
    }
}
