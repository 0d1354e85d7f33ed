//! `exid trials` from outside: what it writes, that it goes on where it was, and what it refuses.

use exid::problem::solution::Control;
use exid::trials::plan::Scope;
use exid::trials::run;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn trials(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder)
        .arg("trials")
        .args(arguments)
        .output()
        .unwrap()
}

fn small(folder: &Path, count: &str) -> Value {
    let few = [
        "--effects",
        "torque_offset,joint_spring",
        "--robots",
        "arm3",
    ];
    let rest = ["--count", count, "--seed", "2", "--out", "out", "--json"];
    let output = trials(folder, &[&few[..], &rest[..]].concat());
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Every fifth trial conceals nothing; what a longer run had done already is kept, to the second.
#[test]
fn a_longer_run_goes_on_where_a_shorter_one_ended() {
    let folder = tempfile::tempdir().unwrap();
    let first = small(folder.path(), "2");
    let second = small(folder.path(), "5");
    let all = second["trials"].as_array().unwrap();
    assert_eq!(all.len(), 5);
    assert_eq!(first["trials"].as_array().unwrap()[..], all[..2]);
    for (k, trial) in all.iter().enumerate() {
        assert_eq!(trial["seed"], k);
        assert_eq!(trial["robot"], "arm3");
        assert_eq!(trial["failure"], Value::Null);
        let concealed = trial["concealed"].as_array().unwrap();
        assert_eq!(concealed.is_empty(), k == 4);
        for effect in concealed {
            assert!(effect["effect_over_noise"].as_f64().unwrap() >= 0.0);
        }
    }
    assert_eq!(second["false_findings"]["controls"], 1);
    assert!(second["false_findings"]["upper95"].as_f64().unwrap() <= 1.0);
    assert!(second["rates"]["core_seconds"].as_f64().unwrap() > 0.0);
    assert!(second["confusion"].is_object() && second["power"].is_array());
    assert!(folder.path().join("out/report.html").is_file());
}

#[test]
fn an_effect_or_a_robot_that_does_not_exist_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (flag, wrong) in [("--effects", "gremlins"), ("--robots", "arm99")] {
        let output = trials(folder.path(), &[flag, wrong, "--count", "1"]);
        assert_eq!(output.status.code(), Some(2));
        let words = String::from_utf8_lossy(&output.stderr);
        assert!(words.contains(flag) && words.contains(wrong), "{words}");
        assert!(!folder.path().join("results").exists());
    }
}

/// Robots by the seed of a run and the number in it. In turn: a spring that only filtered the encoder's noise had been
/// named beside what is missing, twice; bristles whose fit had ended worse than the model without them; bristles so soft
/// that the fit without them had found no dry friction; a play between two gaps that had been tried; something touched
/// for seconds, and a play that strikes three times, which blocks of rows do not tell the variance of; a rotor that other
/// hypotheses crowded out; bristles whose Stribeck speed had run against its limit; a sigmoid whose first start led to
/// friction that drives; reversals beside a coupling, whose shift of 0.2 ms had been taken for a delay of all signals;
/// a delay of one signal that had been given to all; an offset that had become a spring that pulls from far away; a
/// play whose strikes move by a row within a step of the grid; and an offset that a spring explains better on the
/// held-out rows alone.
#[test]
fn names_what_is_missing_and_nothing_else_where_a_search_had_gone_wrong() {
    let of_one = [(2, 56), (2, 62), (2, 32), (1, 170), (2, 127)];
    let of_another = [26, 402, 68, 87, 306, 207, 302].map(|number| (9, number));
    let of_others = [(13, 12), (13, 155), (14, 67)];
    for (seed, number) in of_one.into_iter().chain(of_another).chain(of_others) {
        let trial = run::run(&Scope::all(seed), number, &Control::default());
        let found: Vec<&str> = trial.found.iter().map(|f| f.effect.as_str()).collect();
        assert!(trial.all_found, "{seed}, {number}: {found:?}");
        assert_eq!(
            found.len(),
            trial.concealed.len(),
            "{seed}, {number}: {found:?}"
        );
    }
}

/// A channel that hears another joint's current had been called a coupling, a gain or an offset of this one, for what
/// they have in common; resistance by the product of two speeds, of 19 times the noise and 2 % of the torque, had been
/// passed over.
#[test]
fn what_comes_of_another_joint_has_no_name() {
    for (seed, number) in [(14, 198), (14, 445), (14, 562), (21, 152)] {
        let trial = run::run(&Scope::all(seed), number, &Control::default());
        let found: Vec<&str> = trial.found.iter().map(|f| f.effect.as_str()).collect();
        assert_eq!(found, ["unnamed"], "{number}");
        assert_eq!(trial.found[0].joints, trial.concealed[0].joints, "{number}");
    }
}
