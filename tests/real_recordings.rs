//! Recordings of real robots: errors on runs that were held out, and parameters that others have
//! published for them. The recordings are not shipped; without them these tests say that they skip.

mod common;

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// With settings that were chosen by hand.
const UR10E: &str = include_str!("real_recordings/ur10e.toml");

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
    result(folder.path(), "fit")
}

/// What a command says of the problem in a folder.
fn result(folder: &Path, verb: &str) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder)
        .args([verb, "problem.toml", "--json", "--out", "out"])
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
    let held_out = |problem: &str| -> Vec<f64> {
        let result = fit(&data, problem, None);
        (figures(&result, "rmse_validation").iter())
            .zip(TORQUE_CONSTANT)
            .map(|(current, constant)| current * constant)
            .collect()
    };
    let weighted = held_out(UR10E);
    assert_at_most("UR10e, 30 s to 40 s", &weighted, &BARS);
    let likely = held_out(&UR10E.replace("\"wls\"", "\"maximum_likelihood\""));
    // The covariance across joints tells little of noise that every joint has for itself.
    let bars = weighted.iter().map(|e| 1.01 * e).collect::<Vec<f64>>();
    assert_at_most("the same by maximum likelihood", &likely, &bars);
}

/// Errors of the UR10e by a problem file without its known values, with one more effect of every joint.
fn ur10e_with(data: &Path, problem: &str, effect: &str) -> Vec<f64> {
    let (before, values) = problem.split_once("[drive.values]").unwrap();
    let (_, after) = values.split_once("[recordings]").unwrap();
    let before = before.replace("effects = [", &format!("effects = [{effect}"));
    let problem = format!("{before}[recordings]{after}");
    figures(&fit(data, &problem, None), "rmse_validation")
}

/// Errors at most a share of others, joint by joint.
fn assert_shares_at_most(errors: &[f64], others: &[f64], most: f64) {
    let mut pairs = errors.iter().zip(others);
    assert!(pairs.all(|(error, other)| *error <= most * other));
}

/// The fitted motion of a wrist tells nothing of sticking: no row is that slow. What a search makes of it, sizes without a limit and
/// speeds of nothing, ruined the forecast of another motion.
#[test]
fn sticking_that_no_row_shows_is_in_no_forecast() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let (problem, _) = UR10E.split_once("[recordings.differentiation]").unwrap();
    let errors = |more: &str| ur10e_with(&data, problem, more);
    let [without, with] = ["", "\"stribeck_friction\", "].map(errors);
    eprintln!("UR10e without sticking {without:.4?} A, with it {with:.4?} A");
    assert_shares_at_most(&with, &without, 1.1);
}

/// Whether and how fast friction turns over is estimated, and stands in for bristles where these are missing: with them, a robot of
/// which nothing is stated is forecast no worse than where the speed of transition was chosen by hand.
#[test]
fn ur10e_of_which_nothing_is_stated_is_forecast_as_by_hand() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let (problem, _) = UR10E.split_once("[recordings.differentiation]").unwrap();
    let by_hand = figures(&fit(&data, problem, None), "rmse_validation");
    let found = ur10e_with(&data, problem, "\"presliding_hysteresis\", ");
    eprintln!("UR10e by hand {by_hand:.4?} A, with nothing stated and bristles {found:.4?} A");
    assert_shares_at_most(&found, &by_hand, 1.03);
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

const EMPS: &str = include_str!("real_recordings/emps.urdf");

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

/// Effects that a diagnosis finds in EMPS where the declared model has no friction at all, first half fitted and second
/// held out.
#[test]
fn emps_without_friction_gets_back_what_is_fitted_by_hand() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(data.join("data/emps/tracking.csv")).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    let (first, second) = rows.split_at(rows.len() / 2);
    for (name, rows) in [("first", first), ("second", second)] {
        let file = folder.path().join(format!("emps_{name}.csv"));
        fs::write(file, format!("{header}\n{}\n", rows.join("\n"))).unwrap();
    }
    let problem = include_str!("../examples/real_proofs/emps_frictionless.toml");
    fs::write(folder.path().join("problem.toml"), problem).unwrap();
    fs::write(folder.path().join("robot.urdf"), EMPS).unwrap();
    let diagnosis = result(folder.path(), "diagnose");
    let findings = diagnosis["findings"].as_array().unwrap();
    let found: Vec<&str> = findings
        .iter()
        .map(|f| f["effect"].as_str().unwrap())
        .collect();
    eprintln!("EMPS without friction: {found:?}");
    let by_hand = [
        "coulomb_friction",
        "viscous_friction",
        "asymmetric_friction",
    ];
    assert_eq!(found[..3], by_hand);
}

/// Effort limits of the LWR4+ in its URDF, N·m.
const LWR4_EFFORT: [f64; 7] = [176.0, 176.0, 100.0, 100.0, 100.0, 38.0, 38.0];

/// The problem of the LWR4+: one setting, whichever recordings are held out.
fn lwr4_problem(train: &[u8], validation: u8) -> String {
    let file = |number: &u8| format!("\"{{data}}/lwr4/measurements_{number}.csv\"");
    let train: Vec<String> = train.iter().map(file).collect();
    include_str!("real_recordings/lwr4.toml")
        .replace("{train}", &train.join(", "))
        .replace("{validation}", &file(&validation))
}

/// Held-out errors of the LWR4+, N·m.
fn lwr4(data: &Path, train: &[u8], validation: u8) -> Vec<f64> {
    figures(
        &fit(data, &lwr4_problem(train, validation), None),
        "rmse_validation",
    )
}

/// Errors in per cent of the effort limits, beside those published for this robot. The source does not
/// say how it pools joints: the mean over joints and the root mean square are both printed.
fn print_normalised(what: &str, errors: &[f64]) {
    const PUBLISHED: &str = "0.176 to 0.211 % published for 1 to 2";
    let shares: Vec<f64> = (errors.iter().zip(LWR4_EFFORT))
        .map(|(error, limit)| 100.0 * error / limit)
        .collect();
    let count = shares.len() as f64;
    let mean = shares.iter().sum::<f64>() / count;
    let square = shares.iter().map(|s| s * s).sum::<f64>() / count;
    eprintln!(
        "{what}, of the effort limits: {shares:.3?} %, mean {mean:.3} %, root mean square {:.3} %; {PUBLISHED}",
        square.sqrt()
    );
}

#[test]
fn lwr4_held_out_errors_of_the_same_motion_reach_those_by_hand() {
    const BARS: [f64; 7] = [0.22, 0.27, 0.24, 0.19, 0.25, 0.19, 0.13];
    let Some(data) = common::data_dir() else {
        return;
    };
    let held_out = lwr4(&data, &[1], 2);
    print_normalised("LWR4+, 1 to 2", &held_out);
    assert_at_most("LWR4+, 1 to 2", &held_out, &BARS);
}

#[test]
fn lwr4_held_out_errors_of_another_motion_reach_those_by_hand() {
    const BARS: [f64; 7] = [0.37, 0.28, 0.28, 0.25, 0.25, 0.19, 0.19];
    let Some(data) = common::data_dir() else {
        return;
    };
    let held_out = lwr4(&data, &[2, 3], 1);
    print_normalised("LWR4+, 2 and 3 to 1", &held_out);
    assert_at_most("LWR4+, 2 and 3 to 1", &held_out, &BARS);
}

/// A feasible fit: converged, with every link possible by the stated margin.
fn feasible(data: &Path, problem: &str) -> Value {
    let problem = problem.replace("\"wls\"", "\"feasible\"");
    let result = fit(data, &problem, None);
    assert_eq!(result["feasible"], Value::Bool(true));
    assert_eq!(result["solver"]["converged"], Value::Bool(true));
    let feasibility = &result["feasibility"];
    let number = |value: &Value| value.as_f64().unwrap();
    let margin = number(&feasibility["margin"]);
    let least = number(&feasibility["least_eigenvalue"]);
    assert!(least >= margin * (1.0 - 1e-9), "{least} kg");
    let free = feasibility["unconstrained"].as_array().unwrap();
    let free = free.iter().map(|joint| number(&joint["rmse_validation"]));
    let held_out = figures(&result, "rmse_validation");
    let ratios: Vec<f64> = held_out.iter().zip(free).map(|(e, f)| e / f).collect();
    eprintln!("feasible to unconstrained, held out: {ratios:.3?}");
    eprintln!("at a limit: {}", feasibility["at_limit"]);
    result
}

/// Share by which a held-out error may exceed the one that it is compared with.
const LOSS: f64 = 0.02;

#[test]
fn ur10e_is_possible_at_no_loss() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let result = feasible(&data, UR10E);
    let free = result["feasibility"]["unconstrained"].as_array().unwrap();
    let held_out = figures(&result, "rmse_validation");
    for (error, free) in held_out.iter().zip(free) {
        let bar = (1.0 + LOSS) * free["rmse_validation"].as_f64().unwrap();
        assert!(*error <= bar, "{}: {error} A, bar {bar}", free["joint"]);
    }
}

#[test]
fn lwr4_is_possible_at_the_loss_of_an_independent_solve() {
    // N·m; `tests/reference/lwr4_feasible.py` with Pinocchio 4.1, CVXPY 1.9 and Clarabel 0.11.
    const INDEPENDENT: [f64; 7] = [0.2726, 0.2945, 0.2852, 0.1905, 0.2599, 0.2004, 0.2337];
    let Some(data) = common::data_dir() else {
        return;
    };
    let result = feasible(&data, &lwr4_problem(&[1], 2));
    let held_out = figures(&result, "rmse_validation");
    eprintln!("LWR4+, 1 to 2: {held_out:.4?} N·m, independent {INDEPENDENT:?}");
    for (joint, (error, independent)) in held_out.iter().zip(INDEPENDENT).enumerate() {
        let bar = (1.0 + LOSS) * independent;
        assert!(*error <= bar, "joint {}: {error} N·m, bar {bar}", joint + 1);
    }
}

/// Published mass of the load on the UR10e, kg.
const UR10E_LOAD: f64 = 2.805;

const UR10E_JOINTS: [&str; 6] = [
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
];

/// Fits the runs without load and one with it together; the load's mass with its 95 % interval, kg.
fn ur10e_load(data: &Path, effects: &[&str], (estimator, prior): (&str, &str)) -> (f64, [f64; 2]) {
    ur10e_load_with(data, effects, (estimator, prior), 0.0)
}

/// The same with torque constants of this relative standard deviation.
fn ur10e_load_with(
    data: &Path,
    effects: &[&str],
    (estimator, prior): (&str, &str),
    deviation: f64,
) -> (f64, [f64; 2]) {
    let listed: Vec<String> = effects.iter().map(|e| format!("\"{e}\"")).collect();
    let problem = include_str!("real_recordings/ur10e_load.toml")
        .replace("{effects}", &listed.join(", "))
        .replace("{estimator}", estimator)
        .replace("{prior}", prior)
        .replace("{deviation}", &format!("{deviation:?}"));
    let result = fit(data, &problem, None);
    let parameters = result["parameters"].as_array().unwrap();
    let mass = parameters
        .iter()
        .find(|p| p["name"] == "payload.mass")
        .unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let interval = &mass["ci95"];
    let found = (
        number(&mass["value"]),
        [number(&interval[0]), number(&interval[1])],
    );
    eprintln!(
        "UR10e, {estimator}, {effects:?}: {:.3} kg, {:.3?}",
        found.0, found.1
    );
    found
}

#[test]
fn ur10e_load_is_that_of_a_balance_but_for_the_torque_constants() {
    const USUAL: [&str; 4] = [
        "coulomb_friction",
        "viscous_friction",
        "torque_offset",
        "rotor_inertia",
    ];
    /// Relative standard deviation of torque constants that nobody calibrated.
    const CONSTANT: f64 = 0.05;
    /// Half a 95 % interval in standard deviations.
    const NORMAL_95: f64 = 1.96;
    let Some(data) = common::data_dir() else {
        return;
    };
    let with = |further: &[&'static str]| [&USUAL, further].concat();
    let (mass, [low, high]) = ur10e_load(&data, &USUAL, ("wls", ""));
    assert!((mass / UR10E_LOAD - 1.0).abs() <= 0.12, "{mass} kg");
    let likely = "maximum_likelihood";
    for (effects, estimator) in [
        (USUAL.to_vec(), likely),
        (with(&["asymmetric_friction"]), "wls"),
        (with(&["load_dependent_friction"]), likely),
        (
            vec!["coulomb_friction", "viscous_friction", "rotor_inertia"],
            "wls",
        ),
    ] {
        let (other, _) = ur10e_load(&data, &effects, (estimator, ""));
        assert!(
            (other / mass - 1.0).abs() <= 0.01,
            "{effects:?}: {other} kg"
        );
    }
    // A common gain of all torque constants scales the mass one to one, and no motion tells it.
    let deviation = (high - low) / (2.0 * NORMAL_95);
    let half = NORMAL_95 * deviation.hypot(CONSTANT * mass);
    eprintln!(
        "UR10e: torque constants times {:.4} give {UR10E_LOAD} kg; with {CONSTANT} of them uncertain {:.3} to {:.3} kg",
        UR10E_LOAD / mass,
        mass - half,
        mass + half
    );
    assert!((mass - UR10E_LOAD).abs() <= half, "{mass} kg");
    let (_, [stated_low, stated_high]) = ur10e_load_with(&data, &USUAL, ("wls", ""), CONSTANT);
    assert!((stated_low..stated_high).contains(&UR10E_LOAD));
    // All bodies are estimated: a common error scales the mass one to one.
    assert!((stated_high - stated_low - 2.0 * half).abs() < 0.05 * half);
    let gains: Vec<String> = UR10E_JOINTS
        .iter()
        .map(|joint| {
            format!("\"{joint}.drive_gain.gain\" = {{ value = 1.0, std_dev = {CONSTANT} }}")
        })
        .collect();
    let prior = format!("[fit.prior.values]\n{}", gains.join("\n"));
    // Gains that err each by itself partly average out, so they widen the interval less than a common one.
    let (_, own) = ur10e_load(&data, &with(&["drive_gain"]), ("wls", &prior));
    let width = own[1] - own[0];
    assert!(high - low < width && width < 2.0 * half, "{own:?}");
}
