//! Every estimator finds the transition speed of Coulomb friction where it is not given: with none in its place friction
//! would be off by many of its standard deviations. `problems/puma562_reaction` was simulated with known friction.

use exid::robot::random::{generator, symmetric};
use serde_json::Value;
use std::fs;
use std::path::Path;
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

/// A single axis.
const SLIDE: &str = "<robot name=\"slide\"><link name=\"base\"/><link name=\"carriage\"/><joint name=\"axis\" type=\"prismatic\"><parent \
                     link=\"base\"/><child link=\"carriage\"/><axis xyz=\"1 0 0\"/><limit lower=\"-1\" upper=\"1\" velocity=\"9\" \
                     effort=\"900\"/></joint></robot>";

const SLIDE_PROBLEM: &str = "name = \"slide\"\n[robot]\nurdf = \"slide.urdf\"\n[drive]\neffects = [\"coulomb_friction\", \
                             \"viscous_friction\"]\n[recordings]\ntrain = [\"run.csv\"]\nsignal = \"torque\"\n";

/// A slide of 5 kg with Fc = 2 N, w = 0.02 m/s and Fv = 3 N·s/m that creeps at 0.04 m/s at most, where two thirds of Fc are seen.
fn creeping(folder: &Path, seed: u64) {
    let mut rng = generator(seed);
    let mut lines = vec!["t,q1,tau1".to_owned()];
    let rates = [
        1.0 + symmetric(&mut rng, 0.3),
        2.3 + symmetric(&mut rng, 0.5),
    ];
    for k in 0..6000 {
        let t = 0.005 * f64::from(k);
        let [mut q, mut v, mut a] = [0.0; 3];
        for rate in rates {
            let (sin, cos) = (rate * t).sin_cos();
            q += 0.02 * sin / rate;
            v += 0.02 * cos;
            a -= 0.02 * rate * sin;
        }
        // Noise of 0.4 N, of an even distribution.
        let noise = symmetric(&mut rng, 0.4 * 3.0_f64.sqrt());
        let force = 5.0 * a + 2.0 * v / (v.abs() + 0.02) + 3.0 * v + noise;
        lines.push(format!("{t},{},{force}", (q * 1e6).round() / 1e6));
    }
    fs::write(folder.join("run.csv"), lines.join("\n")).unwrap();
    fs::write(folder.join("slide.urdf"), SLIDE).unwrap();
    fs::write(folder.join("problem.toml"), SLIDE_PROBLEM).unwrap();
}

/// A motion that is too slow to tell dry from viscous friction gives intervals that hold both.
#[test]
fn intervals_hold_what_a_slow_motion_does_not_show() {
    let mut unshown = 0;
    for seed in 0..6 {
        let folder = tempfile::tempdir().unwrap();
        creeping(folder.path(), seed);
        let output = Command::new(env!("CARGO_BIN_EXE_exid"))
            .current_dir(folder.path())
            .args(["fit", "problem.toml", "--json"])
            .output()
            .unwrap();
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{words}");
        let result: Value = serde_json::from_slice(&output.stdout).unwrap();
        for (name, truth) in [
            ("axis.coulomb_friction.Fc", 2.0),
            ("axis.viscous_friction.Fv", 3.0),
        ] {
            let found = parameter(&result, name);
            if let (Some(value), Some(std_dev)) =
                (found["value"].as_f64(), found["std_dev"].as_f64())
            {
                let off = (value - truth) / std_dev;
                assert!(off.abs() <= WITHIN, "{seed}, {name}: {off:.1} σ");
            }
        }
        let notes = result["notes"].as_array().unwrap().iter();
        let mut notes = notes.filter_map(Value::as_str);
        unshown +=
            u32::from(notes.any(|note| note.contains("axis is too slow to tell dry from viscous")));
    }
    assert!(unshown > 0);
}
