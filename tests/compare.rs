//! `exid compare` from outside: two fits of the same arm agree, one of another arm does not.

mod common;

use common::arm::Arm;
use serde_json::Value;
use std::process::Command;

fn fit(arm: &Arm, out: &str, further: &[&str]) {
    assert!(arm.fit(out, further).status().unwrap().success(), "{out}");
}

fn compare(arm: &Arm, arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    let output = command
        .current_dir(arm.folder())
        .arg("compare")
        .args(arguments)
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words}");
    String::from_utf8(output.stdout).unwrap()
}

/// Names of what differs significantly.
fn differing(arm: &Arm, first: &str, second: &str) -> Vec<String> {
    let compared: Value = serde_json::from_str(&compare(arm, &[first, second, "--json"])).unwrap();
    let parameters = compared["parameters"].as_array().unwrap();
    assert!(
        parameters
            .iter()
            .filter(|p| p["p_value"].is_number())
            .count()
            > 5
    );
    let differing = parameters.iter().filter(|p| p["differs"] == true);
    differing
        .map(|p| p["name"].as_str().unwrap().to_owned())
        .collect()
}

#[test]
fn only_what_is_another_arm_differs() {
    let arm = Arm::new(20);
    let other = ["--set", "recordings.train=[\"validation.csv\"]"];
    fit(&arm, "a", &[]);
    fit(&arm, "b", &other);
    // The same currents stand for a fifth more torque at the elbow.
    fit(
        &arm,
        "c",
        &[&other[..], &["--set", "drive.torque_constant=[12.0, 9.6]"]].concat(),
    );
    assert_eq!(differing(&arm, "a", "b"), [""; 0]);
    let found = differing(&arm, "a", "c");
    assert!(
        found.iter().any(|name| name == "elbow.coulomb_friction.Fc"),
        "{found:?}"
    );
    assert!(
        !found.iter().any(|name| name.starts_with("shoulder.")),
        "{found:?}"
    );
    let text = compare(&arm, &["a/result.json", "b"]);
    assert!(
        text.contains("0 of ") && text.contains("those of independent data"),
        "{text}"
    );
    assert!(text.lines().count() <= 40, "{text}");
    let all = compare(&arm, &["a", "b", "--all"]);
    assert!(all.contains("shoulder.viscous_friction.Fv"), "{all}");
    assert!(all.lines().count() > text.lines().count(), "{all}");
    // The folder above the results names them.
    let said = common::program::says(arm.folder(), &["compare", ".", "b"], 2);
    assert!(
        said.contains("holds results; name one of ./a, ./b, ./c"),
        "{said}"
    );
    let again = compare(&arm, &["a", "a"]);
    assert!(
        again.contains("not independent: both are made of train.csv"),
        "{again}"
    );
}
