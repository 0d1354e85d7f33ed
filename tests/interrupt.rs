//! An interrupt ends a long fit with the best so far, written whole; a period that nobody states is found.

mod common;

use common::arm::{Arm, EVERY_SAMPLE};
use serde_json::Value;
use std::fs;
use std::process::{Child, Command};
use std::thread::sleep;
use std::time::Duration;

/// Periods of 200 samples: the search for w over 80 000 rows takes far longer than a signal does.
const PERIODS: usize = 400;

const SIGINT: u32 = 2;

fn result(arm: &Arm) -> Value {
    let text = fs::read_to_string(arm.path("out/result.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Whether a process catches interrupts by now, as the system sees it.
fn catches_interrupts(child: &Child) -> bool {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    let mask = caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & (1 << (SIGINT - 1)) != 0)
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
    let mut child = arm.fit("out", &["--set", EVERY_SAMPLE]).spawn().unwrap();
    while !catches_interrupts(&child) {
        assert!(child.try_wait().unwrap().is_none(), "ended before its time");
        sleep(Duration::from_micros(200));
    }
    let process = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &process]).status();
    assert!(sent.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
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
