//! Names that recordings leave open: the experiment that a diagnosis asks for, designed, recorded and diagnosed, in which the rivals
//! come apart; and those that no recording can tell.

mod common;

use exid::problem::solution::Control;
use exid::trials::files::prepare;
use exid::trials::plan::{Plan, Scope};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Runs the program in a folder; what it says where it fails.
fn exid(folder: &Path, arguments: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder)
        .args(arguments)
        .arg("--quiet")
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {words}");
}

/// The findings of a diagnosis.
fn findings(folder: &Path) -> Vec<Value> {
    let text = fs::read_to_string(folder.join("result.json")).unwrap();
    let result: Value = serde_json::from_str(&text).unwrap();
    result["findings"].as_array().unwrap().clone()
}

/// Effect of a finding and its rivals that the recordings cannot set aside.
fn names(finding: &Value) -> (String, Vec<String>) {
    let name = |of: &Value| of["effect"].as_str().unwrap().to_string();
    let rivals = finding["rivals"].as_array().unwrap().iter();
    let open = rivals.filter(|rival| rival["separable"] == false);
    (name(finding), open.map(name).collect())
}

/// A robot of which recordings leave open which of two effects is there.
struct Case {
    seed: u64,
    number: u64,
    /// Effects of which some are concealed.
    of: &'static [&'static str],
    named: &'static str,
    rivals: &'static [&'static str],
    truth: &'static str,
}

/// The truth is named, with a rival; it is not what is named but one of its rivals; and it is the tilt of the base, which is no law of a
/// joint. Longer recordings of the same motion would tell them too, but none of these is longer.
const CASES: [Case; 3] = [
    Case {
        seed: 4711,
        number: 36,
        of: &["load_dependent_friction"],
        named: "load_dependent_friction",
        rivals: &["transmission_efficiency"],
        truth: "load_dependent_friction",
    },
    Case {
        seed: 32,
        number: 0,
        of: &[
            "joint_spring",
            "torque_ripple",
            "stribeck_friction",
            "presliding_hysteresis",
            "load_dependent_friction",
            "transmission_efficiency",
        ],
        named: "torque_offset",
        rivals: &["joint_spring", "asymmetric_friction"],
        truth: "joint_spring",
    },
    Case {
        seed: 14,
        number: 13,
        of: &["rotor_inertia", "unmodelled_payload", "base_tilt"],
        named: "torque_offset",
        rivals: &["base_tilt", "asymmetric_friction", "joint_spring"],
        truth: "base_tilt",
    },
];

impl Case {
    fn scope(&self) -> Scope {
        let mut scope = Scope::periodic(self.seed);
        scope.effects = self.of.to_vec();
        scope
    }
}

/// The problem of the experiment that a diagnosis asks for.
const NEXT: &str = "before/next_experiment.toml";

/// A channel that hears another, or a load: both are in the problem of the next experiment, whose motion can be designed.
#[test]
fn a_load_is_a_rival_of_the_next_experiment() {
    let mut scope = Scope::periodic(14);
    scope.robots = vec!["arm3"];
    scope.effects = vec![
        "channel_crosstalk",
        "kinematic_coupling",
        "presliding_hysteresis",
    ];
    let kept = tempfile::tempdir().unwrap();
    let folder = kept.path();
    prepare(&Plan::draw(&scope, 56, 0), folder, &Control::default()).unwrap();
    exid(folder, &["diagnose", "problem.toml", "--out", "before"]);
    let rivals = vec!["unmodelled_payload".to_string()];
    let found = names(&findings(&folder.join("before"))[0]);
    assert_eq!(found, ("channel_crosstalk".to_string(), rivals));
    exid(folder, &["design", NEXT, "--out", "design"]);
}

#[test]
fn rivals_come_apart_in_the_recording_of_the_next_experiment() {
    for case in CASES {
        let kept = tempfile::tempdir().unwrap();
        let folder = kept.path();
        let plan = Plan::draw(&case.scope(), case.number, 0);
        prepare(&plan, folder, &Control::default()).unwrap();
        exid(folder, &["diagnose", "problem.toml", "--out", "before"]);
        let rivals = case.rivals.iter().map(ToString::to_string).collect();
        assert_eq!(
            names(&findings(&folder.join("before"))[0]),
            (case.named.to_string(), rivals)
        );
        exid(folder, &["design", NEXT, "--out", "design"]);
        for (motion, name, seed) in [
            ("trajectory", "train", "1"),
            ("validation_trajectory", "validation", "2"),
        ] {
            let motion = format!("simulate.trajectory=\"design/{motion}.csv\"");
            let run = ["simulate", "truth.toml", "--set", &motion, "--seed", seed];
            exid(folder, &[&run[..], &["--out", "recorded"]].concat());
            let to = folder.join(format!("{name}.csv"));
            fs::rename(folder.join("recorded/train.csv"), to).unwrap();
        }
        exid(folder, &["diagnose", "problem.toml", "--out", "after"]);
        assert_eq!(
            names(&findings(&folder.join("after"))[0]),
            (case.truth.to_string(), Vec::new())
        );
    }
}

/// An arm of which nothing is known but its axes, with gears that lose a fifth of what they transmit, or without: `effects` of
/// every drive, and what follows.
fn lossy_arm(effects: &str, rest: &str) -> String {
    format!(
        "name = \"arm\"\n[robot]\nurdf = \"arm.urdf\"\n[drive]\neffects = [\"coulomb_friction\", \"viscous_friction\"{effects}]\n\
         [drive.values]\n\"shoulder.coulomb_friction.w\" = 0.01\n\"elbow.coulomb_friction.w\" = 0.01\n\
         [recordings]\nsignal = \"torque\"\nrate = 200.0\nperiod = 10.0\n{rest}"
    )
}

/// A gear that loses a share of its load both ways is friction that grows with the load beneath links that are heavier: τ/R and τR
/// are m τ ± c |τ|. One joint alone tells them, by links that the others have weighed; where every gear loses, none does.
#[test]
fn where_every_gear_loses_its_load_the_masses_leave_its_name_open() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("arm.urdf"), common::arm::URDF).unwrap();
    let truth = "train = [\"train.csv\"]\n[simulate]\ntrajectory = \"random\"\nperiods = 4\nnoise = 0.02\n[simulate.values]\n\
                 \"shoulder.Fc\" = 1.2\n\"elbow.Fc\" = 0.6\n\"shoulder.Fv\" = 1.1\n\"elbow.Fv\" = 0.5\n\
                 \"shoulder.transmission_efficiency.R\" = 0.8\n\"elbow.transmission_efficiency.R\" = 0.8\n";
    let lossy = lossy_arm(", \"transmission_efficiency\"", truth);
    fs::write(at.join("truth.toml"), lossy).unwrap();
    for seed in ["1", "2"] {
        let simulate = ["simulate", "truth.toml", "--seed", seed, "--out", seed];
        exid(at, &simulate);
    }
    let files = "train = [\"1/train.csv\"]\nvalidation = [\"2/train.csv\"]\n";
    fs::write(at.join("declared.toml"), lossy_arm("", files)).unwrap();
    exid(at, &["diagnose", "declared.toml", "--out", "found"]);
    let findings = findings(&at.join("found"));
    assert_eq!(findings.len(), 2, "{findings:?}");
    for finding in &findings {
        let (name, mut all) = names(finding);
        all.push(name);
        all.sort_unstable();
        assert_eq!(all, ["load_dependent_friction", "transmission_efficiency"]);
        // Either is as probable as the other.
        let probability = finding["probability"].as_f64().unwrap();
        assert!((0.3..0.7).contains(&probability), "{probability}");
    }
}
