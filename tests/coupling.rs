//! A coupling of motors is the same wherever it is stated: as an entry of `drive.coupling`, or as the value of a parameter.

mod common;

use common::arm::{Arm, PERIOD};
use serde_json::Value;
use std::fs;

/// Entry of V of the elbow's row: how far it turns with the motor of the shoulder, rad/rad. The recordings have none, so that
/// how large it is makes a difference.
const ENTRY: f64 = 0.3;

/// What a fit finds with lines more in `[drive]` and `[drive.values]`.
fn fitted(drive: &str, values: &str) -> Value {
    let arm = Arm::new(4);
    arm.edit("problem.toml", "[drive]\n", &format!("[drive]\n{drive}\n"));
    let table = "[drive.values]\n";
    arm.edit("problem.toml", table, &format!("{table}{values}\n"));
    let period = format!("recordings.period={PERIOD:.1}");
    let output = arm.fit("out", &["--set", &period]).output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words}");
    serde_json::from_str(&fs::read_to_string(arm.path("out/result.json")).unwrap()).unwrap()
}

/// Values and standard deviations of parameters by name.
fn friction(result: &Value) -> Vec<(String, [f64; 2])> {
    let all = result["parameters"].as_array().unwrap().iter();
    let of = |p: &Value| {
        let name = p["name"].as_str().unwrap();
        let numbers = ["value", "std_dev"].map(|key| p[key].as_f64());
        let [Some(value), Some(deviation)] = numbers else {
            return None;
        };
        name.contains("_friction.")
            .then(|| (name.to_string(), [value, deviation]))
    };
    all.filter_map(of).collect()
}

#[test]
fn a_coupling_stated_as_a_value_is_that_of_the_matrix() {
    let matrix = fitted(&format!("coupling = [[1.0, 0.0], [{ENTRY}, 1.0]]"), "");
    let effects = "effects_of = { elbow = [\"coulomb_friction\", \"viscous_friction\", \"kinematic_coupling\"] }";
    let entry = format!("\"elbow.kinematic_coupling.shoulder\" = {ENTRY}");
    let value = fitted(effects, &entry);
    let (matrix, value) = (friction(&matrix), friction(&value));
    assert_eq!(matrix.len(), 4, "{matrix:?}");
    for ((name, [expected, deviation]), (other, [found, _])) in matrix.iter().zip(&value) {
        assert_eq!(name, other);
        // The optimum of one function, to where its search stops.
        assert!(
            (found - expected).abs() <= 1e-3 * deviation,
            "{name}: {found} in the place of {expected} ± {deviation}"
        );
    }
}
