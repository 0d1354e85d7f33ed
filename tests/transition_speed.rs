//! Every estimator finds the transition speed of Coulomb friction where it is not given: with none in its place friction
//! would be off by many of its standard deviations. `problems/puma562_reaction` was simulated with known friction.

use serde_json::Value;
use std::process::Command;

/// Friction of the simulation, N·m and N·m·s/rad; gains of the drives scale what their torques show.
const TRUTH: [(&str, f64); 6] = [
    ("joint1.coulomb_friction.Fc", 1.5),
    ("joint1.viscous_friction.Fv", 1.0),
    ("joint2.coulomb_friction.Fc", 5.6),
    ("joint2.viscous_friction.Fv", 3.7),
    ("joint3.coulomb_friction.Fc", 1.4),
    ("joint3.viscous_friction.Fv", 0.85),
];

/// Transition speed of the simulation, rad/s.
const SPEED: f64 = 0.004;

/// Six friction parameters within this many standard deviations: one in two thousand fits misses by chance.
const WITHIN: f64 = 4.0;

/// What a fit of both signals finds by an estimator.
fn fitted(estimator: &str) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let problem = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/problems/puma562_reaction/problem.toml"
    );
    let sets = [
        "recordings.signal=both".to_string(),
        "drive.effects=[\"coulomb_friction\", \"viscous_friction\", \"drive_gain\"]".to_string(),
        format!("fit.estimator={estimator}"),
    ];
    let output = Command::new(env!("CARGO_BIN_EXE_exid"))
        .args(["fit", problem, "--json", "--out"])
        .arg(folder.path().join("out"))
        .args(sets.iter().flat_map(|set| ["--set", set.as_str()]))
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{estimator}: {words}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn parameter<'a>(result: &'a Value, name: &str) -> &'a Value {
    let all = result["parameters"].as_array().unwrap();
    all.iter().find(|p| p["name"] == name).unwrap()
}

#[test]
fn recovers_known_friction_whatever_the_estimator() {
    for estimator in ["ols", "wls", "irls", "feasible"] {
        let result = fitted(estimator);
        for (name, truth) in TRUTH {
            let found = parameter(&result, name);
            let number = |key: &str| found[key].as_f64().unwrap();
            let off = (number("value") - truth) / number("std_dev");
            assert!(off.abs() <= WITHIN, "{estimator}, {name}: {off:.1} σ");
        }
        for joint in 1..=3 {
            let speed = parameter(&result, &format!("joint{joint}.coulomb_friction.w"));
            assert_eq!(speed["source"], "data", "{estimator}");
            let interval = speed["ci95"].as_array().unwrap();
            let [low, high] = [0, 1].map(|k| interval[k].as_f64().unwrap());
            // Four standard deviations: an interval of 95 % is half as wide.
            let room = high - low;
            assert!(
                low - room / 2.0 <= SPEED && SPEED <= high + room / 2.0,
                "{estimator}: {low} to {high}"
            );
        }
    }
}
