//! Robot files against MuJoCo: inverse dynamics of models that each have another feature, joints that follow others, what
//! a file says of drives, and files that break.
//!
//! `reference.py` computes the torques with MuJoCo.

mod broken;
#[path = "../common/mod.rs"]
mod common;
mod drives;
mod followers;

use exid::robot::batch::{Trajectory, torques};
use exid::robot::description::Description;
use exid::robot::mjcf;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

#[derive(Deserialize)]
struct Reference {
    joints: Vec<String>,
    states: Vec<State>,
}

#[derive(Deserialize)]
struct State {
    q: Vec<f64>,
    dq: Vec<f64>,
    ddq: Vec<f64>,
    tau: Vec<f64>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mjcf")
}

/// Torques by MuJoCo of whole models, and of joints that move with others brought to their leaders.
#[derive(Deserialize)]
struct References {
    models: BTreeMap<String, Reference>,
    followers: BTreeMap<String, Reference>,
}

fn references() -> References {
    serde_json::from_str(include_str!("reference.json")).unwrap()
}

fn model(name: &str) -> Description {
    mjcf::read(&folder().join(format!("models/{name}.xml"))).unwrap_or_else(|e| panic!("{e}"))
}

/// Torques of bodies and rotors in the order of the tree.
fn torque(robot: &Description, [q, dq, ddq]: [&[f64]; 3]) -> Vec<f64> {
    let series = |v: &[f64]| v.iter().map(|x| vec![*x]).collect::<Vec<_>>();
    let (q, dq, motion) = (series(q), series(dq), series(ddq));
    let trajectory = Trajectory {
        q: &q,
        dq: &dq,
        ddq: &motion,
    };
    let bodies = torques(&robot.tree, &robot.tree.parameters(), trajectory);
    let each = bodies.iter().zip(&robot.drives).zip(ddq);
    each.map(|((torque, drive), ddq)| torque[0] + drive.rotor_inertia.unwrap_or(0.0) * ddq)
        .collect()
}

/// Largest difference of a torque as a share of the largest torque.
fn difference(robot: &Description, reference: &Reference) -> f64 {
    let joints = robot.tree.joints();
    let at = |k: usize| match reference.joints[k].as_str() {
        "" => k,
        name => robot
            .tree
            .joint_index(name)
            .unwrap_or_else(|| panic!("no joint {name}")),
    };
    assert_eq!(joints.len(), reference.joints.len(), "joints");
    let mut worst = 0.0_f64;
    for state in &reference.states {
        let mut motion = [&state.q, &state.dq, &state.ddq].map(|_| vec![0.0; joints.len()]);
        for k in 0..joints.len() {
            let values = [state.q[k], state.dq[k], state.ddq[k]];
            for (to, value) in motion.iter_mut().zip(values) {
                to[at(k)] = value;
            }
        }
        let [q, dq, ddq] = &motion;
        let found = torque(robot, [q, dq, ddq]);
        let size = state.tau.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
        for (k, tau) in state.tau.iter().enumerate() {
            worst = worst.max((found[at(k)] - tau).abs() / size);
        }
    }
    worst
}

/// Rounding of both programs, as a share of the largest torque.
const ROUNDING: f64 = 1e-9;

#[test]
fn matches_mujoco_on_every_model() {
    let mut compared = 0;
    let mut faults = Vec::new();
    for (name, reference) in references()
        .models
        .iter()
        .filter(|(name, _)| *name != "go2")
    {
        let apart = difference(&model(name), reference);
        compared += 1;
        if apart.is_nan() || apart > ROUNDING {
            faults.push(format!("{name}: {apart:.2e}"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(compared >= 41, "{compared} models");
}

#[test]
fn matches_mujoco_on_the_model_of_a_real_quadruped() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let robot = mjcf::read(&data.join("data/go2/go2.xml")).unwrap_or_else(|e| panic!("{e}"));
    let apart = difference(&robot, &references().models["go2"]);
    assert!(apart <= ROUNDING, "{apart:.2e}");
    // Its meshes are not there, and its bodies do not need them; its base is held, and that is said.
    let codes: Vec<&str> = robot.notes.iter().map(|note| note.words.code).collect();
    assert_eq!(codes, ["joint-held-still"]);
    assert_eq!(robot.drives[0].viscous_friction, Some(0.6));
    assert_eq!(robot.tree.joints()[0].limits.effort, Some(23.7));
}

#[test]
fn several_degrees_of_freedom_are_held_and_said() {
    let said = |name: &str| -> Vec<String> {
        let notes = model(name).notes;
        notes.iter().map(|note| note.to_string()).collect()
    };
    let [root, ball] = &said("free_base")[..] else {
        panic!("{:?}", said("free_base"));
    };
    assert!(
        root.contains("joint root: the joint is free; it is taken as fixed"),
        "{root}"
    );
    assert!(ball.contains(":16:7: joint: the joint is free"), "{ball}");
    assert!(said("ball_joint")[0].contains("the joint is ball"));
    assert!(said("two_arms").is_empty());
}

#[test]
fn every_file_that_was_read_is_named() {
    let files = model("include").files;
    let names: Vec<_> = files.iter().map(|f| f.file_name().unwrap()).collect();
    assert_eq!(names, ["include.xml", "settings.xml", "hand.xml"]);
}

#[test]
fn invariant_an_anchor_off_the_origin_keeps_the_frame_of_the_body() {
    let tree = model("anchors").tree;
    // The body `upper` has its origin at (0.1, 0.2, 0.3) where all joints are at zero, wherever its anchor is.
    let (joint, placement) = tree.frame("upper").unwrap();
    let poses = tree.forward_kinematics(&vec![0.0; tree.len()]);
    let whole = poses[joint.unwrap()] * placement;
    let expected = nalgebra::Vector3::new(0.1, 0.2, 0.3);
    assert!((whole.translation.vector - expected).norm() < 1e-12);
}
