//! An interrupt ends a long fit with the best so far, written whole; a period that nobody states is found.

mod common;

use common::arm::{Arm, EVERY_SAMPLE};
use common::interrupting::interrupt;
use serde_json::Value;
use std::fs;
use std::io::Read;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Periods of 200 samples: the search for w over 80 000 rows takes far longer than a signal does.
const PERIODS: usize = 400;

fn result(arm: &Arm) -> Value {
    let text = fs::read_to_string(arm.path("out/result.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn an_interrupt_leaves_the_best_so_far() {
    if !cfg!(target_os = "linux") {
        common::skip("whether a process catches interrupts is read from /proc");
        return;
    }
    let arm = Arm::new(PERIODS);
    for joint in ["shoulder", "elbow"] {
        let known = format!("\"{joint}.coulomb_friction.w\" = 0.01\n");
        arm.edit("problem.toml", &known, "");
    }
    arm.edit("problem.toml", "\"wls\"", "\"maximum_likelihood\"");
    let mut fit = arm.fit("out", &["--set", EVERY_SAMPLE]);
    fit.stderr(Stdio::piped());
    // While recordings are read there is nothing yet to leave; how long that takes is up to the machine.
    let mut delay = Duration::ZERO;
    while !arm.path("out").exists() {
        let mut child = fit.spawn().unwrap();
        let mut said = child.stderr.take().unwrap();
        assert_eq!(interrupt(child, delay), Some(130));
        let mut words = String::new();
        said.read_to_string(&mut words).unwrap();
        assert!(words.starts_with("interrupted: "), "{words}");
        assert_eq!(words.lines().count(), 1, "{words}");
        delay = delay * 5 / 4 + Duration::from_millis(10);
    }
    let result = result(&arm);
    assert_eq!(result["solver"]["stop"], "interrupted");
    assert_eq!(result["solver"]["converged"], false);
    let friction = (result["parameters"].as_array().unwrap().iter())
        .find(|p| p["name"] == "shoulder.viscous_friction.Fv");
    assert!(friction.unwrap()["value"].as_f64().is_some());
    for name in ["predictions.csv", "report.html"] {
        assert!(arm.path("out").join(name).exists(), "{name}");
    }
}

/// However early it comes: what the declared model leaves is found and reported as far as it was looked into.
#[test]
fn an_interrupted_diagnosis_reports_what_it_has() {
    if !cfg!(target_os = "linux") {
        common::skip("whether a process catches interrupts is read from /proc");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let problem = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/problems/arm6_gearbox/problem.toml"
    );
    // While recordings are read there is nothing yet to report; how long that takes is up to the machine.
    let mut delay = Duration::from_millis(300);
    let words = loop {
        let child = Command::new(env!("CARGO_BIN_EXE_exid"))
            .args(["diagnose", problem, "--quiet", "--out"])
            .arg(folder.path())
            .stderr(Stdio::piped())
            .spawn();
        let mut child = child.unwrap();
        let mut said = child.stderr.take().unwrap();
        assert_eq!(interrupt(child, delay), Some(130));
        let mut words = String::new();
        said.read_to_string(&mut words).unwrap();
        assert!(words.starts_with("interrupted: "), "{words}");
        if folder.path().join("result.json").exists() {
            break words;
        }
        delay = delay * 5 / 4;
    };
    assert_eq!(words.lines().count(), 1, "{words}");
    let text = fs::read_to_string(folder.path().join("result.json")).unwrap();
    let result: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(result["solver"]["stop"], "interrupted");
    assert_eq!(result["solver"]["converged"], false);
    assert!(result["verdict"].is_null(), "{}", result["verdict"]);
    let summary = result["summary"].as_str().unwrap();
    assert!(summary.contains("interrupted"), "{summary}");
    assert!(summary.contains("Not tried yet: "), "{summary}");
    let findings = result["findings"].as_array().unwrap();
    assert!(findings.iter().any(|f| f["joints"][0] == "a3"), "{summary}");
    for name in ["predictions.csv", "report.html"] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
}
