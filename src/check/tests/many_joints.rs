//! Robots of so many joints that no other order of their columns is tried.

use crate::chain::effect::ids;
use crate::check::run;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::robot::random::{generator, symmetric};
use std::f64::consts::TAU;
use std::fmt::Write;
use std::fs;
use std::path::Path;

const JOINTS: usize = 20;

/// More than three for each unknown of a joint.
const ROWS: usize = 1500;

const RATE_HZ: f64 = 100.0;

/// A chain of joints whose axes change.
fn robot() -> String {
    let mut robot = "<robot name=\"chain\"><link name=\"l0\"/>\n".to_string();
    for k in 1..=JOINTS {
        let axis = ["0 1 0", "0 0 1"][k % 2];
        let before = k - 1;
        write!(
            robot,
            "<link name=\"l{k}\"><inertial><mass value=\"1\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" \
             iyz=\"0\" izz=\"0.01\"/></inertial></link>\n<joint name=\"j{k}\" type=\"continuous\"><parent link=\"l{before}\"/>\
             <child link=\"l{k}\"/><origin xyz=\"0 0 0.1\"/><axis xyz=\"{axis}\"/></joint>\n"
        )
        .unwrap();
    }
    robot + "</robot>\n"
}

/// Torques of white noise beside a vibration of the motors, N·m, that no motion of the robot has.
fn recording(vibration: f64) -> String {
    let mut rng = generator(1);
    let columns = |name: &str| {
        (1..=JOINTS)
            .map(|k| format!(",{name}{k}"))
            .collect::<String>()
    };
    let mut text = format!("t{}{}\n", columns("q"), columns("tau"));
    for row in 0..ROWS {
        let t = row as f64 / RATE_HZ;
        write!(text, "{t}").unwrap();
        for k in 1..=JOINTS {
            let frequency = 0.2 + 0.03 * k as f64;
            let position = (TAU * frequency * t + k as f64).sin();
            write!(text, ",{position}").unwrap();
        }
        for k in 1..=JOINTS {
            let torque = vibration * (TAU * 3.0 * t + k as f64).sin() + symmetric(&mut rng, 1.0);
            write!(text, ",{torque}").unwrap();
        }
        text.push('\n');
    }
    text
}

/// Codes of what is found in the order of the columns.
fn order_findings(folder: &Path, vibration: f64) -> Vec<String> {
    fs::write(folder.join("chain.urdf"), robot()).unwrap();
    fs::write(folder.join("train.csv"), recording(vibration)).unwrap();
    let problem = "name = \"chain\"\n[robot]\nurdf = \"chain.urdf\"\n[recordings]\nsignal = \"torque\"\ntrain = [\"train.csv\"]\n";
    fs::write(folder.join("problem.toml"), problem).unwrap();
    let problem = ProblemFile::read(&folder.join("problem.toml"), &[], &ids()).unwrap();
    let found = run(&problem, &Control::default()).into_iter();
    let codes = found.map(|finding| finding.code);
    codes
        .filter(|code| code.contains("order") || code.contains("sign"))
        .collect()
}

/// Where the declared order leaves no more than white noise there is nothing to look for; where it leaves more, that it was not
/// looked for is said.
#[test]
fn an_order_that_is_not_tried_is_said_unless_no_other_can_be_better() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(order_findings(folder.path(), 0.0), [""; 0]);
    assert_eq!(order_findings(folder.path(), 10.0), ["order-not-tried"]);
}
