//! Recordings of a simulator beside those of the robot: what differs, what is in one alone, what agrees.

mod common;

use common::arm::URDF;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

const PROBLEM: &str = r#"name = "arm"

[robot]
urdf = "arm.urdf"

[drive]
torque_constant = [12.0, 8.0]
rotor_inertia = [0.3, 0.1]
effects = ["coulomb_friction", "viscous_friction"]

[recordings]
train = ["train.csv"]
validation = ["validation.csv"]
period = 5.0

[simulate]
trajectory = "random"
periods = 4
rate = 200.0

[simulate.values]
"shoulder.Fc" = 3.0
"elbow.Fc" = 1.2
"elbow.Fv" = 0.8
"#;

/// What the simulator has.
const SIMULATED: &str = "\"shoulder.Fv\" = 2.0\n";

/// What the robot has.
const REAL: &str = "\"shoulder.Fv\" = 3.0\n\"shoulder.transmission_efficiency.R\" = 0.8\n";

fn exid(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|b| String::from_utf8(b).unwrap());
    (output.status.code().unwrap(), out + &err)
}

fn says(folder: &Path, arguments: &[&str]) -> String {
    let (code, text) = exid(folder, arguments);
    assert_eq!(code, 0, "{arguments:?}\n{text}");
    text
}

/// Recordings of a simulator without noise and of a robot, at other motions.
fn recorded(real: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("arm.urdf"), URDF).unwrap();
    let noise = "noise = [0.01, 0.01]\nencoder_counts = 524288\n";
    let noisy = PROBLEM.replace("rate = 200.0\n", &format!("rate = 200.0\n{noise}"));
    fs::write(at.join("sim.toml"), format!("{PROBLEM}{SIMULATED}")).unwrap();
    fs::write(at.join("real.toml"), format!("{noisy}{real}")).unwrap();
    says(
        at,
        &[
            "simulate", "sim.toml", "--seed", "7", "--quiet", "--out", "s",
        ],
    );
    says(
        at,
        &[
            "simulate",
            "real.toml",
            "--seed",
            "1",
            "--quiet",
            "--out",
            "r",
        ],
    );
    fs::copy(at.join("s/train.csv"), at.join("sim.csv")).unwrap();
    for name in ["train.csv", "validation.csv"] {
        fs::copy(at.join("r").join(name), at.join(name)).unwrap();
    }
    let beside = PROBLEM.replace("period = 5.0", "simulated = [\"sim.csv\"]\nperiod = 5.0");
    fs::write(at.join("problem.toml"), beside).unwrap();
    folder
}

fn compared(at: &Path, out: &str) -> Value {
    let text = fs::read_to_string(at.join(out).join("result.json")).unwrap();
    let result: Value = serde_json::from_str(&text).unwrap();
    result["simulator"].clone()
}

fn names(list: &Value) -> Vec<String> {
    let list = list.as_array().unwrap().iter();
    list.map(|entry| entry["parameter"].as_str().unwrap().to_string())
        .collect()
}

#[test]
fn recovers_what_a_robot_has_and_its_simulator_has_not() {
    let folder = recorded(REAL);
    let at = folder.path();
    let shown = says(at, &["diagnose", "problem.toml", "--out", "found"]);
    println!("{shown}");
    let found = compared(at, "found");
    assert_eq!(
        names(&found["differences"]),
        ["shoulder.viscous_friction.Fv"]
    );
    let difference = &found["differences"][0];
    let [low, high] = [0, 1].map(|k| difference["ci95"][k].as_f64().unwrap());
    assert!(low < 1.0 && 1.0 < high && high - low > 0.0, "{difference}");
    assert!((difference["simulated"].as_f64().unwrap() - 2.0).abs() < 0.02);
    let alone = found["only_robot"].as_array().unwrap();
    assert_eq!(alone.len(), 1, "{alone:#?}");
    assert_eq!(alone[0]["effect"], "transmission_efficiency");
    assert_eq!(alone[0]["joints"][0], "shoulder");
    assert!(found["only_simulator"].as_array().unwrap().is_empty());
    assert!(names(&found["agree"]).contains(&"elbow.coulomb_friction.Fc".to_string()));
    assert!(found["notes"].as_array().unwrap().is_empty(), "{found:#}");
    assert!(
        shown.contains("In the simulation shoulder.viscous_friction.Fv"),
        "{shown}"
    );
    assert!(
        shown.contains("Only on the robot: shoulder loses"),
        "{shown}"
    );
    let page = fs::read_to_string(at.join("found/report.html")).unwrap();
    assert!(page.contains("Simulation and robot"));
    let again = says(at, &["repeat", "found", "--threads", "1"]);
    assert!(again.contains("the same, to the bit"), "{again}");
}

#[test]
fn invariant_a_simulator_that_is_right_differs_in_nothing() {
    let folder = recorded(SIMULATED);
    let at = folder.path();
    for verb in ["diagnose", "fit"] {
        says(at, &[verb, "problem.toml", "--quiet", "--out", verb]);
        let found = compared(at, verb);
        assert!(names(&found["differences"]).is_empty(), "{found:#}");
        for alone in ["only_robot", "only_simulator"] {
            assert!(found[alone].as_array().unwrap().is_empty(), "{found:#}");
        }
        // Without noise in the simulator, the width is that of the robot's recordings at least.
        for agreed in found["agree"].as_array().unwrap() {
            assert!(
                agreed["ci95"][1].as_f64() > agreed["ci95"][0].as_f64(),
                "{agreed}"
            );
        }
    }
}

/// Changes every row of a table, of which the columns are known by name.
fn change(path: &Path, mut row: impl FnMut(&[&str], &mut [f64])) {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let head = lines.next().unwrap();
    let names: Vec<&str> = head.split(',').collect();
    assert!(names.iter().any(|name| name.starts_with('i')), "{head}");
    let mut changed = format!("{head}\n");
    for line in lines {
        let mut values: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        row(&names, &mut values);
        let values: Vec<String> = values.iter().map(|x| format!("{x:?}")).collect();
        changed.push_str(&format!("{}\n", values.join(",")));
    }
    fs::write(path, changed).unwrap();
}

/// A low pass of first order between the simulator's signals and its file.
fn filter(path: &Path, cutoff_hz: f64) {
    let mut kept: Vec<f64> = Vec::new();
    let share = 1.0 - (-2.0 * std::f64::consts::PI * cutoff_hz / 200.0).exp();
    change(path, |names, row| {
        if kept.is_empty() {
            kept.extend_from_slice(row);
        }
        let signals = (0..row.len()).filter(|&k| names[k].starts_with('i'));
        for k in signals {
            kept[k] += share * (row[k] - kept[k]);
            row[k] = kept[k];
        }
    });
}

#[test]
fn a_filter_in_the_simulation_is_late_there_and_leaves_what_is_said() {
    let folder = recorded(SIMULATED);
    let at = folder.path();
    filter(&at.join("sim.csv"), 10.0);
    let shown = says(at, &["diagnose", "problem.toml", "--out", "found"]);
    println!("{shown}");
    let found = compared(at, "found");
    let alone = found["only_simulator"].as_array().unwrap();
    assert!(
        alone.iter().any(|found| found["effect"] == "time_delay"),
        "{shown}"
    );
    let notes = found["notes"].to_string();
    assert!(notes.contains("unexplained, beyond their noise"), "{shown}");
    assert!(!notes.contains("Of the robot's signals"), "{shown}");
}

/// A simulator without noise shows the errors of its own integration; what takes less than a fifth of a percent of its signal is no difference.
#[test]
fn what_a_simulator_shows_and_does_not_matter_is_no_difference() {
    let folder = recorded(SIMULATED);
    let at = folder.path();
    // A.
    const SIZE: f64 = 1e-3;
    let mut squares = Vec::new();
    change(&at.join("sim.csv"), |names, row| {
        let column = |name: &str| names.iter().position(|n| *n == name).unwrap();
        let [q1, q2, current] = ["q1", "q2", "i1"].map(column);
        squares.push(row[current].powi(2));
        row[current] += SIZE * (4.0 * row[q1]).sin() * (3.0 * row[q2]).cos();
    });
    let signal = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!(SIZE < 0.002 * signal, "{signal}");
    says(
        at,
        &["diagnose", "problem.toml", "--quiet", "--out", "found"],
    );
    let found = compared(at, "found");
    let findings = found["findings"].as_array().unwrap();
    assert!(!findings.is_empty(), "{found:#}");
    assert_eq!(found["only_simulator"], json!([]), "{found:#}");
    assert_eq!(found["only_robot"], json!([]), "{found:#}");
}

#[test]
fn two_simulators_without_noise_are_told_apart_by_what_matters() {
    let folder = recorded(SIMULATED);
    let at = folder.path();
    // The other motion of the simulator in the place of the robot.
    fs::copy(at.join("s/validation.csv"), at.join("train.csv")).unwrap();
    let text = fs::read_to_string(at.join("problem.toml")).unwrap();
    let alone = text.replace("validation = [\"validation.csv\"]\n", "");
    fs::write(at.join("problem.toml"), alone).unwrap();
    says(
        at,
        &["diagnose", "problem.toml", "--quiet", "--out", "found"],
    );
    let found = compared(at, "found");
    assert!(names(&found["differences"]).is_empty(), "{found:#}");
    assert!(found["only_robot"].as_array().unwrap().is_empty());
    assert!(found["only_simulator"].as_array().unwrap().is_empty());
}

#[test]
fn a_recording_is_of_the_robot_or_of_the_simulator() {
    let folder = recorded(SIMULATED);
    let at = folder.path();
    let text = fs::read_to_string(at.join("problem.toml")).unwrap();
    fs::write(
        at.join("problem.toml"),
        text.replace("sim.csv", "train.csv"),
    )
    .unwrap();
    let (code, said) = exid(at, &["diagnose", "problem.toml"]);
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("of the robot and of the simulator"), "{said}");
}
