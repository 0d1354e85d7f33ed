//! Motor constants from motions at constant speed: the shipped problem, whose truth is published, and sweeps
//! of a real arm.

mod common;

use serde_json::Value;
use std::fs;
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
    let mut arguments = vec!["fit", problem.to_str().unwrap(), "--out", "out"];
    sets.iter().for_each(|set| arguments.extend(["--set", set]));
    run(folder, &arguments)
}

fn run(folder: &Path, arguments: &[&str]) -> Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    command.current_dir(folder).args(arguments).arg("--json");
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

/// Joints of the UR10e that rest in the sweeps, where they rest.
const RESTING: &str = "locked = { shoulder_pan_joint = 0.0, wrist_1_joint = -1.5708, wrist_2_joint = 0.0, \
                       wrist_3_joint = 0.0 }";

/// A problem on the sweeps of joints 2 and 3, with further lines of `[robot]` and the tables after it.
fn sweeps(data: &Path, robot: &str, signal: &str, rest: &str) -> String {
    let data = data.display();
    format!(
        "name = \"sweeps\"\n[robot]\nurdf = \"{data}/ur10e.urdf\"\n{robot}\n[recordings]\n\
         train = [\"{data}/joint2_sweeps.csv\", \"{data}/joint3_sweeps.csv\"]\nsignal = \"{signal}\"\n{rest}"
    )
}

/// k_ct of a joint, its load-dependent friction and the standard deviation of that.
fn swept(result: &Value, joint: &str) -> [f64; 3] {
    let k = parameter(result, &format!("{joint}.torque_constant.k_ct"));
    assert_eq!(k["source"], "data");
    let mut joints = result["motors"]["joints"].as_array().unwrap().iter();
    let load = &joints.find(|j| j["joint"] == joint).unwrap()["load_dependence"];
    // Each sweep moves at one speed: only the sum of both terms of friction is determined.
    let friction = result["base_parameters"].as_array().unwrap();
    let mut friction = friction.iter();
    let friction = friction.find(|b| b["expression"].as_str().unwrap().starts_with(joint));
    eprintln!(
        "{joint}: k_ct {} ± {}, 95 % {}; with friction that grows with the load {} ± {}; friction {}, {} ± {}; \
         per torque {} ± {}",
        k["value"],
        k["std_dev"],
        k["ci95"],
        load["torque_constant"],
        load["torque_constant_std_dev"],
        friction.unwrap()["expression"],
        friction.unwrap()["value"],
        friction.unwrap()["std_dev"],
        load["mu"],
        load["mu_std_dev"]
    );
    let number = |value: &Value| value.as_f64().unwrap();
    [
        number(&k["value"]),
        number(&load["mu"]),
        number(&load["mu_std_dev"]),
    ]
}

/// Two joints, their load-dependent friction found by hand, and the published torque constants times what makes a
/// known load weigh what it does: 0.910 ± 0.008 (see `real_recordings.rs`).
const SWEPT: [(&str, f64, f64); 2] = [
    ("shoulder_lift_joint", 0.063, 13.26 * 0.910),
    ("elbow_joint", 0.060, 11.13 * 0.910),
];

#[test]
fn sweeps_of_a_real_arm_give_torque_constants_and_friction_that_grows_with_the_load() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let data = data.join("data/ur10e").canonicalize().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let [controller, by_urdf, by_controller] =
        ["controller", "urdf", "current"].map(|name| folder.path().join(format!("{name}.toml")));
    // The bodies as the maker has them: the torque that the controller desires, without friction.
    let torque = "[recordings.columns]\ntorque = \"tau_ref{n}\"\n[recordings.differentiation]\ncutoff_hz = 5.0\n\
                  [fit]\nestimator = \"wls\"\n";
    fs::write(&controller, sweeps(&data, RESTING, "torque", torque)).unwrap();
    let current = "[fit]\nestimator = \"constant_velocity\"\n";
    let known = format!("inertials = \"known\"\n{RESTING}");
    fs::write(&by_urdf, sweeps(&data, &known, "current", current)).unwrap();
    let found = fit(folder.path(), &by_urdf, &[]);
    let of_urdf = SWEPT.map(|(joint, by_hand, _)| {
        let [k, mu, sd] = swept(&found, joint);
        assert!(
            (mu - by_hand).abs() < 3.0 * sd && mu > 3.0 * sd,
            "{joint}: {mu} ± {sd}"
        );
        k
    });
    fit(folder.path(), &controller, &[]);
    fs::copy(
        folder.path().join("out/result.json"),
        folder.path().join("bodies.json"),
    )
    .unwrap();
    let known = format!("{known}\nparameters = \"bodies.json\"");
    fs::write(&by_controller, sweeps(&data, &known, "current", current)).unwrap();
    let found = fit(folder.path(), &by_controller, &[]);
    for ((joint, _, by_load), of_urdf) in SWEPT.into_iter().zip(of_urdf) {
        let [k, ..] = swept(&found, joint);
        // With the maker's bodies the constants come nearer to those that give the load of a balance.
        assert!(
            (k - by_load).abs() < (of_urdf - by_load).abs(),
            "{joint}: {k} {of_urdf}"
        );
    }
}

/// The shipped robot in a folder, with a plan to be made and recordings along it.
fn planned(folder: &Path) {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/ur5_motors");
    let text = fs::read_to_string(shipped.join("problem.toml")).unwrap();
    let (robot, _) = text.split_once("[recordings]").unwrap();
    let robot = robot.replace("ur5.urdf", &shipped.join("ur5.urdf").display().to_string());
    let plan = "[recordings]\ntrain = [\"train.csv\"]\nsignal = \"current\"\nrate = 50.0\n[fit]\n\
                estimator = \"constant_velocity\"\n[design]\nkind = \"constant_velocity\"\n[design.limits]\n\
                acceleration = 4.0\n[simulate]\ntrajectory = \"plan/trajectory.csv\"\nrate = 50.0\nperiods = 1\n\
                warmup_periods = 0\nnoise = [0.1, 0.1, 0.1, 0.1, 0.1, 0.1]\n[simulate.values]\n";
    let mut problem = robot + plan;
    for (joint, [_, viscous, coulomb]) in (1..).zip(TABLE_3) {
        for (name, value) in [
            ("coulomb_friction.Fc", coulomb),
            ("viscous_friction.Fv", viscous),
        ] {
            problem.push_str(&format!("\"joint{joint}.{name}\" = {value}\n"));
        }
        problem.push_str(&format!("\"joint{joint}.coulomb_friction.w\" = 0.0\n"));
    }
    fs::write(folder.join("problem.toml"), problem).unwrap();
}

/// A plan of constant velocities from the shipped problem, which does not know the torque constants: recordings along
/// it give them back.
#[test]
fn recovers_known_truth_along_a_planned_motion() {
    let folder = tempfile::tempdir().unwrap();
    planned(folder.path());
    let constants = TABLE_3.map(|[k, ..]| k);
    let constants = format!("drive.torque_constant={constants:?}");
    run(folder.path(), &["design", "problem.toml", "--out", "plan"]);
    let ros = fs::read_to_string(folder.path().join("plan/trajectory_with_ramps.yaml")).unwrap();
    assert!(ros.contains("joint_names") && ros.contains("time_from_start"));
    run(
        folder.path(),
        &[
            "simulate",
            "problem.toml",
            "--out",
            "sim",
            "--seed",
            "1",
            "--set",
            &constants,
        ],
    );
    let result = run(
        folder.path(),
        &[
            "fit",
            "problem.toml",
            "--set",
            "recordings.train=[\"sim/train.csv\"]",
        ],
    );
    for (joint, truth) in (1..).zip(TABLE_3) {
        for (name, truth) in NAMES.iter().zip(truth) {
            let name = format!("joint{joint}.{name}");
            let found = parameter(&result, &name);
            // Neither joint 1 nor, where the arm rests, joint 5 carries a load about its axis.
            if [1, 5].contains(&joint) {
                assert_eq!(found["source"], "undetermined", "{name}");
                continue;
            }
            let [value, sd] = ["value", "std_dev"].map(|key| found[key].as_f64().unwrap());
            eprintln!("{name}: {value:.4} ± {sd:.4} for {truth}");
            assert!(
                (value - truth).abs() <= 4.0 * sd,
                "{name}: {value} ± {sd} for {truth}"
            );
            assert!(sd < 0.05 * truth, "{name}: {value} ± {sd}");
        }
    }
}
