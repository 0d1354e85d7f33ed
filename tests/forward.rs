//! The forward model undoes the chain: torques that the chain gives along a motion lead along that motion.

use exid::chain::controller::{Controller, Gain};
use exid::chain::effect::{Effect, find};
use exid::chain::evaluate::{Evaluator, Segment};
use exid::chain::forward::{Accuracy, Driven, Forward, State, Told};
use exid::chain::model::{Inertials, Model, ModelSettings, Signal};
use exid::robot::batch::Trajectory;
use exid::robot::random::{generator, tree};
use nalgebra::DVector;
use std::f64::consts::TAU;

/// Torques are linear between samples: what that leaves falls with the square of the rate.
const RATE: f64 = 4000.0;
const JOINTS: usize = 3;

const CONTROLLER: Controller = Controller {
    kp: Gain::known(60.0),
    kd: Gain::known(4.0),
};

/// A random arm whose joints have effects, with rotors.
fn model(effects: &[&str], signal: Signal) -> Model {
    let listed: Vec<&'static Effect> = effects.iter().map(|id| find(id).unwrap()).collect();
    let robot = tree(&mut generator(5), JOINTS);
    let settings = ModelSettings {
        inertials: Inertials::Known,
        rotor_inertia: Some(vec![0.3; JOINTS]),
        effects: vec![listed; JOINTS],
        torque_constant: (signal == Signal::Current).then(|| vec![7.0; JOINTS]),
        controllers: (signal == Signal::PositionCommand).then(|| vec![CONTROLLER; JOINTS]),
        ..ModelSettings::bodies(robot, signal)
    };
    Model::new(settings).unwrap()
}

/// Values by the names of parameters of all joints.
fn values(model: &Model, given: &[(&str, f64)]) -> DVector<f64> {
    let mut values = model.values();
    for (p, parameter) in model.parameters().iter().enumerate() {
        for (name, value) in given {
            if parameter.name.ends_with(name) {
                values[p] = *value;
            }
        }
    }
    values
}

struct Course {
    time: Vec<f64>,
    motion: [Vec<Vec<f64>>; 3],
}

/// Sines of different frequencies, two seconds that repeat.
fn course() -> Course {
    let time: Vec<f64> = (0..(2.0 * RATE) as usize)
        .map(|k| k as f64 / RATE)
        .collect();
    let wave = |j: usize, order: usize| -> Vec<f64> {
        let (w, a) = (TAU * 0.5 * (j + 1) as f64, 0.5 / (j + 1) as f64);
        let phase = 0.4 + j as f64 + 0.25 * TAU * order as f64;
        let of = |t: &f64| a * w.powi(order as i32) * (w * t + phase).sin();
        time.iter().map(of).collect()
    };
    let motion = [0, 1, 2].map(|order| (0..JOINTS).map(|j| wave(j, order)).collect());
    Course { time, motion }
}

/// Torques of the motors along the course by the chain.
fn torques(model: &Model, values: &DVector<f64>, course: &Course) -> Vec<Vec<f64>> {
    let [q, dq, ddq] = &course.motion;
    let segment = Segment {
        time: &course.time,
        temperature: &[],
        cyclic: true,
        ..Segment::states(Trajectory { q, dq, ddq }, false)
    };
    let mut evaluator = Evaluator::along(model, values, &[], course.time.len());
    let block = evaluator.evaluate_whole(segment);
    (0..JOINTS).map(|c| block.value(c).to_vec()).collect()
}

fn at(series: &[Vec<f64>], k: usize) -> Vec<f64> {
    series.iter().map(|s| s[k]).collect()
}

/// The state at a sample, of what follows the motion from the start.
fn followed(forward: &mut Forward<'_>, course: &Course, until: usize) -> State {
    let [q, dq, ddq] = &course.motion;
    let mut state = forward.settled(&at(q, 0), &at(dq, 0));
    // Twists forget how they began within a period.
    let rows = course.time.len();
    for k in 0..rows + until {
        let (k, next) = (k % rows, (k + 1) % rows);
        let mean: Vec<f64> = (0..JOINTS)
            .map(|j| 0.5 * (ddq[j][k] + ddq[j][next]))
            .collect();
        let driven = Driven::Motion {
            acceleration: &mean,
        };
        forward.advance(&mut state, driven, 1.0 / RATE).unwrap();
        for j in 0..JOINTS {
            (state.position[j], state.velocity[j]) = (q[j][next], dq[j][next]);
        }
    }
    state
}

/// Largest distance from the course within half a second from its middle.
fn distance(effects: &[&str], given: &[(&str, f64)], accuracy: Accuracy) -> f64 {
    let (course, model) = (course(), model(effects, Signal::Torque));
    let values = values(&model, given);
    let torque = torques(&model, &values, &course);
    let mut forward = Forward::new(&model, &values, false, accuracy).unwrap();
    let begin = (0.6 * RATE) as usize;
    let mut state = followed(&mut forward, &course, begin);
    forward.begin();
    let mut most = 0.0_f64;
    for k in begin..begin + (0.5 * RATE) as usize {
        let (from, to) = (at(&torque, k), at(&torque, k + 1));
        let driven = Driven::Torque {
            from: &from,
            to: &to,
        };
        forward.advance(&mut state, driven, 1.0 / RATE).unwrap();
        let pairs = state.position.iter().zip(at(&course.motion[0], k + 1));
        most = pairs.fold(most, |most, (x, q)| most.max((x - q).abs()));
    }
    most
}

const FRICTION: [&str; 2] = ["coulomb_friction", "viscous_friction"];
const SMOOTH: [(&str, f64); 3] = [
    ("coulomb_friction.Fc", 1.0),
    ("coulomb_friction.w", 0.2),
    ("viscous_friction.Fv", 2.0),
];

fn with<'a>(effects: &[&'a str], given: &[(&'a str, f64)]) -> (Vec<&'a str>, Vec<(&'a str, f64)>) {
    let effects = FRICTION.iter().chain(effects).copied().collect();
    (effects, SMOOTH.iter().chain(given).copied().collect())
}

#[test]
fn invariant_torques_of_a_smooth_model_lead_along_its_motion() {
    let (effects, given) = with(&[], &[]);
    let far = distance(&effects, &given, Accuracy::default());
    let near = distance(&effects, &given, Accuracy::default().halved());
    println!("friction {far:e}, halved {near:e}");
    assert!(far < 1e-6, "{far:e}");
}

#[test]
fn invariant_losses_lead_along_the_motion() {
    let (effects, given) = with(
        &["transmission_efficiency", "load_dependent_friction"],
        &[("efficiency.R", 0.8), ("friction.mu", 0.05)],
    );
    let far = distance(&effects, &given, Accuracy::default());
    println!("losses {far:e}");
    assert!(far < 2e-6, "{far:e}");
}

#[test]
fn invariant_bristles_lead_along_the_motion() {
    let (effects, given) = with(
        &["presliding_hysteresis"],
        &[
            ("sigma0", 300.0),
            ("sigma1", 0.5),
            ("hysteresis.Fs", 0.2),
            ("hysteresis.vs", 0.1),
        ],
    );
    let far = distance(&effects, &given, Accuracy::default());
    println!("bristles {far:e}");
    assert!(far < 2e-6, "{far:e}");
}

#[test]
fn invariant_an_elastic_gear_leads_along_the_motion() {
    let (effects, given) = with(
        &["joint_elasticity"],
        &[("elasticity.K", 3e3), ("elasticity.D", 30.0)],
    );
    let far = distance(&effects, &given, Accuracy::default());
    println!("elastic {far:e}");
    assert!(far < 2e-6, "{far:e}");
}

#[test]
fn invariant_play_leads_along_the_motion() {
    let (effects, given) = with(
        &["joint_elasticity", "backlash"],
        &[
            ("elasticity.K", 3e3),
            ("elasticity.D", 30.0),
            ("backlash.gap", 4e-3),
        ],
    );
    let far = distance(&effects, &given, Accuracy::default());
    println!("play {far:e}");
    assert!(far < 2e-6, "{far:e}");
}

/// Half of it is no controller that leads along the motion: the error of its position alone is larger than the bound by far.
#[test]
fn invariant_commands_lead_along_the_motion() {
    let effects = with(&["drive_gain"], &[("drive_gain.gain", 1.2)]);
    let (course, model) = (course(), model(&effects.0, Signal::PositionCommand));
    let values = values(&model, &effects.1);
    let errors = torques(&model, &values, &course);
    let mut forward = Forward::new(&model, &values, false, Accuracy::default()).unwrap();
    assert!(forward.is_controlled());
    let aims = |k: usize| -> Vec<f64> {
        let of = |j: usize| Told {
            position: course.motion[0][j][k] + errors[j][k],
            ..Told::default()
        };
        (0..JOINTS).map(|j| forward.aim(j, of(j))).collect()
    };
    let rows: Vec<Vec<f64>> = (0..=(0.5 * RATE) as usize).map(aims).collect();
    let mut state = forward.settled(&at(&course.motion[0], 0), &at(&course.motion[1], 0));
    let mut most = 0.0_f64;
    for (k, pair) in rows.windows(2).enumerate() {
        let driven = Driven::Command {
            from: &pair[0],
            to: &pair[1],
        };
        forward.advance(&mut state, driven, 1.0 / RATE).unwrap();
        let pairs = state.position.iter().zip(at(&course.motion[0], k + 1));
        most = pairs.fold(most, |most, (x, q)| most.max((x - q).abs()));
    }
    println!("commands {most:e}");
    assert!(most < 2e-6, "{most:e}");
}
