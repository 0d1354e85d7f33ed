//! What a robot file says of drives is in the model: rotors as known, friction and springs to start from, limits; and where
//! recordings say otherwise, that is said.

use crate::followers::{estimated, result, run, simulate};
use crate::{folder, model};
use std::fs;

#[test]
fn drives_are_read_at_joint_scale() {
    let robot = model("drives");
    let [a, b] = [0, 1].map(|k| (robot.drives[k], robot.tree.joints()[k].limits));
    assert_eq!(a.0.rotor_inertia, Some(0.3));
    assert_eq!(a.0.viscous_friction, Some(1.5));
    assert_eq!(a.0.coulomb_friction, Some(0.4));
    let spring = a.0.spring.unwrap();
    assert_eq!(spring.stiffness, 12.0);
    assert!((spring.rest - 20f64.to_radians()).abs() < 1e-15);
    let servo = a.0.servo.unwrap();
    assert_eq!([servo.gear, servo.kp, servo.kv], [2.0, 200.0, 15.0]);
    // 30 N of the actuator are 60 N·m at the joint; a motor's command is its force.
    assert_eq!(a.1.effort, Some(60.0));
    assert_eq!(b.1.effort, Some(30.0));
    assert_eq!([b.1.lower, b.1.upper], [Some(-0.2), Some(0.3)]);
    assert_eq!(b.0.spring, None);
    // Rotors and bearings of motors turn with their gears.
    let reflected = model("reflected_rotors").drives;
    assert!((reflected[0].rotor_inertia.unwrap() - 0.5).abs() < 1e-15);
    assert!((reflected[0].viscous_friction.unwrap() - 2.5).abs() < 1e-15);
    assert!((reflected[1].rotor_inertia.unwrap() - 0.2).abs() < 1e-15);
    assert_eq!(reflected[1].servo.unwrap().kp, 30.0);
}

const PROBLEM: &str = r#"
[robot]
mjcf = "robot.xml"
inertials = "known"
[recordings]
train = ["train.csv"]
validation = ["validation.csv"]
signal = "torque"
rate = 200.0
period = 6.0
[simulate]
periods = 3
noise = [0.05, 0.05]
"#;

#[test]
fn recovers_known_truth_and_says_what_the_file_has_otherwise() {
    let own = tempfile::tempdir().unwrap();
    let robot = folder().join("models/drives.xml");
    fs::copy(robot, own.path().join("robot.xml")).unwrap();
    let differs = "[simulate.values]\n\"a.viscous_friction.Fv\" = 4.3\n";
    fs::write(
        own.path().join("problem.toml"),
        format!("{PROBLEM}{differs}"),
    )
    .unwrap();
    simulate(own.path(), &[]);
    let (code, said) = run(own.path(), &["fit", "problem.toml", "--out", "fit"]);
    assert_eq!(code, Some(0), "{said}");
    let fit = result(own.path(), "fit");
    for (name, truth) in [
        ("a.viscous_friction.Fv", 4.3),
        ("a.coulomb_friction.Fc", 0.4),
        ("b.viscous_friction.Fv", 7.0),
        ("a.joint_spring.k", 12.0),
        ("a.joint_spring.q0", 20f64.to_radians()),
    ] {
        let [value, deviation] = estimated(&fit, name);
        assert!(
            (value - truth).abs() < 4.0 * deviation,
            "{name}: {value} ± {deviation}"
        );
    }
    // The rotor is known, and what agrees is not listed.
    let parameters = fit["parameters"].as_array().unwrap();
    let rotor = parameters
        .iter()
        .find(|p| p["name"] == "a.rotor_inertia.Jm")
        .unwrap();
    assert_eq!(
        (rotor["value"].as_f64(), rotor["source"].as_str()),
        (Some(0.3), Some("known"))
    );
    let notes = fit["notes"].to_string();
    assert!(notes.contains("a.viscous_friction.Fv 1.5"), "{notes}");
    assert!(!notes.contains("b.viscous_friction.Fv 7"), "{notes}");
}

#[test]
fn values_of_the_problem_file_take_the_place_of_the_robot_files() {
    let own = tempfile::tempdir().unwrap();
    let robot = folder().join("models/drives.xml");
    fs::copy(robot, own.path().join("robot.xml")).unwrap();
    let drive = "[drive]\nrotor_inertia = [0.1, 0.7]\nvalues = { \"b.viscous_friction.Fv\" = 6.0 }\n\
                 effects_of = { a = [\"viscous_friction\"] }\n[simulate.values]\n\"a.viscous_friction.Fv\" = 1.5\n";
    fs::write(own.path().join("problem.toml"), format!("{PROBLEM}{drive}")).unwrap();
    simulate(own.path(), &[]);
    let (code, said) = run(own.path(), &["fit", "problem.toml", "--out", "fit"]);
    assert_eq!(code, Some(0), "{said}");
    let fit = result(own.path(), "fit");
    let parameters = fit["parameters"].as_array().unwrap();
    let of = |name: &str| parameters.iter().find(|p| p["name"] == name);
    assert_eq!(of("a.rotor_inertia.Jm").unwrap()["value"], 0.1);
    assert_eq!(of("b.viscous_friction.Fv").unwrap()["value"], 6.0);
    assert!(of("a.joint_spring.k").is_none() && of("a.coulomb_friction.Fc").is_none());
    for verb in ["check", "diagnose"] {
        let (code, said) = run(own.path(), &[verb, "problem.toml", "--out", verb]);
        assert_eq!(code, Some(0), "{verb}: {said}");
    }
}
