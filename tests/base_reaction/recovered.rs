//! Fits by the program: known truths from the reaction of the base, whatever the joints do.

use crate::common::arm::Noise;
use crate::{LEADING, model, published_theta_d, shipped};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Runs the program in a folder; gives what it prints as JSON.
fn exid(folder: &Path, arguments: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder)
        .args(arguments)
        .arg("--json")
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// θ_d of a result in the paper's order: value and standard deviation.
fn theta_d(result: &Value, key: &str) -> Vec<(f64, f64)> {
    let all = result[key].as_array().unwrap();
    let of = |name: &&str| {
        let leads = |p: &&Value| {
            let expression = p["expression"].as_str().unwrap();
            expression.split(' ').next() == Some(name)
        };
        let found = all
            .iter()
            .find(leads)
            .unwrap_or_else(|| panic!("{name} in {key}"));
        (
            found["value"].as_f64().unwrap(),
            found["std_dev"].as_f64().unwrap(),
        )
    };
    LEADING.iter().map(of).collect()
}

/// Effects that the shipped recordings hold and the shipped problem does not declare.
const EFFECTS: &str = r#"drive.effects=["coulomb_friction","viscous_friction","drive_gain"]"#;

/// A share of 1e-4 of truths lies further from an honest estimate: 9 of them in 3 fits.
const STANDARD_DEVIATIONS: f64 = 4.0;

#[test]
fn recovers_known_truth_whatever_the_joints_do() {
    let folder = tempfile::tempdir().unwrap();
    let problem = shipped();
    let problem = problem.to_str().unwrap();
    let truth = published_theta_d(model(&shipped(), &[]).tree());
    let deviations = |found: &[(f64, f64)]| -> Vec<f64> {
        found
            .iter()
            .zip(truth)
            .map(|((value, sd), t)| (value - t).abs() / sd)
            .collect()
    };
    let base = exid(folder.path(), &["fit", problem]);
    let worst = |all: Vec<f64>| all.into_iter().fold(0.0, f64::max);
    let base_worst = worst(deviations(&theta_d(&base, "joint_torque_parameters")));
    assert!(
        base_worst < STANDARD_DEVIATIONS,
        "base reactions: {base_worst}"
    );
    let torque = exid(
        folder.path(),
        &["fit", problem, "--set", "recordings.signal=torque"],
    );
    let torque_found = theta_d(&torque, "base_parameters");
    // Friction and gains are not in the model: the usual way is off by more than a tenth somewhere.
    let errors = torque_found
        .iter()
        .zip(truth)
        .map(|((value, _), t)| (value - t).abs() / t.abs());
    assert!(errors.fold(0.0, f64::max) > 0.1);
    let both = [
        "fit",
        problem,
        "--set",
        "recordings.signal=both",
        "--set",
        EFFECTS,
        "--set",
        "fit.estimator=maximum_likelihood",
    ];
    let both = exid(folder.path(), &both);
    let both_worst = worst(deviations(&theta_d(&both, "joint_torque_parameters")));
    assert!(both_worst < STANDARD_DEVIATIONS, "both: {both_worst}");
    for (joint, gain) in [("joint1", 0.93), ("joint2", 1.06), ("joint3", 0.97)] {
        let name = format!("{joint}.drive_gain.gain");
        let parameters = both["parameters"].as_array().unwrap();
        let found = parameters
            .iter()
            .find(|p| p["name"] == name.as_str())
            .unwrap();
        let value = |key: &str| found[key].as_f64().unwrap();
        let off = (value("value") - gain).abs() / value("std_dev");
        assert!(
            off < STANDARD_DEVIATIONS,
            "{name}: {} off by {off}",
            value("value")
        );
    }
}

/// Some columns of a table, positions with noise spread evenly over ± `noise`, rad.
fn columns(from: &Path, to: &Path, (keep, noise): (fn(&str) -> bool, f64)) {
    let text = fs::read_to_string(from).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let kept: Vec<usize> = (0..header.len()).filter(|&k| keep(header[k])).collect();
    let names: Vec<&str> = kept.iter().map(|&k| header[k]).collect();
    let mut random = Noise(7);
    let mut out = names.join(",");
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |&k: &usize| match header[k].starts_with('q') {
            true => (cells[k].parse::<f64>().unwrap() + noise * random.next()).to_string(),
            false => cells[k].to_string(),
        };
        let row: Vec<String> = kept.iter().map(cell).collect();
        out.push('\n');
        out.push_str(&row.join(","));
    }
    fs::write(to, out + "\n").unwrap();
}

/// Recordings of one motion: `plate.csv` without positions, `camera.csv` with nothing else.
fn plate_and_camera(folder: &Path) {
    /// rad; half of the width of the camera's noise.
    const CAMERA: f64 = 2e-4;
    for (out, rate) in [("plate", "50"), ("camera", "30")] {
        let rate = format!("recordings.rate={rate}");
        let list = [
            "recordings.train=[\"train.csv\"]",
            "recordings.validation=[]",
        ];
        let mut arguments = vec!["simulate", "problem.toml", "--out", out, "--seed", "1"];
        for set in [rate.as_str(), "recordings.signal=both", list[0], list[1]] {
            arguments.extend(["--set", set]);
        }
        exid(folder, &arguments);
    }
    columns(
        &folder.join("plate/train.csv"),
        &folder.join("plate.csv"),
        (|name| name == "t" || name.starts_with("plate_"), 0.0),
    );
    columns(
        &folder.join("camera/train.csv"),
        &folder.join("camera.csv"),
        (|name| name == "t" || name.starts_with('q'), CAMERA),
    );
}

/// A camera at 30 Hz sees the joints to a fifth of a milliradian; the plate under the robot is read at 50 Hz.
#[test]
fn recovers_known_truth_with_positions_from_a_sensor_of_its_own() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    for file in ["problem.toml", "puma562.urdf"] {
        fs::copy(shipped().with_file_name(file), folder.join(file)).unwrap();
    }
    plate_and_camera(folder);
    let sets = [
        "recordings.train=[\"plate.csv\"]",
        "recordings.validation=[]",
        "recordings.positions={\"plate.csv\"=\"camera.csv\"}",
    ];
    let mut arguments = vec!["fit", "problem.toml"];
    sets.iter().for_each(|set| arguments.extend(["--set", set]));
    let result = exid(folder, &arguments);
    let truth = published_theta_d(model(&shipped(), &[]).tree());
    let found = theta_d(&result, "joint_torque_parameters");
    for (k, ((value, sd), truth)) in found.into_iter().zip(truth).enumerate() {
        eprintln!("θd({}): {value:.4} ± {sd:.4} for {truth:.4}", k + 1);
        assert!((value - truth).abs() < STANDARD_DEVIATIONS * sd, "{k}");
        // As accurate as a plate of 1 % allows: what the camera adds is small beside it.
        assert!(sd < 0.02 * truth.abs().max(0.5), "{k}: {sd}");
    }
    // A recording that is not listed has no positions.
    let stray = sets[2].replace("{\"plate.csv\"", "{\"plate\"");
    let output = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder)
        .args([
            "fit",
            "problem.toml",
            "--set",
            sets[0],
            "--set",
            sets[1],
            "--set",
            &stray,
        ])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no recording"));
}

/// Section 5.3: the third link alone moves, without and with a load on z³.
const LOAD_PROBLEM: &str = r#"name = "load"
[robot]
urdf = "puma562.urdf"
locked = { joint1 = 0.0, joint2 = 0.0 }
payload = "last"
[recordings]
train = ["train.csv"]
loaded = ["loaded.csv"]
signal = "base_wrench"
rate = 50.0
period = 8.0
[fit]
estimator = "wls"
[design]
harmonics = 3
[simulate]
periods = 4
[simulate.values]
"payload.mass" = 3.87
"payload.com_x" = 0.0
"payload.com_y" = 0.0
"payload.com_z" = 0.514
"payload.inertia_xx" = 0.0
"payload.inertia_xy" = 0.0
"payload.inertia_xz" = 0.0
"payload.inertia_yy" = 0.0
"payload.inertia_yz" = 0.0
"payload.inertia_zz" = 0.0
"#;

const SEEDS: usize = 50;

/// Root mean square of each component of the wrench in a recording.
fn sizes(path: &Path) -> Vec<f64> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    let of = |name: &str| {
        let k = header.iter().position(|h| *h == name).unwrap();
        let squares: f64 = rows.iter().map(|row| row[k] * row[k]).sum();
        (squares / rows.len() as f64).sqrt()
    };
    ["fx", "fy", "fz", "mx", "my", "mz"].map(of).to_vec()
}

/// Noise of 1 % of the larger of both recordings' RMS; none where a component is always zero.
fn one_percent(clean: &Path) -> String {
    let pairs = sizes(&clean.join("train.csv"))
        .into_iter()
        .zip(sizes(&clean.join("loaded.csv")));
    let noise: Vec<f64> = pairs.map(|(a, b)| 0.01 * a.max(b)).collect();
    format!("simulate.noise={noise:?}")
}

/// The one combination of a fit that is a parameter by itself.
fn alone(result: &Value, name: &str) -> f64 {
    let combinations = result["posterior"]["combinations"].as_array().unwrap();
    let is_it = |c: &&Value| {
        c["terms"].as_array().unwrap().len() == 1 && c["terms"][0]["parameter"] == name
    };
    let found = combinations.iter().find(is_it);
    let found = found.unwrap_or_else(|| panic!("{name}"));
    found["value"].as_f64().unwrap()
}

#[test]
fn recovers_a_known_load_as_well_as_published() {
    let folder = tempfile::tempdir().unwrap();
    let robot = shipped().with_file_name("puma562.urdf");
    fs::copy(robot, folder.path().join("puma562.urdf")).unwrap();
    fs::write(folder.path().join("problem.toml"), LOAD_PROBLEM).unwrap();
    exid(
        folder.path(),
        &["simulate", "problem.toml", "--out", "clean"],
    );
    let clean = folder.path().join("clean");
    fs::copy(
        clean.join("train.trajectory.csv"),
        folder.path().join("path.csv"),
    )
    .unwrap();
    let noise = one_percent(&clean);
    let exact = [3.87 * 0.514, 3.87 * 0.514 * 0.514];
    let mut errors = [0.0; 2];
    for seed in 0..SEEDS {
        let seed = seed.to_string();
        let simulate = [
            "simulate",
            "problem.toml",
            "--out",
            "noisy",
            "--seed",
            &seed,
            "--set",
            &noise,
            "--set",
            "simulate.trajectory=\"path.csv\"",
        ];
        exid(folder.path(), &simulate);
        let fit = [
            "fit",
            "problem.toml",
            "--set",
            "recordings.train=[\"noisy/train.csv\"]",
            "--set",
            "recordings.loaded=[\"noisy/loaded.csv\"]",
        ];
        let result = exid(folder.path(), &fit);
        for (error, (name, exact)) in errors
            .iter_mut()
            .zip(["payload.mcz", "payload.Iyy"].iter().zip(exact))
        {
            *error += (alone(&result, name) / exact - 1.0).abs() / SEEDS as f64;
        }
    }
    println!(
        "mean errors over {SEEDS} seeds: Ml {:.2} %, Ml² {:.2} %",
        100.0 * errors[0],
        100.0 * errors[1]
    );
    // Table 2 of the paper: 1.949 for 1.989 kg·m, 1.052 for 1.025 kg·m².
    assert!(errors[0] <= 0.020 && errors[1] <= 0.029, "{errors:?}");
}
