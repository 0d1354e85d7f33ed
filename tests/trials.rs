//! Diagnosis of recordings by another simulator in which effects are concealed: what was left out, on which
//! joints, and how well the model with it predicts another motion.

mod common;

use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A fit with the true model leaves about 1.1; differentiation leaves the rest.
const LACK_OF_FIT: f64 = 1.8;

/// A share of the misfit that is of weight.
const OF_WEIGHT: f64 = 0.05;

/// Rivals that a finding may list as not separable.
const RIVALS: usize = 2;

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap();
    list.iter().map(|x| x.as_f64().unwrap()).collect()
}

fn joints(value: &Value) -> BTreeSet<String> {
    let list = value["joints"].as_array().unwrap();
    list.iter()
        .map(|j| j.as_str().unwrap().to_string())
        .collect()
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// The declared model: rigid body, known rotors, Coulomb and viscous friction.
fn problem(folder: &Path) -> String {
    let drive = read(&folder.join("drive.json"));
    let file = |name: &str| folder.join(name).display().to_string();
    let period = drive["period"].as_f64();
    let period = period.map_or_else(String::new, |seconds| format!("period = {seconds}\n"));
    format!(
        "name = \"trial\"\n[robot]\nurdf = {:?}\ngravity = {:?}\ninertials = {}\n[drive]\n\
         torque_constant = {:?}\nrotor_inertia = {:?}\n\
         effects = [\"coulomb_friction\", \"viscous_friction\"]\n[recordings]\nsignal = \"current\"\n\
         {period}train = [{:?}]\nvalidation = [{:?}]\n",
        file("robot.urdf"),
        numbers(&drive["gravity"]),
        drive["inertials"],
        numbers(&drive["kt"]),
        numbers(&drive["rotor_inertia"]),
        file("train.csv"),
        file("validation.csv"),
    )
}

fn diagnose(folder: &Path) -> Value {
    let scratch = tempfile::tempdir().unwrap();
    let (toml, out) = (
        scratch.path().join("problem.toml"),
        scratch.path().join("out"),
    );
    fs::write(&toml, problem(folder)).unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_exid"))
        .args(["diagnose", "--quiet", "--out"])
        .args([&out, &toml])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{}: {text}", folder.display());
    read(&out.join("result.json"))
}

/// Whether a finding is the concealed effect, or lists it among the few rivals that it cannot set aside.
fn names(finding: &Value, concealed: &Value) -> bool {
    let same = |named: &Value| {
        named["effect"] == concealed["effect"] && joints(named) == joints(concealed)
    };
    let rivals = finding["rivals"].as_array().unwrap();
    let left: Vec<&Value> = rivals
        .iter()
        .filter(|rival| rival["separable"] == Value::Bool(false))
        .collect();
    same(finding) || (left.len() <= RIVALS && left.iter().any(|rival| same(rival)))
}

/// What is wrong with a diagnosis; nothing if it is right.
fn faults(result: &Value, truth: &Value) -> Vec<String> {
    let findings = result["findings"].as_array().unwrap();
    let concealed = truth["effects"].as_array().unwrap();
    let mut faults = Vec::new();
    for effect in concealed {
        if !findings.iter().any(|finding| names(finding, effect)) {
            faults.push(format!("{} is not found", effect["effect"]));
        }
    }
    for finding in findings {
        let share = finding["explained_share"].as_f64().unwrap();
        if share > OF_WEIGHT && !concealed.iter().any(|effect| names(finding, effect)) {
            faults.push(format!(
                "{} of {:?} is claimed",
                finding["effect"],
                joints(finding)
            ));
        }
    }
    for joint in result["final"]["joints"].as_array().unwrap() {
        let lack = joint["lack_of_fit"].as_f64().unwrap();
        if lack > LACK_OF_FIT {
            faults.push(format!(
                "{} is left with a lack of fit of {lack:.3}",
                joint["joint"]
            ));
        }
    }
    faults
}

/// A number in three significant digits, or a word.
fn short(value: &Value) -> String {
    match (value.as_f64(), value.as_str()) {
        (Some(number), _) => exid::chain::words::short(number),
        (None, Some(word)) => word.to_string(),
        (None, None) => "–".to_string(),
    }
}

/// Numbers, and those of lists and tables, in the order of their names.
fn sizes(name: &str, value: &Value) -> Vec<String> {
    match value {
        Value::Object(table) => table.iter().flat_map(|(name, v)| sizes(name, v)).collect(),
        Value::Array(list) => {
            let values: Vec<String> = list.iter().map(short).collect();
            vec![format!("{name} = ({})", values.join(", "))]
        }
        number => vec![format!("{name} = {}", short(number))],
    }
}

/// An effect and its joints: `joint_spring at joint3`.
fn place(effect: &Value) -> String {
    let joints: Vec<String> = joints(effect).into_iter().collect();
    let name = effect["effect"].as_str().unwrap();
    format!("{name} at {}", joints.join(", "))
}

fn found(finding: &Value) -> String {
    let parameters = finding["parameters"].as_array().unwrap().iter().map(|p| {
        let name = p["name"].as_str().unwrap().rsplit('.').next().unwrap();
        let unit = p["unit"].as_str().filter(|unit| *unit != "1").unwrap_or("");
        format!(
            "{name} = {} ± {} {unit}",
            short(&p["value"]),
            short(&p["std_dev"])
        )
        .trim_end()
        .to_string()
    });
    let parameters: Vec<String> = parameters.collect();
    let rivals = finding["rivals"].as_array().unwrap().iter();
    let rivals: Vec<String> = rivals
        .filter(|rival| rival["separable"] == Value::Bool(false))
        .map(place)
        .collect();
    let apart = match rivals.is_empty() {
        true => String::new(),
        false => format!("; not told apart from {}", rivals.join(", ")),
    };
    format!("{}: {}{apart}", place(finding), parameters.join(", "))
}

/// A row of the table of results: what was concealed, and what was found.
fn row(trial: &str, result: &Value, truth: &Value) -> String {
    let list = |items: &Value, words: &dyn Fn(&Value) -> String| {
        let all: Vec<String> = items.as_array().unwrap().iter().map(words).collect();
        match all.is_empty() {
            true => "nothing".to_string(),
            false => all.join("<br>"),
        }
    };
    let concealed = list(&truth["effects"], &|effect| {
        let sizes = sizes("", &effect["parameters"]).join(", ");
        format!("{}: {sizes}", place(effect))
    });
    let joints = result["final"]["joints"].as_array().unwrap().iter();
    let lack = joints.filter_map(|joint| joint["lack_of_fit"].as_f64());
    let lack = lack.fold(0.0, f64::max);
    let found = list(&result["findings"], &found);
    format!("| {trial} | {concealed} | {found} | {lack:.2} |")
}

/// Trials in a folder of recordings, in order; `None`, and a word of it, where there are no recordings.
fn trials(folder: &str) -> Option<Vec<PathBuf>> {
    let entries = fs::read_dir(common::data_dir()?.join(folder)).unwrap();
    let mut folders: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.join("truth.json").is_file())
        .collect();
    folders.sort();
    assert!(!folders.is_empty());
    Some(folders)
}

/// Prints the table of results, a row of each trial.
#[test]
fn names_what_another_simulator_concealed() {
    let Some(folders) = trials("trials") else {
        return;
    };
    let mut wrong = 0;
    println!("| | concealed | found | largest lack of fit |\n|---|---|---|---|");
    for folder in &folders {
        let result = diagnose(folder);
        let truth = read(&folder.join("truth.json"));
        let faults = faults(&result, &truth);
        let trial = folder.file_name().unwrap().to_string_lossy();
        println!("{}", row(&trial, &result, &truth));
        if !faults.is_empty() {
            eprintln!("{trial}: {faults:?}");
        }
        wrong += usize::from(!faults.is_empty());
    }
    assert_eq!(wrong, 0, "of {} trials", folders.len());
}

/// An effect at each of its joints.
fn pairs(effect: &Value) -> Vec<Value> {
    let of = |joint: String| json!({ "effect": effect["effect"], "joints": [joint], "rivals": effect["rivals"] });
    joints(effect).into_iter().map(of).collect()
}

/// Arms that move from pose to pose and do not repeat, and an arm with five effects at once: every effect is found at each of its joints,
/// nothing else is, and controls stay silent.
#[test]
fn names_what_is_concealed_in_moves_and_in_a_whole_robot() {
    let Some(folders) = trials("trials_whole") else {
        return;
    };
    for folder in &folders {
        let (result, truth) = (diagnose(folder), read(&folder.join("truth.json")));
        let of = |list: &Value| -> Vec<Value> {
            list.as_array().unwrap().iter().flat_map(pairs).collect()
        };
        let (found, concealed) = (of(&result["findings"]), of(&truth["effects"]));
        let trial = folder.file_name().unwrap().to_string_lossy();
        for effect in &concealed {
            let is_found = found.iter().any(|finding| names(finding, effect));
            assert!(is_found, "{trial}: {} is not found", place(effect));
        }
        for finding in &found {
            let is_there = concealed.iter().any(|effect| names(finding, effect));
            assert!(is_there, "{trial}: {} is claimed", place(finding));
        }
    }
}
