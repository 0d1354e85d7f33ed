//! Sizes of laws that are not of the vocabulary, from their formulas.
//!
//! Shapes are drawn from where a search begins; what is linear is scaled until the torque of a sine over the joint's range has
//! the size that is asked for.

use crate::chain::effect::{
    Contribution, Effect, Law, Linearity, Memory, ParameterInfo, Samples, Search, Surroundings,
};
use crate::robot::random::between;
use crate::stats::deviation::rms;
use crate::stats::range::within;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// What a joint does in a trial.
#[derive(Debug, Clone, Copy)]
pub struct Course {
    /// rad (m)
    pub middle: f64,
    pub half_range: f64,
    /// rad/s (m/s)
    pub fastest: f64,
}

/// Samples of the sine: enough for a ripple of some tens of cycles.
const SAMPLES: usize = 1024;

/// Whether a law's torque follows from the motion of its joint and has a size that is linear.
pub fn has_size(effect: &Effect) -> bool {
    let is_of_motion = matches!(effect.law, Law::Motor(_) | Law::Joint(_));
    let alone = effect.needs.memory == Memory::None && effect.needs.others.is_empty();
    let mut parameters = effect.parameters.iter();
    is_of_motion && alone && parameters.any(|p| p.linearity == Linearity::Linear)
}

/// Values of the parameters at which the law has this torque, N·m (N).
pub fn values(
    rng: &mut ChaCha8Rng,
    effect: &'static Effect,
    course: Course,
    torque: f64,
) -> Vec<(&'static str, f64)> {
    let drawn: Vec<f64> = effect
        .parameters
        .iter()
        .map(|info| drawn(rng, info, course))
        .collect();
    let size = rms(&torques(effect, course, &drawn));
    let scale = if size > 0.0 { torque / size } else { 1.0 };
    let scaled = |(info, value): (&ParameterInfo, f64)| match info.linearity {
        Linearity::Linear => (info.name, within(scale * value, [info.lower, info.upper])),
        Linearity::Nonlinear => (info.name, value),
    };
    effect.parameters.iter().zip(drawn).map(scaled).collect()
}

fn drawn(rng: &mut ChaCha8Rng, info: &ParameterInfo, course: Course) -> f64 {
    let mut pick = |of: &[f64]| of[(rng.random::<f64>() * of.len() as f64) as usize];
    let range = 2.0 * course.half_range;
    let value = match info.search {
        Search::Typical => info.typical,
        Search::Values(values) | Search::Rising(values) => pick(values),
        Search::Position(shares) => course.middle - course.half_range + pick(shares) * range,
        Search::Range(shares) => pick(shares) * range,
        Search::Speed(shares) => pick(shares) * course.fastest,
        Search::OverSpeed(shares) => pick(shares) / course.fastest,
        Search::Duration(_) | Search::Instant(_) => info.typical,
        Search::Cycles => TAU * between(rng, 1.5, 20.0) / range,
    };
    let near = match info.search {
        Search::Position(_) => value,
        _ => value * between(rng, 0.8, 1.25),
    };
    within(near, [info.lower, info.upper])
}

/// Torque along a sine over the range of the joint.
fn torques(effect: &Effect, course: Course, parameters: &[f64]) -> Vec<f64> {
    let (Law::Motor(law) | Law::Joint(law)) = effect.law else {
        return Vec::new();
    };
    let rate = course.fastest / course.half_range;
    let of = |f: fn(f64) -> f64, size: f64, about: f64| -> Vec<f64> {
        let angles = (0..SAMPLES).map(|k| TAU * k as f64 / SAMPLES as f64);
        angles.map(|x| about + size * f(x)).collect()
    };
    let position = of(f64::sin, course.half_range, course.middle);
    let velocity = of(f64::cos, course.fastest, 0.0);
    let acceleration = of(f64::sin, -course.fastest * rate, 0.0);
    let sign: Vec<f64> = velocity.iter().map(|v| v.signum()).collect();
    let zeros = || vec![0.0; SAMPLES];
    let mut torque = zeros();
    law.add(
        Samples {
            position: &position,
            velocity: &velocity,
            acceleration: &acceleration,
            sign: &sign,
            time: &[],
            cyclic: false,
            surroundings: Surroundings::default(),
        },
        parameters,
        &mut Contribution {
            torque: &mut torque,
            by_parameter: &mut vec![zeros(); parameters.len()],
            by_sign: &mut zeros(),
            by_position: &mut zeros(),
            by_velocity: &mut zeros(),
        },
    );
    torque
}
