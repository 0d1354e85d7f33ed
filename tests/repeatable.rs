//! The same problem gives the same bits for any number of threads.

mod common;

use common::arm::{Arm, EVERY_SAMPLE, PERIOD};
use serde_json::Value;
use std::fs;

/// Compared with each other; the machine may have fewer processors.
const THREADS: [&str; 3] = ["1", "2", "8"];

/// Periods of 200 samples: with 16 000 rows, and 8 000 where two long periods are averaged, the work is
/// shared between threads.
const PERIODS: usize = 80;

/// Result without the time that the run took and where it comes from, and predictions.
fn results(arm: &Arm, out: &str) -> (String, Vec<u8>) {
    let folder = arm.path(out);
    let text = fs::read_to_string(folder.join("result.json")).unwrap();
    let mut result: Value = serde_json::from_str(&text).unwrap();
    let wall = result.as_object_mut().unwrap().shift_remove("wall_s");
    assert!(wall.is_some_and(|seconds| seconds.is_number()));
    let provenance = result.as_object_mut().unwrap().shift_remove("provenance");
    assert!(provenance.is_some_and(|p| p["threads"].is_number()));
    // Numbers are written so that they are read back to the same bits.
    let predictions = fs::read(folder.join("predictions.csv")).unwrap();
    (result.to_string(), predictions)
}

/// Fits with every number of threads, with further arguments, and compares with the first.
fn assert_same_for_any_threads(arm: &Arm, further: &[&str]) {
    arm.edit(
        "problem.toml",
        "train = [\"train.csv\"]",
        "train = [\"train.csv\"]\nvalidation = [\"validation.csv\"]",
    );
    let mut first = None;
    for threads in THREADS {
        let mut fit = arm.fit("out", further);
        let output = fit.args(["--threads", threads]).output().unwrap();
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{words}");
        let found = results(arm, "out");
        let expected = first.get_or_insert_with(|| found.clone());
        assert!(found.0 == expected.0, "result.json, {threads} threads");
        assert!(found.1 == expected.1, "predictions.csv, {threads} threads");
    }
}

/// An arm whose friction at low speed is estimated, which makes the fit nonlinear.
fn nonlinear() -> Arm {
    let arm = Arm::new(PERIODS);
    for joint in ["shoulder", "elbow"] {
        let known = format!("\"{joint}.coulomb_friction.w\" = 0.01\n");
        arm.edit("problem.toml", &known, "");
    }
    arm.edit("problem.toml", "\"wls\"", "\"maximum_likelihood\"");
    arm
}

/// The motion repeats after forty of its periods too.
fn long_period() -> String {
    format!("recordings.period={}", PERIOD * (PERIODS / 2) as f64)
}

#[test]
fn invariant_weighted_least_squares() {
    assert_same_for_any_threads(&Arm::new(PERIODS), &["--set", EVERY_SAMPLE]);
}

#[test]
fn invariant_weighted_least_squares_of_periods() {
    assert_same_for_any_threads(&Arm::new(PERIODS), &["--set", &long_period()]);
}

#[test]
fn invariant_maximum_likelihood() {
    assert_same_for_any_threads(&nonlinear(), &["--set", EVERY_SAMPLE]);
}

#[test]
fn invariant_maximum_likelihood_of_periods() {
    assert_same_for_any_threads(&nonlinear(), &["--set", &long_period()]);
}

#[test]
fn another_recording_gives_other_bits() {
    let arm = Arm::new(PERIODS);
    let mut found = Vec::new();
    for recording in ["train.csv", "validation.csv"] {
        let train = format!("recordings.train=[\"{recording}\"]");
        let status = arm.fit("out", &["--set", &train]).status().unwrap();
        assert!(status.success());
        found.push(results(&arm, "out"));
    }
    assert_ne!(found[0].1, found[1].1);
}
