//! Motor constants from motions at constant speed: the shipped problem, whose truth is published, and sweeps
//! of a real arm.

mod common;

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Table 3 of the paper: k_ct, k_fv, k_fc of the joints 1 to 6.
const TABLE_3: [[f64; 3]; 6] = [
    [12.3, 8.1272, 12.3141],
    [12.6351, 7.7891, 11.881],
    [12.0383, 6.9762, 10.7667],
    [7.7366, 2.4405, 1.8286],
    [7.9228, 2.6265, 1.2794],
    [7.4723, 3.6058, 0.8921],
];
const NAMES: [&str; 3] = [
    "torque_constant.k_ct",
    "viscous_friction.Fv",
    "coulomb_friction.Fc",
];

fn fit(folder: &Path, problem: &Path, sets: &[&str]) -> Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    command.current_dir(folder).arg("fit").arg(problem);
    command.args(["--json", "--out", "out"]);
    sets.iter().for_each(|set| {
        command.args(["--set", set]);
    });
    let output = command.output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn shipped(sets: &[&str]) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    fit(
        folder.path(),
        &root.join("problems/ur5_motors/problem.toml"),
        sets,
    )
}

fn parameter<'a>(result: &'a Value, name: &str) -> &'a Value {
    let parameters = result["parameters"].as_array().unwrap();
    let found = parameters.iter().find(|p| p["name"] == name);
    found.unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn recovers_known_truth_of_the_published_constants() {
    let result = shipped(&[]);
    let mut compared = 0;
    for (k, truth) in TABLE_3.iter().enumerate() {
        for (name, truth) in NAMES.iter().zip(truth) {
            let name = format!("joint{}.{name}", k + 1);
            let found = parameter(&result, &name);
            if name == "joint1.torque_constant.k_ct" {
                assert_eq!(found["source"], "undetermined");
                assert!(found["value"].is_null());
                continue;
            }
            let (value, sd) = (
                found["value"].as_f64().unwrap(),
                found["std_dev"].as_f64().unwrap(),
            );
            eprintln!("{name}: {value:.4} ± {sd:.4}, published {truth}");
            assert!(
                (value - truth).abs() <= 4.0 * sd,
                "{name}: {value} ± {sd}, {truth}"
            );
            // An interval that contains everything says nothing. Joint 1 borrows its torque constant, and
            // with it the spread between two joints of the type.
            let widest = if k == 0 { 0.1 } else { 0.15 };
            assert!(sd < widest * truth, "{name}: {value} ± {sd}");
            compared += 1;
        }
    }
    assert_eq!(compared, 17);
}

#[test]
fn a_torque_constant_that_gravity_does_not_load_is_noticed_and_what_helps_is_said() {
    let result = shipped(&["fit.constant_velocity.same_type=[]"]);
    let first = parameter(&result, "joint1.torque_constant.k_ct");
    assert_eq!(first["source"], "undetermined");
    assert_eq!(
        parameter(&result, "joint1.coulomb_friction.Fc")["source"],
        "undetermined"
    );
    let words = first["description"].as_str().unwrap();
    assert!(
        words.contains("parallel to gravity") && words.contains("same_type"),
        "{words}"
    );
    // What the data do determine: friction as a current.
    let ratio = &result["base_parameters"][0];
    assert_eq!(
        ratio["expression"],
        "joint1.coulomb_friction.Fc / joint1.torque_constant.k_ct"
    );
    let (value, sd) = (
        ratio["value"].as_f64().unwrap(),
        ratio["std_dev"].as_f64().unwrap(),
    );
    assert!((value - 12.3141 / 12.3).abs() < 4.0 * sd);
    // Given the constant, the friction follows, and the constant is known.
    let result = shipped(&["fit.constant_velocity.torque_constant={joint1=12.3}"]);
    assert_eq!(
        parameter(&result, "joint1.torque_constant.k_ct")["source"],
        "known"
    );
    let friction = parameter(&result, "joint1.coulomb_friction.Fc");
    assert_eq!(friction["source"], "data");
}

#[test]
fn both_solutions_of_the_first_stage_agree_and_motors_of_a_type_differ() {
    let result = shipped(&[]);
    let mut compared = 0;
    for joint in result["motors"]["joints"].as_array().unwrap() {
        for at in joint["speeds"].as_array().unwrap() {
            let (Some(linear), Some(simplex)) = (
                at["torque_constant"].as_f64(),
                at["torque_constant_simplex"].as_f64(),
            ) else {
                continue;
            };
            assert!((simplex / linear - 1.0).abs() < 1e-5, "{at}");
            compared += 1;
        }
    }
    assert_eq!(compared, 5 * 8, "joints 2 to 6, eight speeds");
    // Joints 2 and 3 differ by 5 %, as published.
    let group = &result["motors"]["same_type"][0];
    assert_eq!(group["joints"], serde_json::json!(["joint2", "joint3"]));
    assert!(group["p_value"].as_f64().unwrap() < 0.001);
}

/// Each sweep moves at one speed: the torque constant and the friction torque at it are determined, its two
/// coefficients are not.
#[test]
fn sweeps_of_a_real_arm_give_torque_constants_and_friction_that_grows_with_the_load() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let data = data.join("data/ur10e").canonicalize().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let problem = folder.path().join("problem.toml");
    // Factor and band of the load-dependent friction that was found by hand.
    for (joint, by_hand) in [(2, 0.063), (3, 0.060)] {
        let text = format!(
            "name = \"sweeps\"\n[robot]\nurdf = \"{0}/ur10e.urdf\"\ninertials = \"known\"\n\
             [recordings]\ntrain = [\"{0}/joint{joint}_sweeps.csv\"]\nsignal = \"current\"\n\
             [fit]\nestimator = \"constant_velocity\"\n",
            data.display()
        );
        std::fs::write(&problem, text).unwrap();
        let result = fit(folder.path(), &problem, &[]);
        let joints = result["motors"]["joints"].as_array().unwrap();
        let swept = joints
            .iter()
            .find(|j| j["parts"].as_u64().unwrap() > 0)
            .unwrap();
        let load = &swept["load_dependence"];
        let name = swept["joint"].as_str().unwrap();
        let k = parameter(&result, &format!("{name}.torque_constant.k_ct"));
        let friction = result["base_parameters"].as_array().unwrap();
        let friction = friction
            .iter()
            .find(|b| b["expression"].as_str().unwrap().starts_with(name));
        eprintln!("joint {joint}: k_ct {k}, load {load}, friction {friction:?}");
        assert_eq!(k["source"], "data");
        assert!(friction.is_some());
        let mu = load["mu"].as_f64().unwrap();
        assert!(mu > 0.5 * by_hand && mu < 2.0 * by_hand, "{mu}");
    }
}
