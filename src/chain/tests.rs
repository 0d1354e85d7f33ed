//! The chain as a whole: derivatives of the signal in every kind of parameter, and known bases.

use crate::chain::base_parameters::BaseParameters;
use crate::chain::effect::{EFFECTS, Effect, Law, find};
use crate::chain::evaluate::{BLOCK, Block, Evaluator, KnownBodies, Segment};
use crate::chain::model::{JointModel, Model, ModelSettings, Payload, Signal};
use crate::chain::parameter::Role;
use crate::robot::batch::Trajectory;
use crate::robot::mdh;
use crate::robot::random::{body, generator, symmetric, tree};
use crate::robot::tree::Tree;
use nalgebra::{DMatrix, DVector, Isometry3, Vector3};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

mod laws;

/// The same effects on every joint.
fn settings(tree: Tree, (effects, signal): (&[&'static Effect], Signal)) -> ModelSettings {
    let n = tree.len();
    ModelSettings {
        torque_constant: (signal == Signal::Current).then(|| vec![11.0; n]),
        coupling: Some(DMatrix::from_fn(n, n, |i, j| {
            if i == j {
                1.0
            } else {
                0.1 / (1.0 + i as f64 + 2.0 * j as f64)
            }
        })),
        offset: Some((0..n).map(|k| 0.1 * k as f64).collect()),
        effects: vec![effects.to_vec(); n],
        payload: Some(Payload {
            link: n - 1,
            frame: Isometry3::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.4, 0.5, -0.6)),
        }),
        locked: vec![false; n],
        ..ModelSettings::bodies(tree, signal)
    }
}

fn motion(rng: &mut ChaCha8Rng, n: usize, samples: usize) -> [Vec<Vec<f64>>; 3] {
    [3.0, 2.0, 8.0].map(|range| {
        (0..n)
            .map(|_| (0..samples).map(|_| symmetric(rng, range)).collect())
            .collect()
    })
}

/// A model whose parameters all have values: the robot's own bodies, the rest near typical.
fn valued(physics: (&[&'static Effect], Signal), rng: &mut ChaCha8Rng) -> Model {
    let robot = tree(rng, 4);
    with_values(settings(robot, physics), rng)
}

/// The same of a robot with settings of its own.
fn with_values(settings: ModelSettings, rng: &mut ChaCha8Rng) -> Model {
    let mut model = Model::new(settings).unwrap();
    let load = body(rng);
    for p in 0..model.parameters().len() {
        let parameter = &model.parameters()[p];
        let value = match parameter.role {
            Role::Inertial { link, quantity } => model.tree().joints()[link].inertia.0[quantity],
            Role::Payload { quantity } => load.0[quantity],
            _ => parameter.scale * (1.0 + symmetric(rng, 0.5)),
        };
        model.start(p, value);
    }
    model
}

/// A smooth motion that repeats: three harmonics of 1.6 s.
fn smooth_motion(rng: &mut ChaCha8Rng, n: usize, samples: usize) -> [Vec<Vec<f64>>; 3] {
    let mut motion: [Vec<Vec<f64>>; 3] = std::array::from_fn(|_| vec![vec![0.0; samples]; n]);
    for j in 0..n {
        for h in 1..=3 {
            let (a, phase) = (symmetric(rng, 0.6 / f64::from(h)), symmetric(rng, 3.0));
            let rate = std::f64::consts::TAU * f64::from(h) / 1.6;
            for k in 0..samples {
                let (s, c) = (rate * 1.6 * k as f64 / samples as f64 + phase).sin_cos();
                motion[0][j][k] += a * s;
                motion[1][j][k] += a * rate * c;
                motion[2][j][k] -= a * rate * rate * s;
            }
        }
    }
    motion
}

fn assert_derivative(model: &Model, (block, segment): (&Block, Segment<'_>), p: usize) {
    let parameter = &model.parameters()[p];
    let h = 1e-5 * parameter.scale;
    // A lag is found by iteration to 1e-11 of itself, which stiff flanks hand on to the torque.
    let rounding = match model.joints().iter().any(JointModel::has_lag) {
        true => 1e-12,
        false => 1e-15,
    };
    let at = |step: f64| {
        let mut moved = model.values();
        moved[p] += step;
        let samples = segment.motors.len();
        Evaluator::along(model, &moved, &[], samples)
            .evaluate_whole(segment)
            .clone()
    };
    let (high, low) = (at(h), at(-h));
    for c in 0..model.channels().len() {
        let size = block.value(c).iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for k in 0..segment.motors.len() {
            let expected = (high.value(c)[k] - low.value(c)[k]) / (2.0 * h);
            let got = block.derivative(c, p).map_or(0.0, |series| series[k]);
            // Rounding of the values over the step, and the third derivative in the step.
            let bound = rounding * size / h + 1e-5 * expected.abs().max(0.1);
            let name = &parameter.name;
            assert!(
                (got - expected).abs() <= bound,
                "{name} {c} {got} {expected}"
            );
        }
    }
}

/// Derivatives in every parameter along a smooth motion, against differences.
fn assert_derivatives(effects: &[&'static Effect], signal: Signal, seed: u64) {
    const SAMPLES: usize = 80;
    let mut rng = generator(seed);
    let model = valued((effects, signal), &mut rng);
    let all: Vec<usize> = (0..model.parameters().len()).collect();
    let [q, dq, ddq] = smooth_motion(&mut rng, 4, SAMPLES);
    let time: Vec<f64> = (0..SAMPLES)
        .map(|k| 1.6 * k as f64 / SAMPLES as f64)
        .collect();
    let segment = Segment {
        motors: Trajectory {
            q: &q,
            dq: &dq,
            ddq: &ddq,
        },
        forces: &[],
        commands: None,
        bodies: None,
        time: &time,
        temperature: &[],
        cyclic: seed.is_multiple_of(2),
        loaded: true,
    };
    let block = Evaluator::along(&model, &model.values(), &all, SAMPLES)
        .evaluate_whole(segment)
        .clone();
    for &p in &all {
        assert_derivative(&model, (&block, segment), p);
    }
    assert_known_bodies(&model, segment);
}

/// With what the bodies do kept from other values of their parameters, the signal and its derivatives are the same.
fn assert_known_bodies(model: &Model, segment: Segment<'_>) {
    let role = |p: &usize| model.parameters()[*p].role;
    let keeps = |p: &usize| !model.moves_bodies(*p);
    let columns: Vec<usize> = (0..model.parameters().len()).filter(keeps).collect();
    let of_bodies = columns.iter().filter(|p| role(p).is_inertial());
    let mut others = model.values();
    for &p in of_bodies {
        others[p] *= 1.5;
    }
    let known = KnownBodies::linear(model, &others, &columns, segment).unwrap();
    assert_same_with(&known, (model, &columns, model.values()), segment);
}

/// With bodies that are known the signal and its derivatives at `values` are those of the model.
fn assert_same_with(
    known: &KnownBodies,
    (model, columns, values): (&Model, &[usize], DVector<f64>),
    segment: Segment<'_>,
) {
    let known = Segment {
        bodies: Some(known),
        ..segment
    };
    let [anew, kept] = [(segment, model.values()), (known, values)].map(|(segment, values)| {
        let samples = segment.motors.len();
        let mut evaluator = Evaluator::along(model, &values, columns, samples);
        evaluator.evaluate_whole(segment).clone()
    });
    let assert_same = |a: &[f64], b: &[f64]| {
        let size = a.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let differ = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        // Sums of a hundred terms in another order, which the current's polynomial hands on.
        assert!(differ.fold(0.0, f64::max) <= 1e-11 * size.max(1.0));
    };
    for c in 0..model.channels().len() {
        assert_same(anew.value(c), kept.value(c));
        for k in 0..columns.len() {
            let none = vec![0.0; segment.motors.len()];
            let [a, b] =
                [&anew, &kept].map(|block| block.derivative(c, k).unwrap_or(&none).to_vec());
            assert_same(&a, &b);
        }
    }
}

/// Where the links have settled behind their motors, laws of the drives leave them where they are.
#[test]
fn matches_itself_with_links_that_have_settled() {
    const SAMPLES: usize = 80;
    let ids = [
        "coulomb_friction",
        "transmission_efficiency",
        "torque_ripple",
        "joint_spring",
        "joint_elasticity",
    ];
    let effects = ids.map(|id| find(id).unwrap());
    for (seed, signal) in (60..).zip(SIGNALS) {
        let mut rng = generator(seed);
        let model = valued((&effects, signal), &mut rng);
        let [q, dq, ddq] = smooth_motion(&mut rng, 4, SAMPLES);
        let time: Vec<f64> = (0..SAMPLES).map(|k| 0.02 * k as f64).collect();
        let segment = Segment {
            time: &time,
            temperature: &[],
            cyclic: seed.is_multiple_of(2),
            ..Segment::states(
                Trajectory {
                    q: &q,
                    dq: &dq,
                    ddq: &ddq,
                },
                true,
            )
        };
        let is_of_drive = |p: &usize| match model.parameters()[*p].role {
            Role::Effect { joint, effect, .. } => {
                let (effect, _) = model.joints()[joint].effects[effect];
                matches!(effect.law, Law::Motor(_) | Law::Transmission(_))
            }
            _ => false,
        };
        let columns: Vec<usize> = (0..model.parameters().len()).filter(is_of_drive).collect();
        let mut evaluator = Evaluator::along(&model, &model.values(), &[], SAMPLES);
        let settled = evaluator.settled_bodies(segment);
        // Springs of other gears do not move links that have settled.
        let mut values = model.values();
        for joint in model.joints() {
            values[joint.elasticity.unwrap()] *= 1.5;
        }
        assert_same_with(&settled, (&model, &columns, values), segment);
    }
}

/// What a channel does not depend on is left out where it is asked for alone: its signal and its derivatives stay.
#[test]
fn a_channel_alone_is_what_it_is_beside_the_others() {
    const SAMPLES: usize = 80;
    for (seed, late) in (80..).zip([&["time_delay"][..], &[]]) {
        let mut rng = generator(seed);
        let robot = tree(&mut rng, 4);
        let ids = ["coulomb_friction", "joint_spring", "external_contact"];
        let of_all: Vec<_> = ids.iter().chain(late).map(|id| find(id).unwrap()).collect();
        let mut settings = ModelSettings {
            coupling: None,
            ..settings(robot, (&of_all, Signal::Torque))
        };
        settings.effects[1].push(find("joint_elasticity").unwrap());
        let model = with_values(settings, &mut rng);
        let columns: Vec<usize> = (0..model.parameters().len()).collect();
        let [q, dq, ddq] = smooth_motion(&mut rng, 4, SAMPLES);
        let time: Vec<f64> = (0..SAMPLES).map(|k| 0.02 * k as f64).collect();
        let motors = Trajectory {
            q: &q,
            dq: &dq,
            ddq: &ddq,
        };
        let segment = Segment {
            time: &time,
            cyclic: true,
            ..Segment::states(motors, true)
        };
        let evaluated = |model: &Model| {
            let mut evaluator = Evaluator::along(model, &model.values(), &columns, SAMPLES);
            evaluator.evaluate_whole(segment).clone()
        };
        let together = evaluated(&model);
        for c in 0..model.channels().len() {
            let mut of_one = model.clone();
            of_one.predict_only(c);
            let alone = evaluated(&of_one);
            assert_eq!(alone.value(c), together.value(c), "{late:?}, channel {c}");
            for k in 0..columns.len() {
                let [one, all] = [&alone, &together].map(|block| block.derivative(c, k));
                let name = &model.parameters()[k].name;
                assert_eq!(one, all, "{late:?}, channel {c}, {name}");
            }
        }
    }
}

const SIGNALS: [Signal; 4] = [
    Signal::Current,
    Signal::Torque,
    Signal::LinkTorque,
    Signal::Both,
];

#[test]
fn matches_differences_of_the_signal_with_every_effect() {
    for (k, effect) in EFFECTS.iter().enumerate() {
        let with_lenders: Vec<&'static Effect> = effect
            .needs
            .borrows
            .iter()
            .filter_map(|(lender, _)| find(lender))
            .chain([*effect])
            .collect();
        for (seed, signal) in (10 * k as u64..).zip(SIGNALS) {
            println!("{} {signal:?}", effect.id);
            assert_derivatives(&with_lenders, signal, seed);
        }
    }
}

#[test]
fn matches_differences_of_the_signal_with_all_effects_without_lag() {
    let rigid: Vec<&'static Effect> = EFFECTS
        .iter()
        .copied()
        .filter(|effect| !matches!(effect.law, Law::Spring | Law::Play))
        .collect();
    for (seed, signal) in (40..).zip(SIGNALS) {
        assert_derivatives(&rigid, signal, seed);
    }
}

fn panda() -> Tree {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/panda_like/panda_like.mdh.toml");
    mdh::read(&path).unwrap()
}

fn plain(tree: Tree, effects: &[&str]) -> ModelSettings {
    let list: Vec<_> = effects
        .iter()
        .map(|id| crate::chain::effect::find(id).unwrap())
        .collect();
    ModelSettings {
        torque_constant: None,
        coupling: None,
        offset: None,
        payload: None,
        ..settings(tree, (&list, Signal::Torque))
    }
}

fn structural(model: &Model) -> BaseParameters {
    let no_prior = DMatrix::zeros(0, model.parameters().len());
    BaseParameters::structural(model, &[false], &no_prior)
}

#[test]
fn matches_published_number_of_base_parameters_of_the_panda() {
    // Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca 2019: 43 dynamic coefficients.
    let model = Model::new(plain(panda(), &[])).unwrap();
    let base = structural(&model);
    assert_eq!(base.base.len(), 43);
    let first = base.expression(&model, 0);
    assert!(first.starts_with("link1.Izz + link2.Iyy"), "{first}");
}

#[test]
fn invariant_friction_and_rotors_add_what_they_should() {
    let effects = [
        "coulomb_friction",
        "viscous_friction",
        "rotor_inertia",
        "torque_offset",
    ];
    let mut model = Model::new(plain(panda(), &effects)).unwrap();
    for j in 0..7 {
        let width = model.joints()[j].width.unwrap();
        model.fix(width, 0.0).unwrap();
    }
    let base = structural(&model);
    // Fc, Fv and offset of seven joints; the rotors of joints 1 and 2 are the same torque as link
    // inertias about parallel axes (Gautier 1990), those of joints 3 to 7 are their own.
    assert_eq!(base.base.len(), 43 + 3 * 7 + 5);
    let lone = model.find("joint4.rotor_inertia.Jm").unwrap();
    assert!(base.determines(lone));
    let grouped = model.find("joint1.rotor_inertia.Jm").unwrap();
    assert!(!base.determines(grouped));
}

#[test]
fn invariant_signal_is_that_of_the_base_parameters_alone() {
    let model = Model::new(plain(panda(), &[])).unwrap();
    let base = structural(&model);
    let mut full = model.values();
    for (p, value) in model.tree().parameters().into_iter().enumerate() {
        full[p] = value;
    }
    let mut reduced = model.values();
    for b in &base.base {
        reduced[b.parameter] =
            full[b.parameter] + b.others.iter().map(|&(p, c)| c * full[p]).sum::<f64>();
    }
    let mut rng = generator(5);
    let [q, dq, ddq] = motion(&mut rng, 7, BLOCK);
    let motors = Trajectory {
        q: &q,
        dq: &dq,
        ddq: &ddq,
    };
    let segment = Segment::states(motors, false);
    let at = |values| {
        Evaluator::new(&model, values, &[])
            .evaluate(segment, 0..BLOCK)
            .clone()
    };
    let (a, b) = (at(&full), at(&reduced));
    for c in 0..7 {
        for k in 0..BLOCK {
            assert!((a.value(c)[k] - b.value(c)[k]).abs() < 1e-9 * a.value(c)[k].abs().max(1.0));
        }
    }
}

#[test]
fn a_locked_joint_leaves_the_wrist_with_fewer_base_parameters() {
    let mut locked = plain(panda(), &[]);
    locked.locked = vec![true, true, true, true, false, false, false];
    let model = Model::new(locked).unwrap();
    let all = structural(&Model::new(plain(panda(), &[])).unwrap());
    let wrist = structural(&model);
    assert!(wrist.base.len() < all.base.len());
    assert!(wrist.base.iter().all(|b| {
        matches!(model.parameters()[b.parameter].role, Role::Inertial { link, .. } if link >= 4)
    }));
}
