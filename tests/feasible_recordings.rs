//! Feasible fits of recordings of real robots converge with every list of effects, the transition speeds of friction
//! given or estimated. The recordings are not shipped; without them these tests say that they skip.

mod common;

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

const EMPS: &str = include_str!("real_recordings/emps.urdf");

const ESTIMATORS: [&str; 2] = ["feasible", "feasible_maximum_likelihood"];

const LISTS: [&[&str]; 8] = [
    &["coulomb_friction"],
    &["coulomb_friction", "viscous_friction"],
    &["coulomb_friction", "viscous_friction", "torque_offset"],
    &[
        "coulomb_friction",
        "viscous_friction",
        "torque_offset",
        "rotor_inertia",
    ],
    &[
        "coulomb_friction",
        "viscous_friction",
        "torque_offset",
        "stribeck_friction",
    ],
    &[
        "coulomb_friction",
        "viscous_friction",
        "torque_offset",
        "asymmetric_friction",
    ],
    &[
        "coulomb_friction",
        "viscous_friction",
        "torque_offset",
        "load_dependent_friction",
    ],
    &["sigmoid_friction", "viscous_friction", "torque_offset"],
];

/// A key of the solver or of its certificate may be this share of the cost: what a fit that has converged promises.
const GAP: f64 = 1e-6;

/// kg to which double precision tells the eigenvalues of a pseudo-inertia of some tens of kilograms.
const ROUNDING: f64 = 1e-14;

/// The problem with other effects and another estimator, with transition speeds or without.
fn with(problem: &str, (effects, estimator): (&[&str], &str), given: bool) -> String {
    let listed: Vec<String> = effects.iter().map(|e| format!("\"{e}\"")).collect();
    let keep = |line: &&str| given || !line.contains("coulomb_friction.w\"");
    let line = |line: &str| match line.split_once(" = ") {
        Some(("effects", _)) => format!("effects = [{}]", listed.join(", ")),
        Some(("estimator", _)) => format!("estimator = \"{estimator}\""),
        _ => line.to_string(),
    };
    let lines: Vec<String> = problem.lines().filter(keep).map(line).collect();
    lines.join("\n")
}

/// Iterations of a fit that has to converge.
fn converged(data: &Path, what: &str, problem: &str) -> u64 {
    let folder = tempfile::tempdir().unwrap();
    let problem = problem.replace(
        "{data}",
        data.join("data").canonicalize().unwrap().to_str().unwrap(),
    );
    fs::write(folder.path().join("problem.toml"), problem).unwrap();
    fs::write(folder.path().join("robot.urdf"), EMPS).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder.path())
        .args(["fit", "problem.toml", "--json", "--out", "out"])
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{what}: {words}");
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(result["solver"]["converged"], Value::Bool(true), "{what}");
    let number = |value: &Value| value.as_f64().unwrap();
    let feasibility = &result["feasibility"];
    let share = number(&feasibility["gap"]) / number(&feasibility["cost"]);
    assert!(share <= GAP, "{what}: gap {share:.1e} of the cost");
    let least = number(&feasibility["least_eigenvalue"]);
    assert!(
        least >= number(&feasibility["margin"]) * (1.0 - 1e-9) - ROUNDING,
        "{what}: {least} kg"
    );
    result["solver"]["iterations"].as_u64().unwrap()
}

/// Which fits are made of the recordings of a robot.
#[derive(Clone, Copy)]
enum Fits {
    /// Least squares, transition speeds estimated where there are some.
    Some,
    /// Both estimators, transition speeds given and estimated.
    All,
}

fn all_converge(robot: &str, problem: &str, fits: Fits) {
    let Some(data) = common::data_dir() else {
        return;
    };
    for effects in LISTS {
        let (estimators, speeds): (&[&str], &[bool]) = match fits {
            Fits::Some => (&ESTIMATORS[..1], &[false]),
            Fits::All if effects.contains(&"coulomb_friction") => (&ESTIMATORS, &[true, false]),
            Fits::All => (&ESTIMATORS, &[false]),
        };
        for (estimator, given) in estimators
            .iter()
            .flat_map(|e| speeds.iter().map(move |s| (e, s)))
        {
            let what = format!(
                "{robot}, {estimator}, {effects:?}, w {}",
                if *given { "given" } else { "free" }
            );
            let iterations = converged(&data, &what, &with(problem, (effects, estimator), *given));
            eprintln!("{what}: {iterations} iterations");
        }
    }
}

const UR10E: &str = include_str!("real_recordings/ur10e.toml");
const TX40: &str = include_str!("real_recordings/tx40.toml");

#[test]
fn ur10e_converges_with_every_list_of_effects() {
    all_converge("UR10e", UR10E, Fits::Some);
}

#[test]
fn tx40_converges_with_every_list_of_effects() {
    all_converge("TX40", TX40, Fits::Some);
}

#[test]
fn emps_converges_with_every_list_of_effects() {
    let problem = include_str!("real_recordings/emps.toml");
    all_converge("EMPS", problem, Fits::All);
}

/// With the velocities and accelerations of the file, whose best fit has bodies without bound.
fn lwr4() -> String {
    let file = |number: u8| format!("\"{{data}}/lwr4/measurements_{number}.csv\"");
    include_str!("real_recordings/lwr4.toml")
        .replace("{train}", &file(1))
        .replace("{validation}", &file(2))
        .replace("torque = \"tau{n}\"", "torque = \"tau{n}\"\nvelocity = \"dq{n}\"\nacceleration = \"ddq{n}\"")
        .replace("[recordings.differentiation]\nmethod = \"lowpass\"\ncutoff_hz = 6.0\nparallel_hz = 6.0\n", "")
}

#[test]
fn lwr4_converges_with_every_list_of_effects() {
    all_converge("LWR4+", &lwr4(), Fits::Some);
}

#[test]
#[ignore = "eleven minutes; converges with both estimators, transition speeds given and estimated"]
fn all_robots_converge_with_every_list_of_effects_in_every_way() {
    all_converge("UR10e", UR10E, Fits::All);
    all_converge("TX40", TX40, Fits::All);
    all_converge("LWR4+", &lwr4(), Fits::All);
}
