//! Laws of problem files, as a user has them: the shipped ones, versions of the vocabulary's own effects, faults.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/own_versions.rs"]
mod own_versions;

mod formulas;
mod values;

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A folder with a robot of two joints, whose bodies are known.
struct Folder(TempDir);

/// Motion, noise and truth of what is not concealed.
const SIMULATE: &str = r#"
[simulate]
trajectory = "random"
mode = "inverse"
periods = 3
noise = [0.02, 0.02]
encoder_counts = 524288

[simulate.values]
"shoulder.Fc" = 3.0
"shoulder.Fv" = 2.0
"elbow.Fc" = 1.2
"elbow.Fv" = 0.8
"#;

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        fs::write(folder.path("arm.urdf"), common::arm::URDF).unwrap();
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A problem file: lines in front of its tables, effects of the elbow beside friction, laws, values of the truth.
    fn write(&self, name: &str, problem: &Problem<'_>) {
        let mut effects = vec!["coulomb_friction", "viscous_friction"];
        effects.retain(|id| Some(*id) != problem.instead);
        effects.extend(problem.effects);
        let text = format!(
            "name = \"arm\"\n{}\n[robot]\nurdf = \"arm.urdf\"\ninertials = \"known\"\n[drive]\ntorque_constant = [12.0, 8.0]\n\
             effects = [\"coulomb_friction\", \"viscous_friction\"]\n[drive.effects_of]\nelbow = {effects:?}\n\
             [recordings]\ntrain = [\"train.csv\"]\nvalidation = [\"validation.csv\"]\nsignal = \"current\"\nrate = 200.0\n\
             period = 4.0\n[design]\nperiod = 4.0\n{}{SIMULATE}{}\n",
            problem.top, problem.laws, problem.values
        );
        fs::write(self.path(name), text).unwrap();
    }

    fn exid(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_exid"))
            .current_dir(self.0.path())
            .args(arguments)
            .output()
            .unwrap()
    }

    /// What a verb prints as JSON.
    fn json(&self, arguments: &[&str]) -> Value {
        let output = self.exid(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {said}");
        serde_json::from_slice(&output.stdout).unwrap()
    }

    /// Makes `train.csv` and `validation.csv`.
    fn simulate(&self, problem: &str, seed: &str) {
        self.json(&[
            "simulate", problem, "--seed", seed, "--out", "made", "--json",
        ]);
        for file in ["train.csv", "validation.csv"] {
            fs::copy(self.path("made").join(file), self.path(file)).unwrap();
        }
    }
}

#[derive(Default)]
struct Problem<'a> {
    top: &'a str,
    /// An effect of the elbow that another one takes the place of.
    instead: Option<&'a str>,
    effects: &'a [&'a str],
    laws: &'a str,
    values: &'a str,
}

fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("laws")
}

/// The line of a problem file that names the shipped laws.
fn all_shipped() -> String {
    format!("laws = [{:?}]", shipped().display().to_string())
}

fn parameter(result: &Value, name: &str) -> [f64; 2] {
    let parameters = result["parameters"].as_array().unwrap();
    let found = parameters.iter().find(|p| p["name"] == name);
    let found = found.unwrap_or_else(|| panic!("no {name} in {parameters:?}"));
    let number = |key: &str| found[key].as_f64().unwrap_or(f64::NAN);
    [number("value"), number("std_dev")]
}

#[test]
fn shipped_laws_are_complete() {
    let folder = Folder::new();
    let laws = shipped().display().to_string();
    let all = folder.json(&["effects", "--laws", &laws, "--json"]);
    let known = folder.json(&["effects", "--json"]);
    let (all, known) = (all.as_array().unwrap(), known.as_array().unwrap());
    let own: Vec<&Value> = all.iter().filter(|law| !known.contains(law)).collect();
    assert!(own.len() >= 10, "{}", own.len());
    for law in own {
        assert_ne!(law["source"], "stated in the problem file", "{law}");
        for parameter in law["parameters"].as_array().unwrap() {
            assert!(!parameter["meaning"].as_str().unwrap().is_empty(), "{law}");
            assert!(!parameter["unit"].as_str().unwrap().is_empty(), "{law}");
        }
    }
}

/// Values of a law's parameters by name.
type Values = &'static [(&'static str, f64)];

/// Shipped laws with a truth for the elbow, whose positions reach a third of a rad to either side, and what it stands in the place of.
const TRUTHS: &[(&str, Option<&str>, Values)] = &[
    (
        "dahl_friction",
        Some("coulomb_friction"),
        &[("sigma", 30.0), ("Fc", 1.5)],
    ),
    (
        "elasto_plastic_friction",
        Some("coulomb_friction"),
        &[("sigma", 30.0), ("Fc", 1.5), ("share", 0.5)],
    ),
    (
        "maxwell_slip",
        None,
        &[
            ("k1", 100.0),
            ("k2", 20.0),
            ("k3", 5.0),
            ("d1", 0.01),
            ("d2", 0.05),
            ("d3", 0.2),
        ],
    ),
    (
        "stribeck_tanh",
        Some("coulomb_friction"),
        &[
            ("F1", 1.0),
            ("b1", 20.0),
            ("b2", 4.0),
            ("F2", 2.5),
            ("b3", 50.0),
        ],
    ),
    (
        "meshing_ripple",
        None,
        &[("a", 0.08), ("b", -0.05), ("n", 9.0)],
    ),
    (
        "cable_spring",
        None,
        &[("k", 30.0), ("left", -0.1), ("right", 0.15)],
    ),
    (
        "slider_behind_spring",
        None,
        &[("k", 20.0), ("k3", 5000.0), ("up", 0.04), ("down", 0.05)],
    ),
    ("magnetic_saturation", None, &[("b", 0.3), ("c", 0.02)]),
    (
        "hose_windup",
        None,
        &[("k", 2.0), ("k3", 20.0), ("q0", 0.1)],
    ),
    ("brake_drag", None, &[("Fa", 0.4), ("Fb", 0.2), ("n", 6.0)]),
    (
        "end_stop_above",
        None,
        &[("k", 100.0), ("d", 30.0), ("stop", 0.15)],
    ),
    (
        "end_stop_below",
        None,
        &[("k", 100.0), ("d", 30.0), ("stop", -0.15)],
    ),
    (
        "one_sided_spring_above",
        None,
        &[("k", 10.0), ("touch", 0.1)],
    ),
    (
        "one_sided_spring_below",
        None,
        &[("k", 10.0), ("touch", -0.1)],
    ),
    (
        "amplifier_dead_zone",
        None,
        &[("threshold", 0.8), ("width", 0.1)],
    ),
];

#[test]
fn recovers_known_truth_of_shipped_laws() {
    let top = all_shipped();
    for (id, instead, truth) in TRUTHS {
        let folder = Folder::new();
        let values: String = truth
            .iter()
            .map(|(name, value)| format!("\"elbow.{id}.{name}\" = {value:?}\n"))
            .collect();
        // What a law stands in the place of is none in the truth.
        let none = instead.map_or(String::new(), |_| "\"elbow.Fc\" = 0.0\n".into());
        let whole = format!("{values}{none}");
        let simulated = Problem {
            top: &top,
            values: &whole,
            ..Problem::default()
        };
        folder.write("truth.toml", &simulated);
        let text = fs::read_to_string(folder.path("truth.toml")).unwrap();
        if instead.is_some() {
            fs::write(
                folder.path("truth.toml"),
                text.replacen("\"elbow.Fc\" = 1.2\n", "", 1),
            )
            .unwrap();
        }
        folder.simulate("truth.toml", "3");
        let problem = Problem {
            top: &top,
            instead: *instead,
            effects: &[id],
            ..Problem::default()
        };
        folder.write("problem.toml", &problem);
        let result = folder.json(&["fit", "problem.toml", "--json", "--out", "fit"]);
        for (name, value) in *truth {
            let [found, std_dev] = parameter(&result, &format!("elbow.{id}.{name}"));
            // Four deviations for some forty numbers, and what differentiation of positions with encoder counts leaves: 1 %.
            let error = (found - value).abs();
            assert!(
                error <= 4.0 * std_dev + 0.01 * value.abs(),
                "{id}.{name}: {found} ± {std_dev} for {value}"
            );
        }
    }
}

#[test]
fn own_versions_of_effects_give_the_same_fits() {
    let laws = fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("laws/vocabulary/own_versions.toml"),
    )
    .unwrap();
    let mut worst: Vec<(f64, String)> = Vec::new();
    for (id, truth) in own_versions::TRUTHS {
        let folder = Folder::new();
        let values: String = truth
            .iter()
            .map(|(name, value)| format!("\"elbow.{id}.{name}\" = {value:?}\n"))
            .collect();
        let own = format!("own_{id}");
        let is_declared = truth.is_empty();
        let of = |effect: &'static str| Problem {
            instead: is_declared.then_some(effect),
            ..Problem::default()
        };
        let base = of(id);
        folder.write(
            "truth.toml",
            &Problem {
                values: &values,
                ..Problem::default()
            },
        );
        folder.simulate("truth.toml", "5");
        folder.write(
            "ours.toml",
            &Problem {
                effects: &[id],
                ..of(id)
            },
        );
        folder.write(
            "own.toml",
            &Problem {
                effects: &[&own],
                laws: &laws,
                ..base
            },
        );
        let ours = folder.json(&["fit", "ours.toml", "--json", "--out", "ours"]);
        let theirs = folder.json(&["fit", "own.toml", "--json", "--out", "own"]);
        for entry in ours["parameters"].as_array().unwrap() {
            let name = entry["name"].as_str().unwrap();
            let Some(value) = entry["value"].as_f64() else {
                continue;
            };
            let other = name.replace(&format!("elbow.{id}."), &format!("elbow.{own}."));
            let [found, std_dev] = parameter(&theirs, &other);
            let found = as_stated(&theirs, &other, found);
            let scale = value
                .abs()
                .max(if std_dev.is_finite() { std_dev } else { 0.0 });
            if scale > 0.0 {
                worst.push(((found - value).abs() / scale, format!("{id}: {name}")));
            }
        }
    }
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    println!("largest differences: {:?}", &worst[..8]);
    assert!(worst[0].0 <= 1e-9, "{:?}", &worst[..20]);
}

/// A value of an own law as the vocabulary states it: of two ways to write a sine, that whose amplitude is positive.
fn as_stated(result: &Value, name: &str, value: f64) -> f64 {
    let amplitude = name.replace(".phase", ".amplitude");
    let is_sine = [".amplitude", ".amplitude2"]
        .iter()
        .any(|end| amplitude.ends_with(end));
    if !is_sine || parameter(result, &amplitude)[0] >= 0.0 {
        return value;
    }
    let turned = value + std::f64::consts::PI;
    match name == amplitude {
        true => -value,
        false => turned - std::f64::consts::TAU * (turned / std::f64::consts::TAU).round(),
    }
}

#[test]
fn faults_of_laws_name_file_line_and_remedy() {
    let folder = Folder::new();
    let law = |torque: &str, parameter: &str| {
        format!(
            "\n[[law]]\nid = \"own\"\nsentence = \"Own.\"\ntorque = \"{torque}\"\nparameters.a = {parameter}\n"
        )
    };
    let cases = [
        (
            law("a*sinn(q)", "{ typical = 1.0 }"),
            "law.torque",
            "did you mean \"sin\"",
        ),
        (
            law("a*(q", "{ typical = 1.0 }"),
            "character 3",
            "add the bracket",
        ),
        (
            law("a*v", "{ typical = 1.0, unit = \"N·m\" }"),
            "law.torque",
            "correct the formula or the units",
        ),
        (
            law("a*q", "{ typical = 1.0, lower = 2.0 }"),
            "parameters.a",
            "between its bounds",
        ),
        (
            law("a*q", "{ }"),
            "parameters.a.typical",
            "size at which it matters",
        ),
        (
            law("a*q", "{ typical = 1.0 }").replace("\"own\"", "\"backlash\""),
            "law.id",
            "another id",
        ),
        (
            law("a*q*q[wrist]", "{ typical = 1.0 }"),
            "wrist",
            "moving joint",
        ),
    ];
    for (text, place, remedy) in cases {
        let problem = Problem {
            effects: if text.contains("\"own\"") {
                &["own"]
            } else {
                &[]
            },
            laws: &text,
            ..Problem::default()
        };
        folder.write("problem.toml", &problem);
        let output = folder.exid(&["fit", "problem.toml"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("problem.toml"), "{said}");
        assert!(
            said.contains(place) && said.contains(remedy),
            "{text}: {said}"
        );
    }
}

#[test]
fn a_law_of_a_file_is_searched_for_explained_and_exported() {
    let folder = Folder::new();
    fs::create_dir(folder.path("catalogue")).unwrap();
    let law = "[[law]]\nid = \"cogging_by_load\"\nsentence = \"Teeth mesh harder under load.\"\nsource = \"a test\"\n\
               acts_on = \"motor\"\ntorque = \"a*tau*sin(n*q + phi)\"\n\
               parameters.a = { unit = \"1\", lower = 0.0, upper = 1.0, typical = 0.1 }\n\
               parameters.n = { typical = 8.0, search = [4.0, 8.0, 16.0] }\n\
               parameters.phi = { unit = \"rad\", typical = 0.0, search = [0.0, 1.5, 3.0, -1.5] }\n";
    fs::write(folder.path("catalogue/cogging.toml"), law).unwrap();
    let values = "\"elbow.cogging_by_load.a\" = 0.25\n\"elbow.cogging_by_load.n\" = 8.0\n\
                  \"elbow.cogging_by_load.phi\" = 0.5\n";
    let problem = Problem {
        top: "laws = [\"catalogue\"]",
        values,
        ..Problem::default()
    };
    folder.write("problem.toml", &problem);
    folder.simulate("problem.toml", "7");
    let result = folder.json(&["diagnose", "problem.toml", "--json", "--out", "found"]);
    let first = &result["findings"][0];
    assert_eq!(first["effect"], "cogging_by_load", "{}", result["summary"]);
    assert_eq!(first["joints"], serde_json::json!(["elbow"]));
    assert_eq!(result["findings"].as_array().unwrap().len(), 1);
    assert_eq!(result["verdict"], "explained");
    // The result keeps the law, and needs the catalogue no more.
    fs::remove_dir_all(folder.path("catalogue")).unwrap();
    for format in ["rust", "c", "numpy", "mujoco", "toml"] {
        let output = folder.exid(&["export", "found", "--to", format, "--out", format]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{format}: {said}");
    }
    let model = fs::read_to_string(folder.path("mujoco/model.xml")).unwrap();
    for parameter in ["a", "n", "phi"] {
        let key = format!("<config key=\"elbow.cogging_by_load.{parameter}\" value=");
        assert!(model.contains(&key), "{model}");
    }
    let source = fs::read_to_string(folder.path("rust/arm.rs")).unwrap();
    assert!(source.contains("f64::sin("), "{source}");
    let report = fs::read_to_string(folder.path("found/report.html")).unwrap();
    assert!(report.contains("cogging_by_load"));
}

#[test]
fn a_cushion_at_the_end_of_the_range_is_no_ripple() {
    let folder = Folder::new();
    let top = all_shipped();
    let values = "\"elbow.one_sided_spring_above.k\" = 10.0\n\"elbow.one_sided_spring_above.touch\" = 0.15\n";
    folder.write(
        "truth.toml",
        &Problem {
            top: &top,
            values,
            ..Problem::default()
        },
    );
    folder.simulate("truth.toml", "9");
    // Without the law no shape at a limit of its search is named.
    folder.write("problem.toml", &Problem::default());
    let without = folder.json(&["diagnose", "problem.toml", "--json", "--out", "without"]);
    for finding in without["findings"].as_array().unwrap() {
        assert_ne!(finding["effect"], "torque_ripple", "{}", without["summary"]);
    }
    folder.write(
        "problem.toml",
        &Problem {
            top: &top,
            ..Problem::default()
        },
    );
    let with = folder.json(&["diagnose", "problem.toml", "--json", "--out", "with"]);
    assert_eq!(
        with["findings"][0]["effect"], "one_sided_spring_above",
        "{}",
        with["summary"]
    );
}
