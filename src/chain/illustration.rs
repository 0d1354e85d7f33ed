//! What an effect adds to the signal of a joint along a reference motion: the pictures of the vocabulary.
//!
//! The first of two joints with horizontal axes swings in two harmonics, and so does the second. With bodies alone the motor of
//! the first exerts τ_0; with the effect at parameters θ, and with those effects that it refines or borrows from,
//!
//! ```text
//! added(t) = k i(t; θ) − τ_0(t),   N·m;   k: torque constant, i: current
//! ```
//!
//! θ are typical values, the first of them at [`SCALES`] times its own, within its bounds.

use crate::chain::effect::{self, Dependence, Effect, Law};
use crate::chain::error::ModelError;
use crate::chain::evaluate::{Evaluator, Segment};
use crate::chain::model::{Inertials, Model, ModelSettings, Payload, Signal};
use crate::robot::batch::Trajectory;
use crate::robot::inertia::{CentralInertia, Inertia};
use crate::robot::tree::{Joint, JointKind, Limits, Tree};
use crate::stats::range::within;
use nalgebra::{DMatrix, Isometry3, Matrix3, Rotation3, Vector3};
use std::f64::consts::TAU;

/// Multiples of the first parameter's typical value.
pub const SCALES: [f64; 3] = [0.75, 1.0, 1.25];

/// Hz: bristles and play settle within a few samples.
const RATE: f64 = 1000.0;

/// s: two periods of the motion.
const DURATION: f64 = 8.0;

/// N·m/A at the joint: what typical powers of the current are about.
const TORQUE_CONSTANT: f64 = 10.0;

/// One setting of an effect along the motion.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Value of the first parameter; `None` where only the effects that it rests on act.
    pub first: Option<f64>,
    /// N·m, one for each sample.
    pub added: Vec<f64>,
}

/// An effect along the reference motion.
#[derive(Debug, Clone)]
pub struct Illustration {
    /// What `over` is, with its unit.
    pub variable: &'static str,
    /// The variable that the effect varies with first, one value for each sample.
    pub over: Vec<f64>,
    /// What it rests on alone, where it rests on something, then the effect at each of [`SCALES`].
    pub curves: Vec<Curve>,
}

/// The effect along the reference motion.
///
/// # Errors
/// Where the effect makes no model of the two joints.
pub fn illustrate(effect: &'static Effect) -> Result<Illustration, ModelError> {
    let motion = ReferenceMotion::new();
    let rests_on = rests_on(effect);
    let without = with_typical_values(settings(Vec::new()), None)?;
    let bodies = motion.signal(&without);
    let added = |model: &Model| -> Vec<f64> {
        let whole = motion.signal(model);
        whole.iter().zip(&bodies).map(|(a, b)| a - b).collect()
    };
    let mut curves = Vec::new();
    if !rests_on.is_empty() {
        let model = with_typical_values(settings(rests_on.clone()), None)?;
        curves.push(Curve {
            first: None,
            added: added(&model),
        });
    }
    let with_effect = extended(settings([rests_on, vec![effect]].concat()), effect);
    let first = &effect.parameters[0];
    for scale in SCALES {
        let value = within(scale * first.typical, [first.lower, first.upper]);
        let setting = Setting { effect, value };
        let model = with_typical_values(with_effect.clone(), Some(setting))?;
        curves.push(Curve {
            first: Some(value),
            added: added(&model),
        });
    }
    let (variable, over) = motion.variable(effect.depends_on[0], &bodies);
    Ok(Illustration {
        variable,
        over,
        curves,
    })
}

/// Effects that have to be there beside this one: those that it borrows parameters from, or the first that it refines.
fn rests_on(effect: &Effect) -> Vec<&'static Effect> {
    let lenders = effect.needs.borrows.iter().map(|(lender, _)| *lender);
    let refined = effect.needs.refines.first().copied();
    let mut found: Vec<&'static Effect> = lenders.chain(refined).filter_map(effect::find).collect();
    found.dedup_by_key(|e| e.id);
    found
}

/// An arm of two hanging links of 4 and 2 kg with the effects on its first joint, whose torque changes sign.
fn settings(effects: Vec<&'static Effect>) -> ModelSettings {
    let link = |name: &str, parent: Option<usize>, mass: f64, reach: f64| Joint {
        name: name.to_owned(),
        link: format!("{name}_link"),
        parent,
        kind: JointKind::Revolute,
        axis: Vector3::y(),
        rotation: Rotation3::identity(),
        translation: parent.map_or(Vector3::zeros(), |_| Vector3::new(0.0, 0.0, -0.4)),
        limits: Limits::default(),
        inertia: Inertia::from_central(&CentralInertia {
            mass,
            centre: Vector3::new(0.0, 0.0, -reach),
            tensor: Matrix3::from_diagonal(&Vector3::new(0.05, 0.05, 0.01)),
        }),
    };
    let joints = vec![link("a1", None, 4.0, 0.2), link("a2", Some(0), 2.0, 0.15)];
    let tree = Tree::new("reference", "base", joints).with_gravity([0.0, 0.0, -9.81]);
    ModelSettings {
        inertials: Inertials::Known,
        torque_constant: Some(vec![TORQUE_CONSTANT; 2]),
        effects: vec![effects, Vec::new()],
        ..ModelSettings::bodies(tree, Signal::Current)
    }
}

/// What the model needs for the effect to have parameters: a load's frame, or an entry of V.
fn extended(mut settings: ModelSettings, effect: &Effect) -> ModelSettings {
    match effect.law {
        Law::Body => {
            settings.payload = Some(Payload {
                link: 1,
                frame: Isometry3::translation(0.0, 0.0, -0.3),
            });
        }
        Law::Coupling => {
            let entry = effect.parameters[0].typical;
            settings.coupling = Some(DMatrix::from_row_slice(2, 2, &[1.0, entry, 0.0, 1.0]));
        }
        _ => {}
    }
    settings
}

/// An effect, and the value of its first parameter.
#[derive(Clone, Copy)]
struct Setting {
    effect: &'static Effect,
    value: f64,
}

/// The model with typical values of all effects, but for the first parameter of the one that is set.
fn with_typical_values(
    settings: ModelSettings,
    setting: Option<Setting>,
) -> Result<Model, ModelError> {
    let mut listed = settings.effects[0].clone();
    let mut model = Model::new(settings)?;
    listed.retain(|effect| setting.is_none_or(|s| s.effect.id != effect.id));
    for effect in listed {
        for (position, info) in positions(&model, effect).into_iter().zip(effect.parameters) {
            model.fix(position, info.typical)?;
        }
    }
    if let Some(Setting { effect, value }) = setting {
        let typical = effect.parameters.iter().skip(1).map(|info| info.typical);
        let values = std::iter::once(value).chain(typical);
        for (position, value) in positions(&model, effect).into_iter().zip(values) {
            model.fix(position, value)?;
        }
    }
    Ok(model)
}

/// Positions of an effect's parameters in the model's list; of a body that of its mass alone, which makes it a point.
fn positions(model: &Model, effect: &Effect) -> Vec<usize> {
    let is_own = |name: &str| match effect.law {
        Law::Body => name == "payload.m",
        _ => name.split('.').any(|part| part == effect.id),
    };
    let parameters = model.parameters().iter().enumerate();
    parameters
        .filter(|(_, parameter)| is_own(&parameter.name))
        .map(|(position, _)| position)
        .collect()
}

/// The motion of both joints: `q = Σ a sin(k ω t + φ)`.
struct ReferenceMotion {
    time: Vec<f64>,
    /// Position, speed and acceleration, `[order][joint][sample]`.
    motion: [Vec<Vec<f64>>; 3],
}

/// One term of a motion: amplitude in rad, multiple of the base frequency, phase in rad.
struct Harmonic {
    amplitude: f64,
    order: f64,
    phase: f64,
}

const FIRST: [Harmonic; 2] = [
    Harmonic {
        amplitude: 0.9,
        order: 1.0,
        phase: 0.0,
    },
    Harmonic {
        amplitude: 0.25,
        order: 3.0,
        phase: 0.6,
    },
];

const SECOND: [Harmonic; 1] = [Harmonic {
    amplitude: 0.7,
    order: 2.0,
    phase: 0.8,
}];

impl ReferenceMotion {
    fn new() -> Self {
        let count = (DURATION * RATE) as usize;
        let time: Vec<f64> = (0..count).map(|k| k as f64 / RATE).collect();
        let omega = TAU / (DURATION / 2.0);
        let series = |terms: &[Harmonic], order: i32| -> Vec<f64> {
            let at = |t: &f64| {
                let of = |h: &Harmonic| {
                    let speed = h.order * omega;
                    let angle = speed * t + h.phase + 0.25 * TAU * f64::from(order);
                    h.amplitude * speed.powi(order) * angle.sin()
                };
                terms.iter().map(of).sum()
            };
            time.iter().map(at).collect()
        };
        let motion = [0, 1, 2].map(|order| vec![series(&FIRST, order), series(&SECOND, order)]);
        Self { time, motion }
    }

    /// Current of the first joint along the motion times the torque constant, N·m.
    fn signal(&self, model: &Model) -> Vec<f64> {
        let [q, dq, ddq] = &self.motion;
        let segment = Segment {
            motors: Trajectory { q, dq, ddq },
            forces: &[],
            commands: None,
            bodies: None,
            time: &self.time,
            temperature: &[],
            cyclic: false,
            loaded: true,
        };
        let mut evaluator = Evaluator::along(model, &model.values(), &[], self.time.len());
        let current = evaluator.evaluate_whole(segment).value(0);
        current.iter().map(|i| TORQUE_CONSTANT * i).collect()
    }

    /// The variable of a dependence with its name and unit; `bodies` is what the bodies ask for.
    fn variable(&self, dependence: Dependence, bodies: &[f64]) -> (&'static str, Vec<f64>) {
        let [q, dq, ddq] = &self.motion;
        match dependence {
            Dependence::Position | Dependence::Gravity => ("position [rad]", q[0].clone()),
            Dependence::Speed | Dependence::Direction => ("speed [rad/s]", dq[0].clone()),
            Dependence::Acceleration => ("acceleration [rad/s²]", ddq[0].clone()),
            Dependence::Load => ("transmitted torque [N·m]", bodies.to_vec()),
            Dependence::OtherJoints => ("position of the other joint [rad]", q[1].clone()),
            Dependence::Current => {
                let current = bodies.iter().map(|torque| torque / TORQUE_CONSTANT);
                ("current [A]", current.collect())
            }
            Dependence::Time | Dependence::Temperature | Dependence::Nothing => {
                ("time [s]", self.time.clone())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::effect::EFFECTS;

    #[test]
    fn every_effect_changes_the_signal_and_by_its_first_parameter() {
        for effect in EFFECTS {
            let illustration = illustrate(effect).unwrap_or_else(|e| panic!("{}: {e}", effect.id));
            let of_effect = illustration.curves.iter().filter(|c| c.first.is_some());
            let sizes: Vec<f64> = of_effect
                .map(|c| c.added.iter().map(|x| x.abs()).fold(0.0, f64::max))
                .collect();
            assert_eq!(sizes.len(), SCALES.len());
            assert!(
                sizes.iter().any(|size| *size > 1e-4),
                "{}: {sizes:?}",
                effect.id
            );
            assert!(sizes.iter().all(|size| size.is_finite()), "{}", effect.id);
            let curves = &illustration.curves;
            let last = curves.len() - 1;
            assert_ne!(curves[last].added, curves[last - 2].added, "{}", effect.id);
        }
    }

    /// Values that follow from the law by hand: 1 N·m of dry friction, 1 N·m·s/rad.
    #[test]
    fn matches_the_laws_where_they_are_plain() {
        let motion = ReferenceMotion::new();
        for (id, law) in [
            ("viscous_friction", (|v| v) as fn(f64) -> f64),
            ("coulomb_friction", |v: f64| v / (v.abs() + 0.005)),
        ] {
            let illustration = illustrate(effect::find(id).unwrap()).unwrap();
            for (added, v) in illustration.curves[1]
                .added
                .iter()
                .zip(&motion.motion[1][0])
            {
                assert!((added - law(*v)).abs() < 1e-12, "{id}");
            }
        }
    }
}
