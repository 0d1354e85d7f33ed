//! `exid repeat` from outside: the same run gives the same, and what does not is said by name.

mod common;

use common::arm::Arm;
use common::program::says;
use serde_json::Value;
use std::fs;

fn result(arm: &Arm) -> Value {
    serde_json::from_str(&fs::read_to_string(arm.path("out/result.json")).unwrap()).unwrap()
}

/// A fit with an override that stands in no file.
fn fitted() -> Arm {
    let arm = Arm::new(6);
    let infinite =
        "design.workspace.box=[{ frame = \"fore\", lower = [-1, -1, -1], upper = [1, 1, inf] }]";
    let further = [
        "--set",
        "fit.estimator=ols",
        "--set",
        infinite,
        "--threads",
        "1",
    ];
    assert!(arm.fit("out", &further).status().unwrap().success());
    arm
}

#[test]
fn a_result_tells_where_it_comes_from() {
    let arm = fitted();
    let provenance = &result(&arm)["provenance"];
    let command: Vec<&str> = provenance["command"]
        .as_array()
        .unwrap()
        .iter()
        .map(|word| word.as_str().unwrap())
        .collect();
    assert_eq!(command[..3], ["fit", "problem.toml", "--quiet"]);
    assert!(command.contains(&"fit.estimator=ols"));
    assert_eq!(provenance["threads"], 1);
    let texts = ["directory", "date", "revision", "processor"];
    assert!(
        texts
            .iter()
            .all(|key| provenance[key].as_str().is_some_and(|t| !t.is_empty()))
    );
    assert_eq!(
        provenance["date"].as_str().unwrap().len(),
        "2026-01-31T12:00:00Z".len()
    );
    let page = fs::read_to_string(arm.path("out/report.html")).unwrap();
    assert!(
        page.contains("--set fit.estimator=ols"),
        "the command in the report"
    );
}

#[test]
fn invariant_the_same_answer_from_any_folder_with_any_threads() {
    let arm = fitted();
    let here = says(arm.folder(), &["repeat", "out", "--threads", "2"], 0);
    assert!(here.contains("the same, to the bit"), "{here}");
    let elsewhere = tempfile::tempdir().unwrap();
    let out = arm.path("out").display().to_string();
    let there = says(
        elsewhere.path(),
        &["repeat", &out, "--out", "again", "--json"],
        0,
    );
    let compared: Value = serde_json::from_str(&there).unwrap();
    assert_eq!(compared["same"], true);
    let again = fs::read_to_string(elsewhere.path().join("again/result.json")).unwrap();
    let again: Value = serde_json::from_str(&again).unwrap();
    assert_eq!(again["parameters"], result(&arm)["parameters"]);
    assert_eq!(again["provenance"]["command"][0], "repeat");
}

/// The problem is the one that the result keeps, whatever has become of its file.
#[test]
fn a_problem_file_that_changed_is_said_and_not_used() {
    let arm = fitted();
    arm.edit("problem.toml", "\"wls\"", "\"irls\"");
    let said = says(arm.folder(), &["repeat", "out"], 0);
    assert!(
        said.contains("note: problem.toml is not what it was"),
        "{said}"
    );
    fs::remove_file(arm.path("problem.toml")).unwrap();
    says(arm.folder(), &["repeat", "out"], 0);
}

#[test]
fn inputs_that_changed_are_named() {
    let arm = fitted();
    arm.edit("train.csv", "t,q1", "t,q1 ");
    let said = says(arm.folder(), &["repeat", "out"], 3);
    assert!(said.contains("train.csv: the file has changed"), "{said}");
    assert!(said.contains("restore them"), "{said}");
    fs::remove_file(arm.path("arm.urdf")).unwrap();
    let said = says(arm.folder(), &["repeat", "out"], 3);
    assert!(
        said.contains("arm.urdf: ") && said.contains("train.csv"),
        "{said}"
    );
}

#[test]
fn another_answer_names_its_figures() {
    let arm = fitted();
    let known = result(&arm)["parameters"]
        .as_array()
        .unwrap()
        .iter()
        .find_map(|p| (p["source"] == "data").then(|| (p["name"].clone(), p["value"].clone())));
    let (name, value) = known.unwrap();
    arm.edit(
        "out/result.json",
        &format!("\"value\": {value}"),
        "\"value\": 123.25",
    );
    let table = fs::read_to_string(arm.path("out/predictions.csv")).unwrap();
    arm.write("out/predictions.csv", table + "\n");
    let said = says(arm.folder(), &["repeat", "out"], 1);
    let line = format!(
        "parameters[{}].value: 123.25 before, {value} now",
        name.as_str().unwrap()
    );
    assert!(said.contains(&line), "{said}");
    assert!(said.contains("predictions.csv: other contents"), "{said}");
    assert!(said.contains("another answer"), "{said}");
}

#[test]
fn every_verb_repeats() {
    let arm = Arm::new(4);
    let design = [
        "--set",
        "design.starts=1",
        "--set",
        "design.harmonics=2",
        "--set",
        "design.samples=40",
    ];
    let simulate = [
        "--set",
        "drive.effects=[]",
        "--set",
        "drive.values={}",
        "--set",
        "recordings.rate=100",
        "--set",
        "simulate.noise=0.1",
        "--set",
        "simulate.periods=2",
    ];
    for (verb, further) in [
        ("check", &[][..]),
        ("simulate", &simulate),
        ("design", &design),
        (
            "diagnose",
            &["--set", "diagnose.effects=[\"torque_offset\"]"],
        ),
    ] {
        let run = [
            &[verb, "problem.toml", "--seed", "3", "--out", "out"],
            further,
        ]
        .concat();
        says(arm.folder(), &run, 0);
        let said = says(arm.folder(), &["repeat", "out"], 0);
        assert!(said.contains("the same, to the bit"), "{verb}: {said}");
    }
}
