//! Every law of the vocabulary against numbers that share nothing with it: two pendulums with one effect each, in closed
//! form or integrated by SciPy (`tests/reference/laws.py` writes `laws.json`).

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use serde::Deserialize;

use crate::chain::effect::{EFFECTS, find};
use crate::chain::evaluate::{Evaluator, Segment};
use crate::chain::model::{Model, ModelSettings, Payload, Signal};
use crate::chain::parameter::Role;
use crate::robot::batch::Trajectory;
use crate::robot::inertia::Inertia;
use crate::robot::urdf;
use nalgebra::{Isometry3, Matrix3, Vector3};

/// The bodies of `tests/reference/laws.py`.
const PENDULUMS: &str = r#"<robot name="pendulums"><link name="base"/>
<link name="long"><inertial><origin xyz="0.3 0.02 -0.05"/><mass value="4.0"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.06"/></inertial></link>
<link name="short"><inertial><origin xyz="0.1 0.0 -0.2"/><mass value="2.0"/>
<inertia ixx="0.03" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
<joint name="first" type="continuous"><parent link="base"/><child link="long"/><axis xyz="0 1 0"/></joint>
<joint name="second" type="continuous"><parent link="base"/><child link="short"/><axis xyz="0 1 0"/></joint>
</robot>"#;

#[derive(Deserialize)]
struct Reference {
    period: f64,
    samples: usize,
    torque_constant: Vec<f64>,
    /// `[joint][term]`: amplitude (rad), harmonic and phase of a sine.
    motion: Vec<Vec<[f64; 3]>>,
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    /// The last one is tested; those before it lend their parameters.
    effects: Vec<String>,
    values: BTreeMap<String, Value>,
    signal: String,
    /// Rows between two samples of the reference.
    refine: usize,
    /// Share of the largest change that the effect makes on a channel.
    tolerance: f64,
    cyclic: bool,
    expected: [Vec<f64>; 2],
    without: [Vec<f64>; 2],
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Value {
    Number(f64),
    /// Mass, centre of mass, principal moments of a load about it.
    Body([f64; 7]),
}

impl Reference {
    fn read() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/laws.json");
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    }

    /// `[order][joint][row]`: position, velocity and acceleration.
    fn motion(&self, rows: usize) -> [Vec<Vec<f64>>; 3] {
        [0, 1, 2].map(|order: i32| {
            let of = |terms: &Vec<[f64; 3]>| {
                let at = |row: usize| {
                    let term = |[size, harmonic, phase]: &[f64; 3]| {
                        let rate = harmonic * TAU / self.period;
                        let angle = harmonic * TAU * row as f64 / rows as f64 + phase;
                        let turned = angle + f64::from(order) * TAU / 4.0;
                        size * rate.powi(order) * turned.sin()
                    };
                    terms.iter().map(term).sum()
                };
                (0..rows).map(at).collect()
            };
            self.motion.iter().map(of).collect()
        })
    }

    fn model(&self, case: &Case) -> Model {
        let tree = urdf::parse(PENDULUMS, Path::new("pendulums.urdf")).unwrap();
        let tested = case.effects.last().unwrap();
        let effects = case.effects.iter().filter(|id| *id != "unmodelled_payload");
        let effects: Vec<_> = effects.map(|id| find(id).unwrap()).collect();
        let load = Payload {
            link: 1,
            frame: Isometry3::identity(),
        };
        let is_current = case.signal == "current";
        let signal = if is_current {
            Signal::Current
        } else {
            Signal::Torque
        };
        Model::new(ModelSettings {
            torque_constant: is_current.then(|| self.torque_constant.clone()),
            effects: vec![effects; 2],
            payload: (tested == "unmodelled_payload").then_some(load),
            ..ModelSettings::bodies(tree, signal)
        })
        .unwrap()
    }

    /// Signals at the samples of the reference.
    fn signals(&self, case: &Case) -> Vec<Vec<f64>> {
        let model = self.model(case);
        let mut values = model.values();
        for (p, value) in model.tree().parameters().into_iter().enumerate() {
            values[p] = value;
        }
        for (name, value) in &case.values {
            match value {
                Value::Number(number) => values[model.find(name).unwrap()] = *number,
                Value::Body([mass, x, y, z, xx, yy, zz]) => {
                    let (centre, m) = (Vector3::new(*x, *y, *z), *mass);
                    let own = Matrix3::from_diagonal(&Vector3::new(*xx, *yy, *zz));
                    let square = Matrix3::identity() * centre.norm_squared();
                    let tensor = own + (square - centre * centre.transpose()) * m;
                    let body = Inertia::from_moments(m, centre * m, &tensor);
                    for (p, parameter) in model.parameters().iter().enumerate() {
                        if let Role::Payload { quantity } = parameter.role {
                            values[p] = body.0[quantity];
                        }
                    }
                }
            }
        }
        let rows = self.samples * case.refine;
        let [q, dq, ddq] = self.motion(rows);
        let step = self.period / rows as f64;
        let time: Vec<f64> = (0..rows).map(|k| step * k as f64).collect();
        let motors = Trajectory {
            q: &q,
            dq: &dq,
            ddq: &ddq,
        };
        let segment = Segment {
            time: &time,
            temperature: &[],
            cyclic: case.cyclic,
            ..Segment::states(motors, true)
        };
        let mut evaluator = Evaluator::along(&model, &values, &[], rows);
        let block = evaluator.evaluate_whole(segment);
        let of = |c: usize| {
            block
                .value(c)
                .iter()
                .step_by(case.refine)
                .copied()
                .collect()
        };
        (0..2).map(of).collect()
    }
}

fn largest(series: impl Iterator<Item = f64>) -> f64 {
    series.map(f64::abs).fold(0.0, f64::max)
}

#[test]
fn matches_closed_forms_and_integrations_of_every_law() {
    let reference = Reference::read();
    for effect in EFFECTS {
        let tests = |case: &&Case| case.effects.last().is_some_and(|id| id == effect.id);
        assert_eq!(
            reference.cases.iter().filter(tests).count(),
            1,
            "{}",
            effect.id
        );
    }
    let mut wrong = Vec::new();
    for case in &reference.cases {
        let found = reference.signals(case);
        let pairs = case
            .expected
            .iter()
            .flatten()
            .zip(case.without.iter().flatten());
        let allowed = case.tolerance * largest(pairs.map(|(a, b)| a - b));
        for (c, found) in found.iter().enumerate() {
            let expected = &case.expected[c];
            // A delay before the first sample and after the last has no motion to come from.
            let inside = 4..expected.len() - 4;
            let error = largest(inside.map(|k| found[k] - expected[k]));
            if error > allowed {
                wrong.push(format!(
                    "{:?} of channel {c}: {error:e}, not {allowed:e}",
                    case.effects
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
