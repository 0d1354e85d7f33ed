//! Recordings without a torque channel: positions and what a position controller was told.
//!
//! The recordings are those of a pendulum of its own equation, about an axis y with gravity along −z,
//!
//! ```text
//! τ = (I + m l²) q̈ − m g l cos q + Fc q̇/(|q̇| + w) + Fv q̇,   q_c = q + (τ + kd (q̇ − v_c) − u) / kp
//! ```
//!
//! with the noise of the encoder on q, and so in the error q_c − q as well.

#[path = "../common/mod.rs"]
mod common;
mod real_legs;
mod verbs;

use exid::chain::controller::{Commands, Controller, Gain};
use exid::chain::dataset::{Dataset, Prepared};
use exid::chain::effect;
use exid::chain::model::{Inertials, Model, ModelSettings, Signal};
use exid::chain::prior::Prior;
use exid::estimate::estimator::Estimator;
use exid::estimate::fit::{Fitted, fit};
use exid::outcome::parameter::Source;
use exid::problem::solution::Control;
use exid::recording::preprocess::prepare;
use exid::recording::samples::Recording;
use exid::recording::settings::Preparation;
use exid::recording::split::Split;
use exid::robot::random::generator;
use exid::robot::urdf;
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

const SEEDS: u64 = 250;
const RATE_HZ: f64 = 200.0;
const PERIOD_S: f64 = 6.0;
const PERIODS: usize = 5;
/// rad, of the encoder.
const NOISE: f64 = 5e-4;
const MASS: f64 = 2.0;
const LEVER: f64 = 0.2;
const INERTIA: f64 = 0.02;
const KP: f64 = 30.0;
const KD: f64 = 1.2;
const COULOMB: f64 = 0.3;
const VISCOUS: f64 = 0.25;
const WIDTH: f64 = 0.05;
/// s
const LATE: f64 = 0.012;
/// m/s², by which a gain is known to about a sixth.
const WEAK: f64 = 0.005;

const PENDULUM: &str = r#"<robot name="pendulum"><link name="base"/>
<link name="arm"><inertial><origin xyz="0.2 0 0"/><mass value="2.0"/>
<inertia ixx="0.005" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="10" effort="50"/></joint></robot>"#;

fn folder(name: &str) -> std::path::PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("position_command")
        .join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn model(name: &str, of: (Inertials, Controller), effects: &[&str]) -> Model {
    model_under(name, of, (effects, USUAL.gravity))
}

fn model_under(
    name: &str,
    (inertials, controller): (Inertials, Controller),
    (effects, gravity): (&[&str], f64),
) -> Model {
    let file = folder(name).join("pendulum.urdf");
    fs::write(&file, PENDULUM).unwrap();
    let effects = effects.iter().map(|id| effect::find(id).unwrap()).collect();
    let settings = ModelSettings {
        inertials,
        controllers: Some(vec![controller]),
        effects: vec![effects],
        ..ModelSettings::bodies(
            urdf::read(&file)
                .unwrap()
                .with_gravity([0.0, 0.0, -gravity]),
            Signal::PositionCommand,
        )
    };
    let mut model = Model::new(settings).unwrap();
    let width = model.joints()[0].width.unwrap();
    model.fix(width, WIDTH).unwrap();
    model
}

/// q, q̇ and q̈ of the pendulum at a time.
fn motion(t: f64) -> [f64; 3] {
    let terms = [
        (1.0, 0.5, 0.3),
        (3.0, 0.25, 1.1),
        (7.0, 0.06, 2.0),
        (11.0, 0.02, 0.4),
    ];
    terms
        .iter()
        .fold([-0.3, 0.0, 0.0], |sum, (h, size, phase)| {
            let w = TAU * h / PERIOD_S;
            let (s, c) = (w * t + phase).sin_cos();
            [
                sum[0] + size * s,
                sum[1] + size * w * c,
                sum[2] - size * w * w * s,
            ]
        })
}

/// Commanded speed and torque that is fed forward at a time.
fn commanded(t: f64) -> [f64; 2] {
    let w = TAU / PERIOD_S;
    [0.8 * (2.0 * w * t).cos(), 1.5 * (w * t).sin()]
}

/// Under an acceleration of gravity in m/s².
fn torque([q, dq, ddq]: [f64; 3], gravity: f64) -> f64 {
    (INERTIA + MASS * LEVER * LEVER) * ddq - MASS * gravity * LEVER * q.cos()
        + COULOMB * dq / (dq.abs() + WIDTH)
        + VISCOUS * dq
}

/// What a recording is made under.
#[derive(Clone, Copy)]
struct Setting {
    /// s by which a command acts late.
    late: f64,
    /// m/s²
    gravity: f64,
}

const USUAL: Setting = Setting {
    late: 0.0,
    gravity: 9.81,
};

/// The position that a controller is told at a time.
fn command(t: f64, setting: Setting, told: [f64; 2]) -> f64 {
    let then = motion(t + setting.late);
    then[0] + (torque(then, setting.gravity) + KD * (then[1] - told[0]) - told[1]) / KP
}

fn times() -> Vec<f64> {
    let samples = (PERIODS as f64 * PERIOD_S * RATE_HZ) as usize;
    (0..samples).map(|k| k as f64 / RATE_HZ).collect()
}

/// Speed and feed-forward torque that a controller is told at a time.
type Told = fn(f64) -> [f64; 2];

/// A recording, with commands of speed and torque where `told` is.
fn recorded(seed: u64, told: Option<Told>, setting: Setting) -> Dataset {
    let mut rng = generator(seed);
    let times = times();
    let beside: Vec<[f64; 2]> = times
        .iter()
        .map(|t| told.map_or([0.0; 2], |f| f(*t)))
        .collect();
    let position: Vec<f64> = (times.iter())
        .map(|t| motion(*t)[0] + NOISE * rng.sample::<f64, _>(StandardNormal))
        .collect();
    let commands = times
        .iter()
        .zip(&beside)
        .map(|(t, told)| command(*t, setting, *told));
    let of = Recording::of_samples("pendulum.csv", vec![position], vec![commands.collect()]);
    let preparation = Preparation {
        rate: Some(RATE_HZ),
        period: Some(PERIOD_S),
        ..Preparation::default()
    };
    let experiment = prepare(of.with_position_errors(), &preparation).unwrap();
    let series = |k: usize| vec![beside[..experiment.rows()].iter().map(|b| b[k]).collect()];
    let commands = told.map(|_| Commands {
        velocity: series(0),
        feed_forward: series(1),
    });
    let prepared = Prepared::new("train".into(), Split::Train, false, experiment);
    Dataset {
        recordings: vec![prepared.with_commands(commands)],
    }
}

fn fitted(model: &Model, data: &Dataset) -> Fitted {
    let prior = Prior::none(model.parameters().len());
    let estimator = Estimator::MaximumLikelihood;
    fit(model, data, estimator, &prior, &Control::default()).unwrap()
}

/// Interval of a parameter, or of a base parameter.
fn interval(fitted: &Fitted, name: &str) -> [f64; 2] {
    let parameters = fitted.estimate.parameters.iter();
    let own = parameters.filter(|p| p.name == name).find_map(|p| p.ci95);
    let base = &fitted.fit.base_parameters;
    let of_base = || base.iter().find(|b| b.expression == name)?.ci95;
    own.or_else(of_base)
        .unwrap_or_else(|| panic!("{name} is not among {base:#?}"))
}

/// Share of the intervals that hold the truth, over all seeds, of each of some parameters.
fn coverage(
    model: &Model,
    told: Option<Told>,
    setting: Setting,
    truth: &[(&str, f64)],
) -> Vec<f64> {
    let covers = |seed: u64| -> Vec<bool> {
        let fitted = fitted(model, &recorded(seed, told, setting));
        let holds = |(name, value): &(&str, f64)| {
            let [low, high] = interval(&fitted, name);
            (low..=high).contains(value)
        };
        truth.iter().map(holds).collect()
    };
    let all: Vec<Vec<bool>> = (0..SEEDS).into_par_iter().map(covers).collect();
    let share = |k: usize| all.iter().filter(|c| c[k]).count() as f64 / SEEDS as f64;
    (0..truth.len()).map(share).collect()
}

fn assert_honest(shares: &[f64], truth: &[(&str, f64)]) {
    let together = shares.iter().sum::<f64>() / shares.len() as f64;
    eprintln!("{together:.4} {shares:?} {truth:?}");
    assert!((0.93..=0.97).contains(&together), "{together} {shares:?}");
    // Each within four standard deviations of a share of so many seeds.
    let slack = 4.0 * (0.95 * 0.05 / SEEDS as f64).sqrt();
    assert!(
        shares.iter().all(|s| (s - 0.95).abs() < slack),
        "{shares:?}"
    );
}

const FRICTION: &[&str] = &["coulomb_friction", "viscous_friction"];

/// Both gains with friction: gravity on a known mass tells kp, a commanded speed kd from viscous friction.
#[test]
fn intervals_of_unknown_gains_and_friction_cover_the_truth() {
    let controller = Controller {
        kp: Gain::free(1.0),
        kd: Gain::free(0.0),
    };
    let model = model("gains", (Inertials::Known, controller), FRICTION);
    let truth = [
        ("hinge.controller.kp", KP),
        ("hinge.controller.kd", KD),
        ("hinge.coulomb_friction.Fc", COULOMB),
        ("hinge.viscous_friction.Fv", VISCOUS),
    ];
    assert_honest(&coverage(&model, Some(commanded), USUAL, &truth), &truth);
}

/// Almost no gravity on the axis, and a rotor whose inertia is not known: the gain is known to a sixth, and its interval is not
/// symmetric about it.
#[test]
fn intervals_of_a_gain_that_is_hardly_told_cover_the_truth() {
    let controller = Controller {
        kp: Gain::free(1.0),
        kd: Gain::known(KD),
    };
    let setting = Setting {
        gravity: WEAK,
        ..USUAL
    };
    let effects = [FRICTION, &["rotor_inertia"]].concat();
    let model = model_under("weak", (Inertials::Known, controller), (&effects, WEAK));
    let truth = [
        ("hinge.controller.kp", KP),
        ("hinge.coulomb_friction.Fc", COULOMB),
        ("hinge.viscous_friction.Fv", VISCOUS),
    ];
    let one = fitted(&model, &recorded(0, None, setting));
    let kp = one
        .estimate
        .parameters
        .iter()
        .find(|p| p.name == truth[0].0)
        .unwrap();
    let share = kp.std_dev.unwrap() / kp.value.unwrap();
    assert!((0.1..0.4).contains(&share), "{share}");
    let [low, high] = kp.ci95.unwrap();
    assert!(
        high - kp.value.unwrap() > 1.2 * (kp.value.unwrap() - low),
        "{kp:?}"
    );
    assert_honest(&coverage(&model, None, setting, &truth), &truth);
}

/// A known gain tells masses.
#[test]
fn intervals_of_masses_cover_the_truth_where_the_gains_are_known() {
    let controller = Controller {
        kp: Gain::known(KP),
        kd: Gain::known(KD),
    };
    let model = model("masses", (Inertials::Estimate, controller), FRICTION);
    let truth = [
        ("arm.mcx", MASS * LEVER),
        ("arm.mcz", 0.0),
        ("arm.Iyy", INERTIA + MASS * LEVER * LEVER),
        ("hinge.coulomb_friction.Fc", COULOMB),
    ];
    assert_honest(&coverage(&model, None, USUAL, &truth), &truth);
}

/// With neither masses nor gains known, there are ratios to kp, and no solution of zeros.
#[test]
fn intervals_of_ratios_cover_the_truth_where_nothing_is_known() {
    let controller = Controller {
        kp: Gain::free(1.0),
        kd: Gain::known(0.0),
    };
    let model = model("ratios", (Inertials::Estimate, controller), FRICTION);
    let truth = [
        ("arm.mcx / hinge.controller.kp", MASS * LEVER / KP),
        (
            "hinge.coulomb_friction.Fc / hinge.controller.kp",
            COULOMB / KP,
        ),
        (
            "hinge.viscous_friction.Fv / hinge.controller.kp",
            (VISCOUS + KD) / KP,
        ),
    ];
    assert_honest(&coverage(&model, None, USUAL, &truth), &truth);
    let one = fitted(&model, &recorded(0, None, USUAL));
    let kp = one
        .estimate
        .parameters
        .iter()
        .find(|p| p.name == "hinge.controller.kp")
        .unwrap();
    assert_eq!((kp.source, kp.value), (Source::Undetermined, None));
    let friction = (one.estimate.parameters.iter()).find(|p| p.name == "hinge.coulomb_friction.Fc");
    assert_eq!(friction.unwrap().value, None);
    let notes = one.fit.notes.join("\n");
    assert!(
        notes.contains("hinge.controller.kp is not determined"),
        "{notes}"
    );
    assert!(notes.contains("known mass"), "{notes}");
}

/// What a gain is known by before the data is in every interval.
#[test]
fn a_gain_with_a_standard_deviation_widens_the_intervals() {
    let controller = Controller {
        kp: Gain::free(KP),
        kd: Gain::known(KD),
    };
    let model = model("prior", (Inertials::Estimate, controller), FRICTION);
    let kp = model.find("hinge.controller.kp").unwrap();
    let mut row = DMatrix::zeros(1, model.parameters().len());
    row[(0, kp)] = 1.0;
    let mean = DVector::from_element(1, KP);
    let share = 0.1;
    let variance = DMatrix::from_element(1, 1, (share * KP).powi(2));
    let prior = Prior::new(&row, &mean, &variance);
    let estimator = Estimator::MaximumLikelihood;
    let data = recorded(3, None, USUAL);
    let fitted = fit(&model, &data, estimator, &prior, &Control::default()).unwrap();
    let base = fitted
        .fit
        .base_parameters
        .iter()
        .find(|b| b.expression == "arm.mcx")
        .unwrap();
    let relative = base.std_dev.unwrap() / base.value.unwrap();
    // The data alone tell the ratio to a part in a thousand.
    assert!((relative / share - 1.0).abs() < 0.02, "{relative}");
}

/// A command that acts late is not a signal that is late: the position is read at its own time.
#[test]
fn recovers_the_time_by_which_a_command_acts_late() {
    let controller = Controller {
        kp: Gain::free(1.0),
        kd: Gain::known(KD),
    };
    let effects = [FRICTION, &["time_delay"]].concat();
    let model = model("late", (Inertials::Known, controller), &effects);
    let fitted = fitted(
        &model,
        &recorded(
            5,
            None,
            Setting {
                late: LATE,
                ..USUAL
            },
        ),
    );
    for (name, value) in [
        ("hinge.time_delay.delay", LATE),
        ("hinge.controller.kp", KP),
    ] {
        let [low, high] = interval(&fitted, name);
        let middle = 0.5 * (low + high);
        let deviation = (high - low) / (2.0 * 1.96);
        assert!(
            (middle - value).abs() < 4.0 * deviation,
            "{name}: {low} {high}"
        );
        assert!(deviation < 0.02 * value, "{name}: {low} {high}");
    }
}
