//! The legs of a real robot without a torque channel.

use crate::common;
use crate::folder;
use crate::verbs::{parameter, run};
use serde_json::Value;
use std::fs;

/// The fit of a real robot whose trunk is held in the air, first half fitted and second tested; `None` without the recording.
fn legs(name: &str, effects: &[&str]) -> Option<Value> {
    let source = common::data_dir()?.join("data/go2");
    let folder = folder(name);
    let all = fs::read_to_string(source.join("held_base.csv")).unwrap();
    let mut lines = all.lines();
    let header = lines.next().unwrap();
    let rows: Vec<&str> = lines.collect();
    let (first, second) = rows.split_at(rows.len() / 2);
    for (name, rows) in [("first.csv", first), ("second.csv", second)] {
        fs::write(
            folder.join(name),
            format!("{header}\n{}\n", rows.join("\n")),
        )
        .unwrap();
    }
    let robot = source.canonicalize().unwrap().join("go2.xml");
    let text = format!(
        "[robot]\nmjcf = {robot:?}\ninertials = \"known\"\n[drive]\neffects = {effects:?}\n[recordings]\n\
         train = [\"first.csv\"]\nvalidation = [\"second.csv\"]\n\
         signal = \"position_command\"\n[recordings.differentiation]\nmethod = \"lowpass\"\ncutoff_hz = 12.0\n\
         parallel_hz = 12.0\n[controller]\nkp = \"estimate\"\nkd = 1.5\n"
    );
    fs::write(folder.join("problem.toml"), text).unwrap();
    Some(run(&folder, "fit"))
}

const LEGS: [&str; 4] = ["FL", "FR", "RL", "RR"];

/// Nominal gain of all motors, 20 N·m/rad; by hand those of the thighs come out between 16.1 and 18.1.
fn assert_near_nominal(result: &Value, joint: &str) {
    let kp = parameter(result, &format!("{joint}.controller.kp"));
    let value = kp["value"].as_f64().unwrap();
    assert!((15.0..=21.0).contains(&value), "{kp}");
    let [low, high] = [0, 1].map(|k| kp["ci95"][k].as_f64().unwrap());
    assert!(
        0.0 < low && low < value && value < high && high < 1.25 * value,
        "{kp}"
    );
}

/// Held-out errors of the thighs by hand: 3.2 to 5.0 % of the command error.
#[test]
fn gains_of_the_legs_of_a_real_robot() {
    let effects = [
        "rotor_inertia",
        "coulomb_friction",
        "viscous_friction",
        "torque_offset",
    ];
    let Some(result) = legs("go2", &effects) else {
        return;
    };
    for leg in LEGS {
        assert_near_nominal(&result, &format!("{leg}_thigh_joint"));
    }
    let joints = result["joints"].as_array().unwrap();
    for joint in joints
        .iter()
        .filter(|j| j["joint"].as_str().unwrap().contains("thigh"))
    {
        let relative = joint["relative_validation"].as_f64().unwrap();
        assert!(relative <= 0.05, "{joint}");
    }
    // What is hardly told has an interval that says so: calves, whose links weigh little.
    for leg in LEGS {
        let kp = parameter(&result, &format!("{leg}_calf_joint.controller.kp"));
        let [low, high] = [0, 1].map(|k| kp["ci95"][k].as_f64().unwrap());
        assert!(high > 1.5 * low, "{kp}");
    }
}

/// The legs hang beside the hips, with 1.2 N·m of gravity about the axis of each, left and right of opposite sign: the offsets of
/// the command at rest. Without an offset of the torque that could stand for it, gravity tells the gains of hips and thighs alike, and
/// the error on what was not fitted stays.
#[test]
fn gravity_tells_the_gains_of_the_hips_of_a_real_robot() {
    let effects = [
        "rotor_inertia",
        "coulomb_friction",
        "viscous_friction",
        "torque_offset",
    ];
    let (Some(without), Some(with)) = (
        legs("go2_hips", &effects[..3]),
        legs("go2_offset", &effects),
    ) else {
        return;
    };
    for leg in LEGS {
        let joint = format!("{leg}_hip_joint");
        assert_near_nominal(&without, &joint);
        assert_near_nominal(&without, &format!("{leg}_thigh_joint"));
        let held_out = |result: &Value| {
            let joints = result["joints"].as_array().unwrap();
            let own = joints
                .iter()
                .find(|j| j["joint"] == joint.as_str())
                .unwrap();
            own["relative_validation"].as_f64().unwrap()
        };
        assert!(held_out(&without) < 1.05 * held_out(&with), "{joint}");
    }
}
