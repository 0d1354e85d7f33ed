//! Segments and constants against motions whose truth is known.

use rand::SeedableRng;
use rand_distr::{Distribution as _, StandardNormal};

use crate::motors::compare::{equality, of_same_type};
use crate::motors::constants::{Part, Term, first_stage, load_dependence, second_stage};
use crate::motors::segments::{Steadiness, steady};
use crate::motors::simplex::nelder_mead;

const K: f64 = 12.6351;
const FC: f64 = 11.881;
const FV: f64 = 7.7891;

/// Parts at the speeds, the load a sine of the position; noise in A.
fn parts(speeds: &[f64], load: f64, mu: f64, noise: f64, seed: u64) -> Vec<Part> {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let part = |&speed: &f64| {
        let samples = 200;
        let angle = |k: usize| 0.3 + 1.2 * k as f64 / samples as f64;
        let torque: Vec<f64> = (0..samples).map(|k| load * angle(k).sin()).collect();
        let friction = FC * speed.signum() + FV * speed;
        let current = torque.iter().map(|g| {
            let error: f64 = StandardNormal.sample(&mut random);
            (g + mu * g.abs() * speed.signum() + friction) / K + noise * error
        });
        Part {
            speed,
            current: current.collect(),
            torque,
        }
    };
    speeds.iter().map(part).collect()
}

const SPEEDS: [f64; 8] = [-1.0, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1.0];

#[test]
fn recovers_known_truth_and_covers_it() {
    let runs = 200;
    let mut inside = [0; 3];
    for seed in 0..runs {
        let parts = parts(&SPEEDS, 40.0, 0.0, 0.2, seed);
        let stage = first_stage(&parts);
        let inverse = stage.inverse.unwrap();
        let terms = [Term::Coulomb, Term::Viscous];
        let second = second_stage(&stage, &terms, inverse).unwrap();
        let truth = [1.0 / K, FC / K, FV / K];
        let found = [
            inverse.value,
            second.coefficients[0],
            second.coefficients[1],
        ];
        for k in 0..3 {
            let sigma = second.covariance[(k, k)].sqrt();
            inside[k] += usize::from((found[k] - truth[k]).abs() <= 1.96 * sigma);
        }
    }
    // At least the share stated, less three standard deviations of a binomial share of 200; intervals
    // that widen with the scatter over the speeds cover more.
    let least = 0.95 - 3.0 * (0.95 * 0.05 / runs as f64).sqrt();
    for count in inside {
        assert!(count as f64 >= least * runs as f64, "{inside:?} of {runs}");
    }
}

#[test]
fn a_joint_without_load_has_no_torque_constant() {
    let stage = first_stage(&parts(&SPEEDS, 0.0, 0.0, 0.2, 1));
    assert_eq!(stage.inverse, None);
    let weak = first_stage(&parts(&SPEEDS, 0.05, 0.0, 0.2, 1));
    assert_eq!(weak.inverse, None);
}

#[test]
fn one_speed_does_not_tell_coulomb_from_viscous_friction() {
    let stage = first_stage(&parts(&[-0.63, 0.632, -0.631, 0.635], 40.0, 0.0, 0.2, 2));
    let terms = [Term::Coulomb, Term::Viscous];
    let inverse = stage.inverse.unwrap();
    assert!(second_stage(&stage, &terms, inverse).is_none());
    assert!(second_stage(&stage, &terms[..1], inverse).is_some());
}

#[test]
fn invariant_simplex_and_linear_solution_agree() {
    let stage = first_stage(&parts(&SPEEDS, 40.0, 0.0, 0.2, 3));
    for at in &stage.speeds {
        let [k, friction] = nelder_mead(&at.sums, 10.0).unwrap();
        let linear = 1.0 / at.inverse;
        let torque = linear * at.sums.current - at.sums.torque;
        // A cost that is flat to 1e-16 A² at its least leaves the argument known to the root of that.
        let reach = 1e-5;
        assert!((k / linear - 1.0).abs() < reach, "{k} {linear}");
        assert!(
            (friction / torque - 1.0).abs() < reach,
            "{friction} {torque}"
        );
    }
}

#[test]
fn recovers_known_truth_of_friction_that_grows_with_the_load() {
    let mu = 0.06;
    let loaded = parts(&SPEEDS, 40.0, mu, 0.1, 4);
    let stage = first_stage(&loaded);
    let found = load_dependence(&loaded, stage.variance).unwrap();
    assert!((found.mu - mu).abs() < 4.0 * found.std_dev);
    assert!((found.torque_constant - K).abs() < 4.0 * found.torque_constant_std_dev);
}

#[test]
fn steady_parts_are_found_without_their_ramps() {
    // 1 s rest, ramp of 0.25 s to 1 rad/s, 2 s at speed, ramp down, rest; the other joint stands.
    let time: Vec<f64> = (0..500).map(|k| k as f64 * 0.01).collect();
    let speed = |t: f64| {
        (4.0 * (t - 1.0))
            .clamp(0.0, 1.0)
            .min((4.0 * (3.5 - t)).clamp(0.0, 1.0))
    };
    let mut path = vec![0.0];
    for pair in time.windows(2) {
        let last = path[path.len() - 1];
        path.push(last + 0.5 * (speed(pair[0]) + speed(pair[1])) * 0.01);
    }
    let found = steady(
        &time,
        &[vec![0.2; 500], path.clone()],
        &Steadiness::default(),
    );
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].joint, 1);
    assert!((found[0].speed - 1.0).abs() < 1e-9);
    let ends = [time[found[0].samples.start], time[found[0].samples.end - 1]];
    assert!(
        ends[0] > 1.25 && ends[0] < 1.5 && ends[1] > 3.0 && ends[1] < 3.25,
        "{ends:?}"
    );
    // Two joints that move at once are no steady part of either.
    assert!(steady(&time, &[path.clone(), path], &Steadiness::default()).is_empty());
}

#[test]
fn joints_of_one_type_are_compared() {
    let equal = equality(&[(12.0, 0.1), (12.1, 0.1), (11.9, 0.1)]).unwrap();
    assert!((equal.mean - 12.0).abs() < 1e-12 && (equal.chi_squared - 2.0).abs() < 1e-9);
    // With two degrees of freedom the upper tail is exp(-χ²/2).
    assert!((equal.p_value - (-1.0_f64).exp()).abs() < 1e-9);
    let different = equality(&[(12.6351, 0.02), (12.0383, 0.02)]).unwrap();
    assert!(different.p_value < 1e-6);
    let (mean, sigma) = of_same_type(&[(12.6351, 0.0), (12.0383, 0.0)]).unwrap();
    assert!((mean - 12.3367).abs() < 1e-12);
    // Variance of two values, and that of their mean on top.
    let between = (12.6351_f64 - 12.0383).powi(2) / 2.0;
    assert!((sigma - (1.5 * between).sqrt()).abs() < 1e-12);
    assert_eq!(of_same_type(&[]), None);
}
