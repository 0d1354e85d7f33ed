//! Recordings of real robots: errors on runs that were held out, and parameters that others have
//! published for them. The recordings are not shipped; without them these tests say that they skip.

mod common;

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// N·m: the figures to reach are stated to two decimals.
const ROUNDING: f64 = 0.005;

/// Writes the problem file, `{data}` standing for the folder of the recordings, and runs `exid fit`.
fn fit(data: &Path, problem: &str, robot: Option<&str>) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let data = data.join("data").canonicalize().unwrap();
    let problem = problem.replace("{data}", data.to_str().unwrap());
    fs::write(folder.path().join("problem.toml"), problem).unwrap();
    if let Some(robot) = robot {
        fs::write(folder.path().join("robot.urdf"), robot).unwrap();
    }
    let output = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder.path())
        .args(["fit", "problem.toml", "--json", "--out", "out"])
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A figure of every joint, in the order of the joints.
fn figures(result: &Value, key: &str) -> Vec<f64> {
    let joints = result["joints"].as_array().unwrap();
    let figure = |joint: &Value| joint[key].as_f64().unwrap();
    joints.iter().map(figure).collect()
}

/// Values of all parameters, and of base parameters by the first term of their expression.
fn values(result: &Value) -> BTreeMap<String, f64> {
    let mut values = BTreeMap::new();
    for parameter in result["base_parameters"].as_array().unwrap() {
        let expression = parameter["expression"].as_str().unwrap();
        let first = expression.split(' ').next().unwrap().to_owned();
        values.insert(first, parameter["value"].as_f64().unwrap());
    }
    for parameter in result["parameters"].as_array().unwrap() {
        let name = parameter["name"].as_str().unwrap().to_owned();
        if let Some(value) = parameter["value"].as_f64() {
            values.insert(name, value);
        }
    }
    values
}

/// Every figure at most its bar, both in N·m.
fn assert_at_most(what: &str, found: &[f64], bars: &[f64]) {
    eprintln!("{what}: {found:.3?} N·m, bars {bars:?}");
    assert_eq!(found.len(), bars.len());
    for (joint, (found, bar)) in found.iter().zip(bars).enumerate() {
        assert!(
            *found <= bar + ROUNDING,
            "{what}, joint {}: {found} N·m",
            joint + 1
        );
    }
}

fn assert_within(what: &str, found: f64, expected: f64, share: f64) {
    let deviation = found / expected - 1.0;
    eprintln!(
        "{what}: {found:.4}, published {expected} ({:+.2} %)",
        100.0 * deviation
    );
    assert!(
        deviation.abs() <= share,
        "{what}: {found} where {expected} is published"
    );
}

#[test]
fn ur10e_held_out_errors_reach_those_of_least_squares_by_hand() {
    const TORQUE_CONSTANT: [f64; 6] = [14.87, 13.26, 11.13, 10.62, 11.03, 11.47];
    // Trained on 30 s, tested on 40 s; Coulomb friction with tanh(dq / 0.01).
    const BARS: [f64; 6] = [2.38, 3.64, 1.70, 0.34, 0.36, 0.32];
    let Some(data) = common::data_dir() else {
        return;
    };
    let result = fit(&data, include_str!("real_recordings/ur10e.toml"), None);
    let held_out: Vec<f64> = (figures(&result, "rmse_validation").iter())
        .zip(TORQUE_CONSTANT)
        .map(|(current, constant)| current * constant)
        .collect();
    assert_at_most("UR10e, 30 s to 40 s", &held_out, &BARS);
}

/// The published symbols whose value is known well, and the parameters of this tool that they are.
/// Motor 6 turns with joints 5 and 6: the published friction of joint 5 carries that of motor 6.
const TX40: &[(&str, &[&str])] = &[
    ("Izz1", &["link_1.Izz"]),
    ("fv1", &["joint_1.viscous_friction.Fv"]),
    ("fs1", &["joint_1.coulomb_friction.Fc"]),
    ("Ixx2", &["link_2.Ixx"]),
    ("Ixz2", &["link_2.Ixz"]),
    ("Izz2", &["link_2.Izz"]),
    ("mx2", &["link_2.mcx"]),
    ("fv2", &["joint_2.viscous_friction.Fv"]),
    ("fs2", &["joint_2.coulomb_friction.Fc"]),
    ("my3", &["link_3.mcy"]),
    ("fv3", &["joint_3.viscous_friction.Fv"]),
    ("fs3", &["joint_3.coulomb_friction.Fc"]),
    ("fv4", &["joint_4.viscous_friction.Fv"]),
    ("fs4", &["joint_4.coulomb_friction.Fc"]),
    (
        "fv5",
        &["joint_5.viscous_friction.Fv", "joint_6.viscous_friction.Fv"],
    ),
    ("fs5", &["joint_5.coulomb_friction.Fc"]),
    ("fv6", &["joint_6.viscous_friction.Fv"]),
    ("fvm6", &["joint_6.viscous_friction.Fv"]),
    ("fsm6", &["joint_6.coulomb_friction.Fc"]),
];

/// Published values count as known well below this relative standard deviation, per cent.
const KNOWN_WELL: f64 = 5.0;

/// Rows of the published table: symbol, value and relative standard deviation in per cent, of ordinary
/// least squares and then of weighted. The symbol of a base parameter is its first term.
fn published(data: &Path) -> Vec<(String, f64, f64)> {
    let file = data.join("data/tx40/published_base_parameters.csv");
    let text = fs::read_to_string(file).unwrap();
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let symbol = fields[0].split(' ').next().unwrap().to_owned();
        (
            symbol,
            fields[1].parse().unwrap(),
            fields[2].parse().unwrap(),
        )
    };
    text.lines().map(row).collect()
}

#[test]
fn tx40_matches_published_base_parameters() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let result = fit(&data, include_str!("real_recordings/tx40.toml"), None);
    let found = values(&result);
    let published = published(&data);
    let known: Vec<_> = published.iter().filter(|row| row.2 < KNOWN_WELL).collect();
    assert_eq!(known.len(), TX40.len(), "every such parameter is compared");
    for (symbol, value, percent) in known {
        let (_, names) = TX40
            .iter()
            .find(|(name, _)| name == symbol)
            .unwrap_or_else(|| panic!("{symbol} has a counterpart"));
        let sum: f64 = names.iter().map(|name| found[*name]).sum();
        assert_within(symbol, sum, *value, (3.0 * percent / 100.0).max(0.03));
    }
}

const EMPS: &str = r#"<robot name="emps">
  <link name="base"/>
  <link name="carriage"/>
  <joint name="axis" type="prismatic">
    <parent link="base"/>
    <child link="carriage"/>
    <axis xyz="1 0 0"/>
  </joint>
</robot>
"#;

#[test]
fn emps_matches_published_parameters() {
    /// N/V.
    const FORCE_CONSTANT: f64 = 35.150_651_88;
    /// N.
    const RESIDUAL: f64 = 1.66;
    let Some(data) = common::data_dir() else {
        return;
    };
    let result = fit(&data, include_str!("real_recordings/emps.toml"), Some(EMPS));
    let found = values(&result);
    assert_within("M", found["carriage.mass"], 95.1089, 0.02);
    let offset = found["axis.torque_offset.offset"];
    assert_within("offset", offset, -3.1648, 0.02);
    assert_within("Fv", found["axis.viscous_friction.Fv"], 203.5034, 0.06);
    assert_within("Fc", found["axis.coulomb_friction.Fc"], 20.3935, 0.06);
    let residual = figures(&result, "rmse_train")[0] * FORCE_CONSTANT;
    eprintln!("EMPS residual: {residual:.4} N");
    assert!(residual <= RESIDUAL, "{residual} N");
}

/// The problem of the LWR4+ with other recordings and another estimator.
fn lwr4(data: &Path, train: &[u8], validation: u8, estimator: &str) -> Vec<f64> {
    let file = |number: &u8| format!("\"{{data}}/lwr4/measurements_{number}.csv\"");
    let train: Vec<String> = train.iter().map(file).collect();
    let problem = include_str!("real_recordings/lwr4.toml")
        .replace("{train}", &train.join(", "))
        .replace("{validation}", &file(&validation))
        .replace("{estimator}", estimator);
    figures(&fit(data, &problem, None), "rmse_validation")
}

#[test]
fn lwr4_held_out_errors_of_the_same_motion_reach_those_by_hand() {
    const BARS: [f64; 7] = [0.22, 0.27, 0.24, 0.19, 0.25, 0.19, 0.13];
    let Some(data) = common::data_dir() else {
        return;
    };
    let held_out = lwr4(&data, &[1], 2, "ols");
    assert_at_most("LWR4+, 1 to 2", &held_out, &BARS);
}

#[test]
fn lwr4_held_out_errors_of_another_motion_reach_those_by_hand() {
    const BARS: [f64; 7] = [0.37, 0.28, 0.28, 0.25, 0.25, 0.19, 0.19];
    let Some(data) = common::data_dir() else {
        return;
    };
    let held_out = lwr4(&data, &[2, 3], 1, "wls");
    assert_at_most("LWR4+, 2 and 3 to 1", &held_out, &BARS);
}
