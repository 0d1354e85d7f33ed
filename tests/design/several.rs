//! Several motions designed together are worth more than one, and the motion for validation is another one.

use crate::bench::{Bench, deviations, holds};

/// Joints of the SCARA, and the largest position, velocity and acceleration of each beside its middle.
const JOINTS: usize = 4;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Mean distance from the states of a motion to the nearest of another; positions and velocities as shares of the
/// largest of the other's.
fn distance(from: &[Vec<f64>], to: &[Vec<f64>]) -> f64 {
    let columns = 1..=2 * JOINTS;
    let sizes: Vec<f64> = columns
        .clone()
        .map(|c| to.iter().map(|row| row[c].abs()).fold(0.0, f64::max))
        .collect();
    let between = |a: &[f64], b: &[f64]| -> f64 {
        let squares = columns.clone().zip(&sizes);
        let sum: f64 = squares.map(|(c, s)| ((a[c] - b[c]) / s).powi(2)).sum();
        sum.sqrt()
    };
    let nearest = |a: &Vec<f64>| {
        let all = to.iter().map(|b| between(a, b));
        all.fold(f64::INFINITY, f64::min)
    };
    let each: Vec<f64> = from.iter().step_by(10).map(nearest).collect();
    each.iter().sum::<f64>() / each.len() as f64
}

#[test]
fn two_motions_designed_together_tell_more_than_one_twice() {
    let bench = Bench::shipped("scara_excitation");
    let one = bench.design("one", &["design.starts=3"], 0);
    let two = bench.design("two", &["design.starts=3", "design.trajectories=2"], 0);
    assert!(holds(&one) && holds(&two));
    let motions = two["coefficients"]["trajectories"].as_array().unwrap();
    assert_eq!(motions.len(), 2);
    assert_ne!(motions[0], motions[1]);
    for name in ["trajectory.csv", "trajectory_2.csv"] {
        assert!(bench.path("two").join(name).exists(), "{name}");
    }
    let ratios: Vec<f64> = deviations(&two)
        .iter()
        .zip(deviations(&one))
        .map(|(two, one)| two / one)
        .collect();
    let middle = median(ratios.clone());
    println!("expected deviations, two motions over one: median {middle:.3}, {ratios:.3?}");
    // Twice the same motion would give 1/√2 of every deviation.
    assert!(middle <= 1.02 / 2f64.sqrt(), "{middle}");
}

#[test]
fn the_motion_for_validation_keeps_the_limits_and_is_far_from_the_designed_one() {
    let bench = Bench::shipped("scara_excitation");
    bench.design("out", &["design.starts=1"], 0);
    let designed = bench.trajectory("out", "trajectory.csv");
    let other = bench.trajectory("out", "validation_trajectory.csv");
    let (lower, upper) = ([-2.2, -2.5, 0.0, -6.0], [2.2, 2.5, 0.2, 6.0]);
    let velocity = [6.0, 9.0, 1.1, 15.0];
    for row in &other {
        for j in 0..JOINTS {
            assert!((lower[j]..=upper[j]).contains(&row[1 + j]), "{row:?}");
            assert!(row[1 + JOINTS + j].abs() <= velocity[j], "{row:?}");
        }
    }
    let halves = designed.split_at(designed.len() / 2);
    let within = distance(halves.1, halves.0);
    let apart = distance(&other, &designed);
    println!(
        "distance of states: {apart:.3} to the other motion, {within:.3} between halves of one"
    );
    assert!(apart > 0.5 * within && apart > 0.2, "{apart} {within}");
}
