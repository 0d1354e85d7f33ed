//! The chain as a whole: derivatives of the signal in every kind of parameter, and known bases.

use crate::chain::base_parameters::BaseParameters;
use crate::chain::effect::EFFECTS;
use crate::chain::evaluate::{BLOCK, Block, Evaluator, Segment};
use crate::chain::model::{Inertials, Model, ModelSettings, Payload, Signal};
use crate::chain::parameter::Role;
use crate::robot::batch::Trajectory;
use crate::robot::mdh;
use crate::robot::random::{generator, symmetric, tree};
use crate::robot::tree::Tree;
use nalgebra::{DMatrix, Isometry3, Vector3};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

/// Every effect on every joint, whatever the table holds.
fn settings(tree: Tree, signal: Signal) -> ModelSettings {
    let n = tree.len();
    ModelSettings {
        signal,
        inertials: Inertials::Estimate,
        torque_constant: (signal == Signal::Current).then(|| vec![11.0; n]),
        rotor_inertia: None,
        coupling: Some(DMatrix::from_fn(n, n, |i, j| {
            if i == j {
                1.0
            } else {
                0.1 / (1.0 + i as f64 + 2.0 * j as f64)
            }
        })),
        offset: Some((0..n).map(|k| 0.1 * k as f64).collect()),
        effects: vec![EFFECTS.to_vec(); n],
        payload: Some(Payload {
            link: n - 1,
            frame: Isometry3::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.4, 0.5, -0.6)),
        }),
        locked: vec![false; n],
        tree,
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
fn valued(signal: Signal, rng: &mut ChaCha8Rng) -> Model {
    let robot = tree(rng, 4);
    let mut model = Model::new(settings(robot, signal)).unwrap();
    for p in 0..model.parameters().len() {
        let parameter = &model.parameters()[p];
        let value = match parameter.role {
            Role::Inertial { link, quantity } => model.tree().joints()[link].inertia.0[quantity],
            _ => parameter.scale * (1.0 + symmetric(rng, 0.5)),
        };
        model.start(p, value);
    }
    model
}

fn assert_derivative(model: &Model, (block, segment): (&Block, Segment<'_>), p: usize) {
    let parameter = &model.parameters()[p];
    let h = 1e-6 * parameter.scale;
    let at = |step: f64| {
        let mut moved = model.values();
        moved[p] += step;
        let samples = segment.motors.len();
        Evaluator::new(model, &moved, &[])
            .evaluate(segment, 0..samples)
            .clone()
    };
    let (high, low) = (at(h), at(-h));
    for c in 0..model.channels().len() {
        for k in 0..segment.motors.len() {
            let expected = (high.value(c)[k] - low.value(c)[k]) / (2.0 * h);
            let got = block.derivative(c, p).map_or(0.0, |series| series[k]);
            // Rounding of the values over the step, and the third derivative in the step.
            let bound = 1e-15 * block.value(c)[k].abs() / h + 1e-5 * expected.abs().max(0.1);
            let name = &parameter.name;
            assert!(
                (got - expected).abs() <= bound,
                "{name} {c} {got} {expected}"
            );
        }
    }
}

#[test]
fn matches_differences_of_the_signal_in_every_parameter() {
    const SAMPLES: usize = 21;
    let signals = [
        Signal::Current,
        Signal::Torque,
        Signal::LinkTorque,
        Signal::Both,
    ];
    for (seed, signal) in (40..).zip(signals) {
        let mut rng = generator(seed);
        let model = valued(signal, &mut rng);
        let all: Vec<usize> = (0..model.parameters().len()).collect();
        let [q, dq, ddq] = motion(&mut rng, 4, SAMPLES);
        let segment = Segment {
            motors: Trajectory {
                q: &q,
                dq: &dq,
                ddq: &ddq,
            },
            loaded: true,
        };
        let block = Evaluator::new(&model, &model.values(), &all)
            .evaluate(segment, 0..SAMPLES)
            .clone();
        for &p in &all {
            assert_derivative(&model, (&block, segment), p);
        }
    }
}

fn panda() -> Tree {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/panda_like/panda_like.mdh.toml");
    mdh::read(&path).unwrap()
}

fn plain(tree: Tree, effects: &[&str]) -> ModelSettings {
    let n = tree.len();
    let list: Vec<_> = effects
        .iter()
        .map(|id| crate::chain::effect::find(id).unwrap())
        .collect();
    ModelSettings {
        torque_constant: None,
        coupling: None,
        offset: None,
        payload: None,
        effects: vec![list; n],
        ..settings(tree, Signal::Torque)
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
    let segment = Segment {
        motors: Trajectory {
            q: &q,
            dq: &dq,
            ddq: &ddq,
        },
        loaded: false,
    };
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
