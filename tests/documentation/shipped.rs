//! Every shipped problem runs by its one command and ends well.

use crate::pages::root;
use std::path::Path;
use std::process::Command;

/// A problem, the verb that it is for, and what keeps the run short where that is not the problem's own settings.
struct Shipped {
    problem: &'static str,
    verb: &'static str,
    settings: &'static [&'static str],
    /// What the run has to print.
    says: &'static str,
}

const fn fit(problem: &'static str, says: &'static str) -> Shipped {
    Shipped {
        problem,
        verb: "fit",
        settings: &[],
        says,
    }
}

/// A design from one start: what more starts find is better, and takes as many times as long.
const fn design(problem: &'static str) -> Shipped {
    Shipped {
        problem,
        verb: "design",
        settings: &["design.starts=1"],
        says: "condition number",
    }
}

const SHIPPED: &[Shipped] = &[
    fit("arm6/problem.toml", "60 undetermined"),
    Shipped {
        problem: "arm6_gearbox/problem.toml",
        verb: "diagnose",
        settings: &[],
        says: "verdict: explained",
    },
    Shipped {
        problem: "mujoco_arm/problem.toml",
        verb: "diagnose",
        settings: &[],
        says: "Only on the robot: joint3 loses",
    },
    fit("kr150_payload/problem.toml", "mass "),
    fit("h4_parallel/problem.toml", "converged"),
    fit("h4_parallel/sensors.toml", "converged"),
    fit("h4_parallel/gains.toml", "gain"),
    fit("parallelogram/problem.toml", "rank 12"),
    fit("puma562_reaction/problem.toml", "rank"),
    fit("ur5_motors/problem.toml", "k_ct"),
    fit("panda_friction/problem.toml", "Stribeck"),
    fit("panda_friction/hand.toml", "mass "),
    Shipped {
        problem: "panda_control/problem.toml",
        verb: "simulate",
        settings: &[],
        says: "train.csv",
    },
    design("kr150_excitation/problem.toml"),
    // As it ships: the best of its starts has to keep the limits too.
    Shipped {
        problem: "panda_excitation/problem.toml",
        verb: "design",
        settings: &[],
        says: "condition number",
    },
    design("scara_excitation/problem.toml"),
];

#[test]
fn every_shipped_problem_runs() {
    let folder = tempfile::tempdir().unwrap();
    let mut faults = Vec::new();
    for shipped in SHIPPED {
        let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
        command
            .arg(shipped.verb)
            .arg(root().join("problems").join(shipped.problem));
        for setting in shipped.settings {
            command.args(["--set", setting]);
        }
        let output = command.current_dir(folder.path()).output().unwrap();
        let printed = String::from_utf8_lossy(&output.stdout);
        if output.status.code() != Some(0) || !printed.contains(shipped.says) {
            let errors = String::from_utf8_lossy(&output.stderr);
            faults.push(format!(
                "exid {} {}: {:?}\n{printed}{errors}",
                shipped.verb,
                shipped.problem,
                output.status.code()
            ));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// What is wrong with a shipped problem would be taken for what is wrong with the checks.
#[test]
fn every_shipped_problem_passes_its_checks() {
    let folder = tempfile::tempdir().unwrap();
    let mut faults = Vec::new();
    for shipped in SHIPPED {
        let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
        command
            .arg("check")
            .arg(root().join("problems").join(shipped.problem));
        let output = command.current_dir(folder.path()).output().unwrap();
        let printed = String::from_utf8_lossy(&output.stdout);
        if output.status.code() != Some(0) || printed.contains("warning: ") {
            let errors = String::from_utf8_lossy(&output.stderr);
            faults.push(format!("{}\n{printed}{errors}", shipped.problem));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// No problem ships that the table does not run.
#[test]
fn the_table_has_every_shipped_problem() {
    let mut missing = Vec::new();
    for folder in std::fs::read_dir(root().join("problems")).unwrap() {
        let folder = folder.unwrap().path();
        for file in std::fs::read_dir(&folder).unwrap() {
            let file = file.unwrap().path();
            let name = file.strip_prefix(root().join("problems")).unwrap();
            let text = name.to_string_lossy().into_owned();
            let is_problem = text.ends_with(".toml") && !text.ends_with(".mdh.toml");
            if is_problem && !SHIPPED.iter().any(|s| Path::new(s.problem) == name) {
                missing.push(text);
            }
        }
    }
    assert!(missing.is_empty(), "{missing:?}");
}
