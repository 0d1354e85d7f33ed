//! A channel that hears another: a fit estimates its share, and a diagnosis names it in its direction. The recordings are mixed
//! here, column by column, without the program.

mod common;

use common::arm::{Arm, PERIOD};
use serde_json::Value;
use std::fs;
use std::process::Command;

/// Share of the shoulder's current in what is recorded of the elbow.
const SHARE: f64 = 0.07;

/// An honest estimate lies further off once in ten thousand times.
const STANDARD_DEVIATIONS: f64 = 4.0;

/// An arm whose elbow's channel hears the shoulder's.
fn mixed() -> Arm {
    let arm = Arm::new(4);
    for name in ["train.csv", "validation.csv"] {
        let text = fs::read_to_string(arm.path(name)).unwrap();
        let mut lines = text.lines();
        let mut out = format!("{}\n", lines.next().unwrap());
        for line in lines {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            let [t, q1, q2, i1, i2] = cells[..] else {
                panic!("{line}")
            };
            out += &format!("{t},{q1},{q2},{i1},{:.6}\n", i2 + SHARE * i1);
        }
        arm.write(name, out);
    }
    arm
}

fn run(arm: &Arm, verb: &str, further: &[&str]) -> Value {
    let period = format!("recordings.period={PERIOD:.1}");
    let output = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(arm.folder())
        .args([
            verb,
            "problem.toml",
            "--quiet",
            "--out",
            "out",
            "--set",
            &period,
        ])
        .args(further)
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words}");
    serde_json::from_str(&fs::read_to_string(arm.path("out/result.json")).unwrap()).unwrap()
}

/// Value and standard deviation of a parameter.
fn estimated(result: &Value, name: &str) -> [f64; 2] {
    let mut all = result["parameters"].as_array().unwrap().iter();
    let found = all.find(|p| p["name"] == name);
    let found = found.unwrap_or_else(|| panic!("{name} is not in {result}"));
    ["value", "std_dev"].map(|key| found[key].as_f64().unwrap())
}

#[test]
fn a_fit_estimates_the_share_and_the_drive_as_without_it() {
    let (arm, plain) = (mixed(), Arm::new(4));
    let effects =
        "drive.effects_of.elbow=[\"coulomb_friction\",\"viscous_friction\",\"channel_crosstalk\"]";
    let found = run(&arm, "fit", &["--set", effects]);
    let without = run(&plain, "fit", &[]);
    let [share, deviation] = estimated(&found, "elbow.channel_crosstalk.shoulder");
    let off = (share - SHARE).abs() / deviation;
    assert!(off < STANDARD_DEVIATIONS, "{share} ± {deviation}");
    for name in ["elbow.coulomb_friction.Fc", "elbow.viscous_friction.Fv"] {
        let [[value, deviation], [expected, _]] = [&found, &without].map(|of| estimated(of, name));
        let off = (value - expected).abs() / deviation;
        assert!(
            off < STANDARD_DEVIATIONS,
            "{name}: {value} ± {deviation}, not {expected}"
        );
    }
}

#[test]
fn a_diagnosis_names_the_channel_that_hears_before_the_one_that_is_heard() {
    let arm = mixed();
    let validation = "recordings.validation=[\"validation.csv\"]";
    let found = run(&arm, "diagnose", &["--set", validation]);
    let findings = found["findings"].as_array().unwrap();
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert_eq!(findings[0]["effect"], "channel_crosstalk");
    assert_eq!(
        findings[0]["joints"],
        serde_json::json!(["elbow", "shoulder"])
    );
}
