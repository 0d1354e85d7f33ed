//! Shipped laws by their values: slopes against differences, states against closed forms and an independent integration.

use exid::chain::effect::{
    Catalogue, Contribution, EFFECTS, Effect, Law, ParameterInfo, Samples, Search, Surroundings,
    Transmitted,
};
use exid::setup::laws;
use std::path::Path;

const SAMPLES: usize = 400;
const STEP: f64 = 0.005;

struct Motion {
    position: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    sign: Vec<f64>,
    time: Vec<f64>,
    load: Vec<f64>,
    temperature: Vec<f64>,
}

impl Motion {
    /// Two sines, from one side of zero to the other.
    fn new() -> Self {
        let time: Vec<f64> = (0..SAMPLES).map(|k| STEP * k as f64).collect();
        let of = |f: fn(f64) -> f64| time.iter().map(|t| f(*t)).collect::<Vec<f64>>();
        let velocity = of(|t| 4.0 * (4.0 * t).cos() + 1.1 * (11.0 * t + 0.4).cos());
        Self {
            position: of(|t| (4.0 * t).sin() + 0.1 * (11.0 * t + 0.4).sin()),
            acceleration: of(|t| -16.0 * (4.0 * t).sin() - 12.1 * (11.0 * t + 0.4).sin()),
            sign: velocity.iter().map(|v| v / (v.abs() + 0.05)).collect(),
            load: of(|t| 3.0 * (3.0 * t + 0.1).sin()),
            temperature: of(|t| 25.0 + 5.0 * t),
            velocity,
            time,
        }
    }

    /// One way at one speed, from rest.
    fn one_way(speed: f64) -> Self {
        let mut motion = Self::new();
        motion.velocity.fill(speed);
        motion
    }

    fn samples(&self) -> Samples<'_> {
        Samples {
            position: &self.position,
            velocity: &self.velocity,
            acceleration: &self.acceleration,
            sign: &self.sign,
            time: &self.time,
            cyclic: false,
            surroundings: Surroundings {
                temperature: &self.temperature,
                torque_constant: Some(2.0),
                ..Surroundings::default()
            },
        }
    }
}

struct Evaluated {
    torque: Vec<f64>,
    by_parameter: Vec<Vec<f64>>,
}

fn evaluate(effect: &Effect, motion: &Motion, parameters: &[f64]) -> Evaluated {
    let zeros = || vec![0.0; SAMPLES];
    let mut by_parameter = vec![zeros(); parameters.len()];
    let mut torque = zeros();
    match effect.law {
        Law::Motor(law) | Law::Joint(law) => law.add(
            motion.samples(),
            parameters,
            &mut Contribution {
                torque: &mut torque,
                by_parameter: &mut by_parameter,
                by_sign: &mut zeros(),
                by_position: &mut zeros(),
                by_velocity: &mut zeros(),
            },
        ),
        Law::Transmission(law) | Law::Signal(law) => law.add(
            motion.samples(),
            &motion.load,
            parameters,
            &mut Transmitted {
                torque: &mut torque,
                by_load: &mut zeros(),
                by_parameter: &mut by_parameter,
                by_sign: &mut zeros(),
                rounding: 0.0,
            },
        ),
        _ => unreachable!(),
    }
    Evaluated {
        torque,
        by_parameter,
    }
}

fn catalogue() -> Catalogue {
    laws::of_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("laws")).unwrap()
}

/// Typical values, bends and positions where the motion has them.
fn usual(info: &ParameterInfo) -> f64 {
    match info.search {
        Search::Position(shares) => -1.0 + 2.0 * shares[shares.len() / 2],
        Search::Range(shares) => 2.0 * shares[0],
        Search::OverSpeed(shares) => shares[0] / 5.0,
        _ => info.typical,
    }
}

#[test]
fn matches_differences_in_every_parameter() {
    let catalogue = catalogue();
    let own = &catalogue.effects()[EFFECTS.len()..];
    assert!(own.len() >= 10);
    for effect in own {
        let motion = Motion::new();
        let values: Vec<f64> = effect.parameters.iter().map(usual).collect();
        let here = evaluate(effect, &motion, &values);
        assert!(here.torque.iter().any(|x| *x != 0.0), "{}", effect.id);
        for (index, info) in effect.parameters.iter().enumerate() {
            let h = 1e-6 * values[index].abs().max(1e-3);
            let at = |step: f64| {
                let mut moved = values.clone();
                moved[index] += step;
                evaluate(effect, &motion, &moved).torque
            };
            let (high, low) = (at(h), at(-h));
            let largest = here.by_parameter[index]
                .iter()
                .fold(0.0, |m: f64, x| m.max(x.abs()));
            // Rounding of torques over the step, and a corner that a difference straddles in a sample or two.
            let off = (0..SAMPLES).filter(|&k| {
                let difference = (high[k] - low[k]) / (2.0 * h);
                let error = (here.by_parameter[index][k] - difference).abs();
                error > 1e-5 * largest.max(here.torque[k].abs())
            });
            assert!(off.count() <= 2, "{} {}", effect.id, info.name);
        }
    }
}

#[test]
fn matches_dahls_closed_form_one_way_from_rest() {
    let catalogue = catalogue();
    let [sigma, fc, speed] = [40.0, 1.5, 0.1];
    let motion = Motion::one_way(speed);
    let found = evaluate(
        catalogue.find("dahl_friction").unwrap(),
        &motion,
        &[sigma, fc],
    );
    for (k, torque) in found.torque.iter().enumerate() {
        let way = speed * STEP * k as f64;
        let expected = fc * (1.0 - (-sigma * way / fc).exp());
        assert!(
            (torque - expected).abs() < 1e-12,
            "{k}: {torque} {expected}"
        );
    }
}

/// Rate of a state from itself and the speed.
type Rate<'a> = &'a dyn Fn(f64, f64) -> f64;

/// The state at every sample by Runge and Kutta's method, in a hundred steps from one to the next.
fn integrated(velocity: &[f64], rate: Rate<'_>) -> Vec<f64> {
    let mut z = 0.0;
    let mut all = vec![0.0];
    for pair in velocity.windows(2) {
        let h = STEP / 100.0;
        for step in 0..100 {
            let v = |share: f64| pair[0] + (pair[1] - pair[0]) * (f64::from(step) + share) / 100.0;
            let a = rate(z, v(0.0));
            let b = rate(z + 0.5 * h * a, v(0.5));
            let c = rate(z + 0.5 * h * b, v(0.5));
            let d = rate(z + h * c, v(1.0));
            z += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        }
        all.push(z);
    }
    all
}

fn rise(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[test]
fn matches_an_independent_integration_of_contacts_that_slide() {
    let catalogue = catalogue();
    let motion = Motion::new();
    let [sigma, fc, share] = [5.0, 1.5, 0.4];
    let elastic = integrated(&motion.velocity, &|z, v| {
        let bent = z.abs() * sigma / fc;
        let slides = if z * v > 0.0 {
            rise((bent - share) / (1.0 - share))
        } else {
            0.0
        };
        v * (1.0 - slides * bent)
    });
    let effect = catalogue.find("elasto_plastic_friction").unwrap();
    let found = evaluate(effect, &motion, &[sigma, fc, share]);
    let off = |k: usize| (found.torque[k] - sigma * elastic[k]).abs();
    // Steps in which the contact is bent by a tenth of its range, and the second order of the method.
    let worst = (0..SAMPLES).map(off).fold(0.0, f64::max);
    assert!(worst < 0.01 * fc, "{worst}");

    let [stiff, bends] = [[20.0, 8.0, 2.0], [0.2, 0.5, 0.9]];
    let states = bends.map(|d| {
        integrated(&motion.velocity, &|z, v| {
            let slides = if z * v > 0.0 {
                rise(5.0 * z.abs() / d - 4.0)
            } else {
                0.0
            };
            v * (1.0 - slides)
        })
    });
    let effect = catalogue.find("maxwell_slip").unwrap();
    let values = [stiff, bends].concat();
    let found = evaluate(effect, &motion, &values);
    let largest: f64 = (0..3).map(|j| stiff[j] * bends[j]).sum();
    for k in 0..SAMPLES {
        let expected: f64 = (0..3).map(|j| stiff[j] * states[j][k]).sum();
        assert!((found.torque[k] - expected).abs() < 0.01 * largest, "{k}");
    }
}

#[test]
fn matches_the_formulas_of_their_sources() {
    let catalogue = catalogue();
    let motion = Motion::new();
    let torque =
        |id: &str, values: &[f64]| evaluate(catalogue.find(id).unwrap(), &motion, values).torque;
    let makkar = torque("stribeck_tanh", &[1.0, 60.0, 4.0, 1.2, 30.0]);
    let warm = torque("exponential_viscosity", &[0.8, 0.03]);
    let stop = torque("end_stop_above", &[100.0, 10.0, 0.5]);
    let cable = torque("cable_spring", &[4.0, -0.5, 0.6]);
    let saturated = torque("magnetic_saturation", &[0.02, 0.01]);
    for k in 0..SAMPLES {
        let (q, v) = (motion.position[k], motion.velocity[k]);
        let expected = (60.0 * v).tanh() - (4.0 * v).tanh() + 1.2 * (30.0 * v).tanh();
        assert!((makkar[k] - expected).abs() < 1e-13);
        let expected = 0.8 * (-0.03 * (motion.temperature[k] - 25.0)).exp() * v;
        assert!((warm[k] - expected).abs() < 1e-13);
        let depth = (q - 0.5).max(0.0);
        let expected = depth.powf(1.5) * (100.0 + 10.0 * v);
        assert!((stop[k] - expected).abs() < 1e-11);
        let expected = 4.0 * if q > 0.6 { q - 0.6 } else { (q + 0.5).min(0.0) };
        assert!((cable[k] - expected).abs() < 1e-13);
        // What a motor of 2 N·m/A gives, and the share that its constant has lost.
        let i = motion.load[k] / 2.0;
        let gain = 1.0 - 0.02 * i * i - 0.01 * (i * v).abs();
        let expected = motion.load[k] / gain - motion.load[k];
        assert!((saturated[k] - expected).abs() < 1e-13);
    }
}
