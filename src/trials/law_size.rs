//! Typical sizes of user-defined laws, from their formulas.
//!
//! Shapes are drawn from where a search begins; what is linear is scaled until the torque of a sine over the joint's range has
//! the size that is asked for.

use crate::chain::effect::knowledge::{Drawn, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Effect, Law, Linearity, Memory, ParameterInfo, Samples, Search, Surroundings,
};
use crate::robot::random::{between, index};
use crate::stats::deviation::rms;
use crate::stats::range::within;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

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
pub fn values(rng: &mut ChaCha8Rng, effect: &'static Effect, site: &Site) -> Vec<Drawn> {
    let values: Vec<f64> = effect
        .parameters
        .iter()
        .map(|info| one(rng, info, site))
        .collect();
    let size = rms(&torques(effect, site, &values));
    let scale = if size > 0.0 {
        site.torque() / size
    } else {
        1.0
    };
    let scaled = |(info, value): (&ParameterInfo, f64)| match info.linearity {
        Linearity::Linear => drawn(info.name, within(scale * value, [info.lower, info.upper])),
        Linearity::Nonlinear => drawn(info.name, value),
    };
    effect.parameters.iter().zip(values).map(scaled).collect()
}

fn one(rng: &mut ChaCha8Rng, info: &ParameterInfo, site: &Site) -> f64 {
    let mut pick = |of: &[f64]| of[index(rng, of.len())];
    let range = 2.0 * site.half_range;
    let value = match info.search {
        Search::Typical => info.typical,
        Search::Values(values) | Search::Rising(values) => pick(values),
        Search::Position(shares) => site.middle - site.half_range + pick(shares) * range,
        Search::Range(shares) => pick(shares) * range,
        Search::Speed(shares) => pick(shares) * site.fastest,
        Search::OverSpeed(shares) => pick(shares) / site.fastest,
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
fn torques(effect: &Effect, site: &Site, parameters: &[f64]) -> Vec<f64> {
    let (Law::Motor(law) | Law::Joint(law)) = effect.law else {
        return Vec::new();
    };
    let rate = site.fastest / site.half_range;
    let of = |f: fn(f64) -> f64, size: f64, about: f64| -> Vec<f64> {
        let angles = (0..SAMPLES).map(|k| TAU * k as f64 / SAMPLES as f64);
        angles.map(|x| about + size * f(x)).collect()
    };
    let position = of(f64::sin, site.half_range, site.middle);
    let velocity = of(f64::cos, site.fastest, 0.0);
    let acceleration = of(f64::sin, -site.fastest * rate, 0.0);
    let sign: Vec<f64> = velocity.iter().map(|v| v.signum()).collect();
    let samples = Samples {
        position: &position,
        velocity: &velocity,
        acceleration: &acceleration,
        sign: &sign,
        time: &[],
        cyclic: false,
        surroundings: Surroundings::default(),
    };
    law.torques(samples, parameters)
}
