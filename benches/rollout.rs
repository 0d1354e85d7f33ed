//! Forward simulation of a seven-joint arm at 1 kHz: one minute in one go, and every window of a recording of a minute.
//! `examples/simulator_proof/speed.py` times MuJoCo beside it, on the same model under the same torques.

use criterion::{Criterion, criterion_group, criterion_main};
use exid::chain::effect::find;
use exid::chain::forward::{Accuracy, Driven, Forward};
use exid::chain::model::{Inertials, Model, ModelSettings, Signal};
use exid::robot::mjcf;
use nalgebra::DVector;
use std::hint::black_box;
use std::path::Path;

const JOINTS: usize = 7;
const RATE: f64 = 1000.0;
const SECONDS: usize = 60;

/// An arm with Coulomb and viscous friction.
fn arm() -> (Model, DVector<f64>) {
    let effects = ["coulomb_friction", "viscous_friction"].map(|id| find(id).unwrap());
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/arm7.xml");
    let robot = mjcf::read(&file).unwrap().tree;
    let model = Model::new(ModelSettings {
        inertials: Inertials::Known,
        rotor_inertia: Some(vec![0.3; JOINTS]),
        effects: vec![effects.to_vec(); JOINTS],
        ..ModelSettings::bodies(robot, Signal::Torque)
    })
    .unwrap();
    let mut values = model.values();
    for (p, parameter) in model.parameters().iter().enumerate() {
        for (name, value) in [(".Fc", 2.0), (".w", 0.004), (".Fv", 5.0)] {
            if parameter.name.ends_with(name) {
                values[p] = value;
            }
        }
    }
    (model, values)
}

/// Simulates under torques that swing the joints, restarted every so many samples; how far the joints come.
fn simulate(forward: &mut Forward<'_>, samples: usize, restart: usize) -> f64 {
    let rest = vec![0.0; JOINTS];
    let mut state = forward.settled(&rest, &rest);
    let wave = |k: usize| -> Vec<f64> {
        let t = k as f64 / RATE;
        let of = |j: usize| 8.0 * ((1.0 + 0.3 * j as f64) * t + j as f64).sin();
        (0..JOINTS).map(of).collect()
    };
    let mut to = wave(0);
    for k in 0..samples {
        if k % restart == 0 {
            state = forward.settled(&rest, &rest);
        }
        let from = std::mem::replace(&mut to, wave(k + 1));
        let driven = Driven::Torque {
            from: &from,
            to: &to,
        };
        forward.advance(&mut state, driven, 1.0 / RATE).unwrap();
    }
    state.position.iter().sum()
}

fn rollout(c: &mut Criterion) {
    let (model, values) = arm();
    let mut forward = Forward::new(&model, &values, false, Accuracy::default()).unwrap();
    let minute = SECONDS * RATE as usize;
    let mut group = c.benchmark_group("rollout");
    group.sample_size(10);
    group.bench_function("a minute of seven joints at 1 kHz", |b| {
        b.iter(|| black_box(simulate(&mut forward, minute, minute)));
    });
    // Starts every half second, two seconds each.
    group.bench_function("all windows of a minute, one model", |b| {
        b.iter(|| black_box(simulate(&mut forward, 4 * minute, 2000)));
    });
    group.finish();
}

criterion_group!(benches, rollout);
criterion_main!(benches);
