//! `exid rollout` from outside: models simulated forward beside recordings that were not fitted.

mod common;

use common::arm::URDF;
use common::program::says;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// An arm whose shoulder loses 30 % of what it transmits; the declared model does not know it.
const PROBLEM: &str = r#"name = "arm"

[robot]
urdf = "arm.urdf"
INERTIALS

[drive]
torque_constant = [12.0, 8.0]
rotor_inertia = [0.3, 0.1]
effects = ["coulomb_friction", "viscous_friction"]
TRUTH

[recordings]
train = ["train.csv"]
validation = ["validation.csv"]
rate = 200.0
period = 5.0

[simulate]
trajectory = "random"
periods = 4
noise = [0.01, 0.01]
encoder_counts = 524288

[simulate.values]
"shoulder.Fc" = 3.0
"shoulder.Fv" = 2.0
"elbow.Fc" = 1.2
"elbow.Fv" = 0.8
"shoulder.transmission_efficiency.R" = 0.7

[diagnose]
effects = ["transmission_efficiency"]
"#;

/// The truth as a declaration.
const TRUTH: &str = r#"[drive.effects_of]
shoulder = ["coulomb_friction", "viscous_friction", "transmission_efficiency"]
[drive.values]
"shoulder.coulomb_friction.Fc" = 3.0
"shoulder.coulomb_friction.w" = 0.004
"shoulder.viscous_friction.Fv" = 2.0
"shoulder.transmission_efficiency.R" = 0.7
"elbow.coulomb_friction.Fc" = 1.2
"elbow.coulomb_friction.w" = 0.004
"elbow.viscous_friction.Fv" = 0.8"#;

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// The arm with its recordings.
fn arm() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("arm.urdf"), URDF).unwrap();
    let problem = |inertials: &str, truth: &str| {
        PROBLEM
            .replace("INERTIALS", inertials)
            .replace("TRUTH", truth)
    };
    fs::write(
        at.join("problem.toml"),
        problem("inertials = \"known\"", ""),
    )
    .unwrap();
    fs::write(at.join("true.toml"), problem("", TRUTH)).unwrap();
    says(
        at,
        &[
            "simulate",
            "problem.toml",
            "--seed",
            "1",
            "--quiet",
            "--out",
            "made",
        ],
        0,
    );
    for name in ["train.csv", "validation.csv"] {
        fs::copy(at.join("made").join(name), at.join(name)).unwrap();
    }
    folder
}

/// A figure of a joint at half a second.
fn figure(result: &Value, joint: usize, pointer: &str) -> f64 {
    let horizons = result["horizons"].as_array().unwrap();
    let half = horizons.iter().find(|h| h["horizon"] == 0.5).unwrap();
    half["joints"][joint]
        .pointer(pointer)
        .unwrap()
        .as_f64()
        .unwrap()
}

#[test]
fn recovers_what_the_true_model_reaches_after_a_diagnosis() {
    let folder = arm();
    let at = folder.path();
    says(
        at,
        &["diagnose", "problem.toml", "--quiet", "--out", "found"],
        0,
    );
    let shown = says(at, &["rollout", "found", "--out", "rolled"], 0);
    println!("{shown}");
    let found = json(&at.join("rolled/result.json"));
    assert_eq!(
        (&found["verb"], &found["source_verb"]),
        (&"rollout".into(), &"diagnose".into())
    );
    assert_eq!(found["before"], "declared_fitted");
    assert_eq!(found["held_out"], "validation");
    // The diagnosis rolls out over the recordings that it has read, to the same figures.
    let diagnosis = json(&at.join("found/result.json"));
    for part in ["horizons", "curves", "recordings", "summary", "notes"] {
        assert_eq!(diagnosis["rollout"][part], found[part], "{part}");
    }
    says(at, &["fit", "true.toml", "--quiet", "--out", "fitted"], 0);
    says(at, &["rollout", "fitted", "--quiet", "--out", "truth"], 0);
    let truth = json(&at.join("truth/result.json"));
    assert_eq!(truth["before"], "declared_values");
    let [before, after] = ["/before/median", "/after/median"].map(|p| figure(&found, 0, p));
    let reached = figure(&truth, 0, "/before/median");
    println!("before {before:.2e}, after {after:.2e}, true model {reached:.2e}");
    assert!(after < 0.5 * before, "after {after} of {before}");
    assert!(
        after < 1.3 * reached.max(figure(&found, 0, "/noise/median")),
        "{after} of {reached}"
    );
    for joint in [0, 1] {
        let halved = figure(&found, joint, "/integration");
        assert!(
            halved < 0.1 * figure(&found, joint, "/after/rms"),
            "halving changes {halved}"
        );
        assert!(figure(&found, joint, "/noise/windows") >= 30.0);
    }
    let table = fs::read_to_string(at.join("rolled/rollouts.csv")).unwrap();
    assert!(table.starts_with(
        "recording,window,t,shoulder_recorded,shoulder_before,shoulder_after,elbow_recorded"
    ));
    let page = fs::read_to_string(at.join("rolled/report.html")).unwrap();
    assert!(
        page.contains("Error of position over the horizon") && page.contains("The worst window")
    );
    let again = says(at, &["repeat", "rolled", "--threads", "1"], 0);
    assert!(again.contains("the same, to the bit"), "{again}");
}

#[test]
fn says_what_is_in_the_way() {
    let folder = arm();
    let at = folder.path();
    let none = says(at, &["rollout", "made"], 2);
    assert!(none.contains("`simulate` holds no robot"), "{none}");
    says(
        at,
        &["fit", "problem.toml", "--quiet", "--out", "fitted"],
        0,
    );
    let whole = fs::read_to_string(at.join("fitted/result.json")).unwrap();
    let mut old: Value = serde_json::from_str(&whole).unwrap();
    old.as_object_mut().unwrap().remove("model");
    fs::create_dir(at.join("old")).unwrap();
    fs::write(at.join("old/result.json"), old.to_string()).unwrap();
    let incomplete = says(at, &["rollout", "old"], 2);
    assert!(
        incomplete.contains("make it again: exid fit"),
        "{incomplete}"
    );
    let key = says(at, &["rollout", "fitted", "--set", "recordings.rat=100"], 2);
    assert!(key.contains("rate"), "{key}");
    let text = fs::read_to_string(at.join("validation.csv")).unwrap();
    fs::write(at.join("validation.csv"), text.replacen("0.", "0.1", 1)).unwrap();
    let changed = says(at, &["rollout", "fitted"], 3);
    assert!(
        changed.contains("SHA-256") && changed.contains("validation.csv"),
        "{changed}"
    );
    fs::remove_file(at.join("validation.csv")).unwrap();
    let gone = says(at, &["rollout", "fitted"], 3);
    assert!(gone.contains("validation.csv"), "{gone}");
    assert!(!at.join("results").exists());
}
