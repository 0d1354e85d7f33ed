//! The result of one experiment as prior knowledge of the next: the robot without load first, its links and
//! rotors with their covariance, then the load.

use crate::bench::{NAMES, Payload, open, problem_path};
use exid::outcome::parameter::Parameter;
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::simulate::{self, write_csv};
use exid::stats::distribution::Distribution;
use rayon::prelude::*;
use serde_json::Value;
use std::fs;
use std::fs::File;
use std::path::Path;
use std::process::Command;

const SEEDS: u64 = 24;

/// Probability with which the sums of squares below miss their limits by chance.
const FALSE_ALARM: f64 = 1e-3;

fn simulated(problem: &ProblemFile, seed: u64, file: &Path) {
    let made = simulate::run(problem, seed, &Control::default()).unwrap();
    write_csv(File::create(file).unwrap(), &made.recordings[0]).unwrap();
}

fn text(path: &Path) -> String {
    format!("{:?}", path.display().to_string())
}

/// The shipped problem with other recordings, in a file of its own, without the load if asked for.
fn problem_file(
    folder: &Path,
    name: &str,
    (recording, robot, loaded): (&str, &str, bool),
) -> String {
    let shipped = fs::read_to_string(problem_path()).unwrap();
    let urdf = problem_path().with_file_name("kr150.urdf");
    let load = if loaded { "payload = \"last\"" } else { "" };
    let replaced = shipped
        .replace(
            "urdf = \"kr150.urdf\"",
            &format!("urdf = {}\n{robot}", text(&urdf)),
        )
        .replace("payload = \"last\"", load)
        .replace("\"train.csv.gz\"", &text(&folder.join(recording)))
        .replace("[\"validation.csv.gz\"]", "[]");
    let path = folder.join(name);
    fs::write(&path, replaced).unwrap();
    path.display().to_string()
}

/// Links and rotors are unknown.
const UNKNOWN: [&str; 4] = [
    "--set",
    "robot.inertials=estimate",
    "--set",
    "drive.effects=[\"coulomb_friction\", \"viscous_friction\", \"transmission_efficiency\", \"rotor_inertia\"]",
];

/// Without load the last gear transmits a tenth of the noise, which says nothing of its efficiency: that is left to the
/// next experiment.
const BARE: [&str; 2] = [
    "--set",
    "drive.effects_of.a6=[\"coulomb_friction\", \"viscous_friction\", \"rotor_inertia\"]",
];

/// `exid fit` with settings; the results folder is `out`.
fn fit(problem: &str, settings: &[&str], out: &Path) -> Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    command
        .args(["fit", problem, "--json", "--threads", "1", "--out"])
        .arg(out)
        .args(settings);
    let output = command.output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Values and standard deviations of the load.
fn load_of(result: &Value) -> (Vec<f64>, Vec<f64>) {
    let parameters: Vec<Parameter> = serde_json::from_value(result["parameters"].clone()).unwrap();
    let deviation = |name: &&str| {
        let wanted = format!("payload.{name}");
        let found = parameters.iter().find(|p| p.name == wanted);
        found.unwrap().std_dev.unwrap()
    };
    let deviations = NAMES.iter().map(deviation).collect();
    (Payload::of(&parameters).value, deviations)
}

/// Errors of the load over their standard deviations after an earlier experiment, and how much larger these
/// deviations are than with links and rotors known exactly.
fn one(seed: u64) -> Vec<(f64, f64)> {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let inverse = "simulate.mode=inverse".to_string();
    let random = "simulate.trajectory=random".to_string();
    let mut bare = open(&[inverse.clone(), random]);
    bare.robot.payload = None;
    bare.simulate
        .values
        .retain(|entry| !entry.name.starts_with("payload."));
    simulated(&bare, 100 + seed, &at("bare.csv.gz"));
    let loaded = open(&[inverse]);
    simulated(&loaded, 200 + seed, &at("loaded.csv.gz"));
    let first = problem_file(folder.path(), "first.toml", ("bare.csv.gz", "", false));
    fit(&first, &[&UNKNOWN[..], &BARE].concat(), &at("first"));
    let earlier = format!("parameters = {}", text(&at("first/result.json")));
    let second = problem_file(
        folder.path(),
        "second.toml",
        ("loaded.csv.gz", &earlier, true),
    );
    let (found, deviations) = load_of(&fit(&second, &UNKNOWN, &at("second")));
    let alone = problem_file(folder.path(), "alone.toml", ("loaded.csv.gz", "", true));
    let (_, exact) = load_of(&fit(&alone, &[], &at("alone")));
    let robot = exid::setup::robot::open(&loaded).unwrap();
    let truth = Payload::of(&simulate::truth::build(&loaded, &robot).unwrap().parameters);
    (0..NAMES.len())
        .map(|k| {
            let error = (found[k] - truth.value[k]) / deviations[k];
            (error, deviations[k] / exact[k])
        })
        .collect()
}

#[test]
fn recovers_known_truth_with_an_earlier_experiment_as_prior_and_carries_its_uncertainty() {
    let all: Vec<Vec<(f64, f64)>> = (0..SEEDS).into_par_iter().map(one).collect();
    let squares = Distribution::ChiSquared {
        freedom: SEEDS as f64,
    };
    let tail = FALSE_ALARM / (2.0 * NAMES.len() as f64);
    let (low, high) = (squares.quantile(tail), squares.upper_quantile(tail));
    for (k, name) in NAMES.iter().enumerate() {
        let sum: f64 = all.iter().map(|errors| errors[k].0.powi(2)).sum();
        let growth = all.iter().map(|errors| errors[k].1).sum::<f64>() / SEEDS as f64;
        eprintln!(
            "payload.{name}: squares {sum:.1} of {SEEDS}, deviation {growth:.2} times that with links known"
        );
        assert!(
            (low..=high).contains(&sum),
            "{name}: {sum} outside {low} to {high}"
        );
        assert!(growth >= 1.0 - 0.05, "{name}: {growth}");
    }
    let mass = all.iter().map(|errors| errors[0].1).sum::<f64>() / SEEDS as f64;
    assert!(
        mass > 1.5,
        "the interval of the mass contains what the links leave open: {mass}"
    );
}
