//! The experiment that a diagnosis asks for, designed, recorded and diagnosed: the rivals come apart.

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

/// Effect of the first finding and its rivals that the recordings cannot set aside.
fn first(folder: &Path) -> (String, Vec<String>) {
    let text = fs::read_to_string(folder.join("result.json")).unwrap();
    let result: Value = serde_json::from_str(&text).unwrap();
    let name = |of: &Value| of["effect"].as_str().unwrap().to_string();
    let finding = &result["findings"][0];
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

/// The truth is named, with a rival; it is not what is named but one of its rivals; and a channel hears another, which a coupling of
/// the two would do nearly as well. Longer recordings of the same motion would tell them too, but none of these is longer.
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
        number: 562,
        of: &["channel_crosstalk"],
        named: "channel_crosstalk",
        rivals: &["kinematic_coupling"],
        truth: "channel_crosstalk",
    },
];

impl Case {
    fn scope(&self) -> Scope {
        let mut scope = Scope::periodic(self.seed);
        scope.effects = self.of.to_vec();
        scope
    }
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
            first(&folder.join("before")),
            (case.named.to_string(), rivals)
        );
        let next = "before/next_experiment.toml";
        exid(folder, &["design", next, "--out", "design"]);
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
            first(&folder.join("after")),
            (case.truth.to_string(), Vec::new())
        );
    }
}
