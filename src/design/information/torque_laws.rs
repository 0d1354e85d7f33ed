//! Torque laws of one motor along a motion: values, derivatives by their parameters, and slopes by the motion.
//!
//! A law sees one joint only, so central differences in its own position, velocity and acceleration
//! give every slope at the price of a few evaluations of a cheap formula.

use crate::chain::effect::sign::sign;
use crate::chain::effect::{Contribution, Dependence, Effect, Law, Memory, Samples, Surroundings};
use crate::chain::model::Model;

/// Half of a difference, as a share of the joint's scale of motion.
const STEP: f64 = 1e-6;

/// Share of a joint's velocity limit within which the sign of its velocity is rounded off while optimising.
pub const SMOOTHING: f64 = 0.01;

/// Whether an effect is a torque of the motor that follows from its state alone: one that has a memory
/// does not follow from the motion that a design knows.
pub fn of_the_state(effect: &Effect) -> bool {
    let is_alone = effect.needs.memory == Memory::None && effect.needs.others.is_empty();
    matches!(effect.law, Law::Motor(_)) && is_alone
}

/// Speeds of a motor, rad/s (m/s).
#[derive(Debug, Clone, Copy)]
pub struct SpeedScale {
    /// The largest velocity that the joint may have.
    pub largest: f64,
    /// The least transition speed of the sign of the velocity.
    pub transition: f64,
}

/// The laws of one motor.
#[derive(Debug, Clone)]
pub struct Laws<'m> {
    effects: Vec<(&'static Effect, usize)>,
    values: &'m [f64],
    /// Transition speed of the sign of the velocity: the model's, at least the design's, because a
    /// criterion that jumps has no gradient.
    width: f64,
    scale: [f64; 3],
}

/// Torque and derivatives with respect to the parameters of every effect, sample by sample.
#[derive(Debug, Clone, Default)]
pub struct Evaluated {
    /// Of all effects together, N·m (N).
    pub torque: Vec<f64>,
    /// `[effect][parameter][sample]`.
    pub by_parameter: Vec<Vec<Vec<f64>>>,
}

/// Torque and columns half a step further and back in one derivative of the motion.
#[derive(Debug, Clone, Copy)]
pub struct CentralDifference<'a> {
    /// 0 of the position, 1 of the velocity, 2 of the acceleration.
    pub order: usize,
    /// Half a step further.
    pub after: &'a Evaluated,
    /// Half a step back.
    pub before: &'a Evaluated,
    /// The factor that makes a slope of the difference of both.
    pub factor: f64,
}

impl<'m> Laws<'m> {
    /// The laws of a joint at parameter values.
    pub fn of(model: &Model, joint: usize, values: &'m [f64], speed: SpeedScale) -> Self {
        let scale = speed.largest;
        let joint = &model.joints()[joint];
        let width = joint
            .width
            .map_or(0.0, |at| values[at])
            .max(speed.transition);
        Self {
            effects: joint
                .effects
                .iter()
                .copied()
                .filter(|(effect, _)| of_the_state(effect))
                .collect(),
            values,
            width,
            scale: [scale, width.min(scale), scale],
        }
    }

    /// Whether the motor has no torque laws.
    pub fn is_empty(&self) -> bool {
        self.effects.is_empty()
    }

    /// Torque and columns along q, q̇, q̈ of the motor.
    pub fn evaluate(&self, motion: [&[f64]; 3], out: &mut Evaluated) {
        let samples = motion[0].len();
        let sign: Vec<f64> = motion[1].iter().map(|v| sign(*v, self.width)).collect();
        let input = Samples {
            position: motion[0],
            velocity: motion[1],
            acceleration: motion[2],
            sign: &sign,
            time: &[],
            cyclic: false,
            surroundings: Surroundings::default(),
        };
        out.torque.clear();
        out.torque.resize(samples, 0.0);
        out.by_parameter.resize_with(self.effects.len(), Vec::new);
        let zeros = || vec![0.0; samples];
        let (mut by_sign, mut by_position, mut by_velocity) = (zeros(), zeros(), zeros());
        for ((effect, first), by_parameter) in self.effects.iter().zip(&mut out.by_parameter) {
            let Law::Motor(law) = effect.law else {
                continue;
            };
            let count = effect.parameters.len();
            by_parameter.resize_with(count, Vec::new);
            for series in by_parameter.iter_mut() {
                series.clear();
                series.resize(samples, 0.0);
            }
            let mut contribution = Contribution {
                torque: &mut out.torque,
                by_parameter,
                by_sign: &mut by_sign,
                by_position: &mut by_position,
                by_velocity: &mut by_velocity,
            };
            law.add(
                input,
                &self.values[*first..first + count],
                &mut contribution,
            );
        }
    }

    fn depends_on(&self, order: usize) -> bool {
        use Dependence as D;
        self.effects.iter().any(|(effect, _)| {
            effect.depends_on.iter().any(|on| match order {
                0 => *on == D::Position,
                1 => matches!(on, D::Speed | D::Direction),
                _ => *on == D::Acceleration,
            })
        })
    }

    /// Central differences for every order of motion that matters.
    pub fn differences(&self, motion: [&[f64]; 3], mut visit: impl FnMut(CentralDifference<'_>)) {
        let (mut after, mut before) = (Evaluated::default(), Evaluated::default());
        for order in (0..3).filter(|order| self.depends_on(*order)) {
            let half = STEP * self.scale[order];
            let shifted = |by: f64| -> Vec<f64> { motion[order].iter().map(|x| x + by).collect() };
            let (forth, back) = (shifted(half), shifted(-half));
            let (mut at, mut from) = (motion, motion);
            at[order] = &forth;
            from[order] = &back;
            self.evaluate(at, &mut after);
            self.evaluate(from, &mut before);
            visit(CentralDifference {
                order,
                after: &after,
                before: &before,
                factor: 0.5 / half,
            });
        }
    }
}
