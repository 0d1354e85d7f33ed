//! Joints that follow others: their torques reach the motors of their leaders, and `fit` and `simulate` need no word of them.

use crate::{Reference, folder, references};
use exid::chain::effect::ids;
use exid::chain::evaluate::{Evaluator, Segment};
use exid::problem_file::ProblemFile;
use exid::robot::batch::Trajectory;
use exid::setup::model_spec::ModelSpec;
use exid::setup::robot;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Rounding of both programs, as a share of the largest torque of the robot.
const ROUNDING: f64 = 1e-9;

fn problem(folder: &Path, text: &str) -> ProblemFile {
    let path = folder.join("problem.toml");
    fs::write(&path, text).unwrap();
    ProblemFile::read(&path, &[], &ids()).unwrap_or_else(|e| panic!("{e}"))
}

/// Largest difference of the torques of motors, as a share of the largest.
fn difference(text: &str, reference: &Reference) -> f64 {
    let own = tempfile::tempdir().unwrap();
    let problem = problem(own.path(), text);
    let robot = robot::open(&problem).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(robot.order, reference.joints);
    let declared = ModelSpec::without_prior(&problem, &robot);
    let built = declared.and_then(|declared| declared.build());
    let model = built.unwrap_or_else(|e| panic!("{e}")).model;
    let mut evaluator = Evaluator::new(&model, &model.values(), &[]);
    let mut worst = 0.0_f64;
    for state in &reference.states {
        let mut motors =
            [&state.q, &state.dq, &state.ddq].map(|_| vec![vec![0.0]; robot.tree.len()]);
        for (k, &at) in robot.position.iter().enumerate() {
            let values = [state.q[k], state.dq[k], state.ddq[k]];
            for (motion, value) in motors.iter_mut().zip(values) {
                motion[at][0] = value;
            }
        }
        let [q, dq, ddq] = &motors;
        let block = evaluator.evaluate(Segment::states(Trajectory { q, dq, ddq }, false), 0..1);
        let largest = state.tau.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
        for (&at, tau) in robot.position.iter().zip(&state.tau) {
            worst = worst.max((block.value(at)[0] - tau).abs() / largest);
        }
    }
    worst
}

#[test]
fn matches_mujoco_in_the_torques_that_reach_the_leaders() {
    let references = references().followers;
    let path = |name: &str| folder().join(name).display().to_string();
    for (name, key, file) in [
        ("couplings", "mjcf", "models/couplings.xml"),
        ("arm_hand", "urdf", "arm_hand.urdf"),
    ] {
        let text = format!("[robot]\n{key} = '{}'\ninertials = \"known\"\n", path(file));
        let apart = difference(&text, &references[name]);
        assert!(apart <= ROUNDING, "{name}: {apart:.2e}");
    }
}

#[test]
fn invariant_a_follower_of_a_locked_joint_is_locked_where_it_would_be() {
    let own = tempfile::tempdir().unwrap();
    let urdf = folder().join("arm_hand.urdf").display().to_string();
    let text = format!("[robot]\nurdf = '{urdf}'\nlocked = {{ finger_joint1 = 0.01 }}\n");
    let robot = robot::open(&problem(own.path(), &text)).unwrap();
    let at = |name: &str| robot.locked[robot.tree.joint_index(name).unwrap()];
    assert_eq!(at("finger_joint2"), Some(0.01));
    assert!((at("thumb_joint").unwrap() - (0.2 - 0.3)).abs() < 1e-15);
    assert_eq!(at("elbow"), None);
    assert!(robot.dependents.is_empty());
    // A finger that is held holds the other, and what the problem file says of one is so.
    let text = format!(
        "[robot]\nurdf = '{urdf}'\nlocked = {{ finger_joint2 = 0.02, thumb_joint = 0.1 }}\n"
    );
    let robot = robot::open(&problem(own.path(), &text)).unwrap();
    let at = |name: &str| robot.locked[robot.tree.joint_index(name).unwrap()];
    assert_eq!(at("finger_joint1"), Some(0.02));
    assert_eq!(at("thumb_joint"), Some(0.1));
}

/// Runs the program in a folder; its exit code and what it said.
pub fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_exid"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let said = [output.stdout, output.stderr].concat();
    (
        output.status.code(),
        String::from_utf8_lossy(&said).into_owned(),
    )
}

/// Simulates and puts the recordings where the problem file looks for them.
pub fn simulate(folder: &Path, extra: &[&str]) {
    let (code, said) = run(
        folder,
        &[
            &["simulate", "problem.toml", "--out", "sim", "--seed", "3"],
            extra,
        ]
        .concat(),
    );
    assert_eq!(code, Some(0), "{said}");
    for name in ["train.csv", "validation.csv"] {
        fs::copy(folder.join("sim").join(name), folder.join(name)).unwrap();
    }
}

pub fn result(folder: &Path, out: &str) -> Value {
    let text = fs::read_to_string(folder.join(out).join("result.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// The estimate of a parameter and its standard deviation.
pub fn estimated(result: &Value, name: &str) -> [f64; 2] {
    let parameters = result["parameters"].as_array();
    let parameters = parameters.unwrap_or_else(|| panic!("no parameters in {result}"));
    let found = parameters.iter().find(|p| p["name"] == name);
    let found = found.unwrap_or_else(|| panic!("no {name}"));
    [&found["value"], &found["std_dev"]].map(|v| v.as_f64().unwrap_or_else(|| panic!("{found}")))
}

#[test]
fn recovers_known_truth_with_a_hand_that_moves() {
    let own = tempfile::tempdir().unwrap();
    fs::copy(
        folder().join("arm_hand.urdf"),
        own.path().join("robot.urdf"),
    )
    .unwrap();
    let text = r#"
[robot]
urdf = "robot.urdf"
inertials = "known"
[drive]
effects = ["viscous_friction", "torque_offset"]
[recordings]
train = ["train.csv"]
validation = ["validation.csv"]
signal = "torque"
rate = 200.0
period = 5.0
[simulate]
periods = 3
noise = [0.05, 0.03, 0.002]
[simulate.values]
"shoulder.viscous_friction.Fv" = 3.0
"elbow.viscous_friction.Fv" = 2.0
"finger_joint1.viscous_friction.Fv" = 5.0
"shoulder.torque_offset.offset" = 0.2
"elbow.torque_offset.offset" = -0.1
"finger_joint1.torque_offset.offset" = 0.05
"#;
    fs::write(own.path().join("problem.toml"), text).unwrap();
    simulate(own.path(), &[]);
    // Joints that follow others have no channels.
    let recorded = fs::read_to_string(own.path().join("train.csv")).unwrap();
    assert_eq!(recorded.lines().next(), Some("t,q1,q2,q3,tau1,tau2,tau3"));
    let (code, said) = run(own.path(), &["fit", "problem.toml", "--out", "fit"]);
    assert_eq!(code, Some(0), "{said}");
    let fit = result(own.path(), "fit");
    for (name, truth) in [
        ("shoulder.viscous_friction.Fv", 3.0),
        ("elbow.viscous_friction.Fv", 2.0),
        ("finger_joint1.viscous_friction.Fv", 5.0),
        ("finger_joint1.torque_offset.offset", 0.05),
    ] {
        let [value, deviation] = estimated(&fit, name);
        assert!(
            (value - truth).abs() < 4.0 * deviation,
            "{name}: {value} ± {deviation}"
        );
    }
    let codes = fit["mistakes"].as_array().unwrap().iter();
    let held = codes.filter(|mistake| mistake["code"] == "joint-held-still");
    assert_eq!(held.count(), 2, "the floating joint and the planar one");
    // What is exported moves in the same way.
    let (code, said) = run(
        own.path(),
        &["export", "fit", "--to", "mjcf", "--out", "out"],
    );
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("thumb_joint has no motor and follows finger_joint1"),
        "{said}"
    );
    // A design moves joints one by one.
    let (code, said) = run(own.path(), &["design", "problem.toml", "--out", "design"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("lock it for the motion: robot.locked = { finger_joint1 = 0.0 }"),
        "{said}"
    );
}
