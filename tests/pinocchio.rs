//! Kinematics, torques, base reactions, regressors and derivatives against Pinocchio.
//!
//! `tests/reference/pinocchio.py` writes the reference values of the robots of the repository. For robots
//! that are not shipped it prints them on the spot if `EXID_PYTHON` names a Python with Pinocchio.

mod common;

use exid::robot::derivatives::Derivatives;
use exid::robot::newton_euler::NewtonEuler;
use exid::robot::regressor::Rows;
use exid::robot::sample_regressor::SampleRegressor;
use exid::robot::tree::Tree;
use exid::robot::{mdh, urdf};
use nalgebra::{DMatrix, DVector};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Largest difference, relative to the largest entry of the quantity: both sides round at 1e-16 in
/// chains of some thousand operations, and the reference keeps 13 digits.
const AGREEMENT: f64 = 1e-10;

#[derive(Deserialize)]
struct Document {
    generator: String,
    version: String,
    robots: Vec<Robot>,
}

/// Values of one robot, joints in the order of `joints`.
#[derive(Deserialize)]
struct Robot {
    file: PathBuf,
    gravity: [f64; 3],
    joints: Vec<String>,
    links: Vec<String>,
    states: Vec<State>,
}

#[derive(Deserialize)]
struct State {
    q: Vec<f64>,
    dq: Vec<f64>,
    ddq: Vec<f64>,
    torque: Vec<f64>,
    base_reaction: Vec<f64>,
    mass: Vec<Vec<f64>>,
    torque_by_position: Vec<Vec<f64>>,
    torque_by_velocity: Vec<Vec<f64>>,
    parameters: Option<Vec<f64>>,
    torque_regressor: Option<Vec<Vec<f64>>>,
    base_regressor: Option<Vec<Vec<f64>>>,
    /// Position and rotation (row after row) by name of the link.
    placements: Option<BTreeMap<String, Vec<f64>>>,
}

/// The largest difference of each quantity, relative to its largest entry.
#[derive(Default)]
struct Differences(BTreeMap<&'static str, f64>);

impl Differences {
    fn add(&mut self, quantity: &'static str, got: &DMatrix<f64>, expected: &DMatrix<f64>) {
        assert_eq!(got.shape(), expected.shape(), "{quantity}");
        let scale = expected.amax();
        let difference = (got - expected).amax() / if scale > 0.0 { scale } else { 1.0 };
        let worst = self.0.entry(quantity).or_default();
        // f64::max passes over what is not a number.
        assert!(!difference.is_nan(), "{quantity}");
        *worst = worst.max(difference);
    }

    fn assert_within(&self, bound: f64, robot: &Path) {
        for (quantity, difference) in &self.0 {
            assert!(
                *difference <= bound,
                "{}: {quantity} differs by {difference:.1e}",
                robot.display()
            );
        }
    }
}

impl fmt::Display for Differences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (quantity, difference) in &self.0 {
            write!(f, " {quantity} {difference:.1e}")?;
        }
        Ok(())
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(file: &Path) -> Tree {
    let read = match file.extension().and_then(|extension| extension.to_str()) {
        Some("toml") => mdh::read(file),
        _ => urdf::read(file),
    };
    read.unwrap_or_else(|fault| panic!("{fault}"))
}

fn matrix(rows: &[Vec<f64>]) -> DMatrix<f64> {
    let columns = rows.first().map_or(0, Vec::len);
    DMatrix::from_fn(rows.len(), columns, |row, column| rows[row][column])
}

fn column(values: &[f64]) -> DMatrix<f64> {
    DMatrix::from_column_slice(values.len(), 1, values)
}

fn regressor(tree: &Tree, rows: Rows, state: [&[f64]; 3]) -> DMatrix<f64> {
    let mut y = DMatrix::zeros(rows.count(tree.len()), 10 * tree.len());
    SampleRegressor::new(tree, rows).fill(tree, state, &mut y);
    y
}

fn torque(tree: &Tree, parameters: &[f64], state: [&[f64]; 3]) -> Vec<f64> {
    let mut out = vec![0.0; tree.len()];
    NewtonEuler::new(tree).torque(tree, parameters, state, &mut out);
    out
}

/// Compares one robot with its reference, joint by joint and link by link of the same name.
fn compare(robot: &Robot) -> Differences {
    let tree = read(&root().join(&robot.file)).with_gravity(robot.gravity);
    assert_eq!(tree.len(), robot.joints.len(), "{}", robot.file.display());
    let order: Vec<usize> = (tree.joints().iter())
        .map(|joint| robot.joints.iter().position(|name| *name == joint.name))
        .map(|at| at.expect("every joint is one of the reference's"))
        .collect();
    for (joint, &at) in tree.joints().iter().zip(&order) {
        assert_eq!(joint.link, robot.links[at]);
    }
    let mut differences = Differences::default();
    for state in &robot.states {
        compare_state(&tree, &order, state, &mut differences);
    }
    differences
}

fn compare_state(tree: &Tree, order: &[usize], reference: &State, differences: &mut Differences) {
    let pick = |values: &[f64]| order.iter().map(|&at| values[at]).collect::<Vec<f64>>();
    let square = |rows: &[Vec<f64>]| matrix(rows).select_rows(order).select_columns(order);
    let bodies: Vec<usize> = order.iter().flat_map(|&at| 10 * at..10 * at + 10).collect();
    let (q, dq, ddq) = (
        pick(&reference.q),
        pick(&reference.dq),
        pick(&reference.ddq),
    );
    let state = [&q[..], &dq, &ddq];
    let parameters = tree.parameters();
    let pi = DVector::from_column_slice(&parameters);
    let expected_torque = column(&pick(&reference.torque));

    let got = column(&torque(tree, &parameters, state));
    differences.add("torque", &got, &expected_torque);
    let got = regressor(tree, Rows::Base, state) * &pi;
    let got = column(got.as_slice());
    differences.add("base_reaction", &got, &column(&reference.base_reaction));
    let mut derivatives = Derivatives::new(tree);
    derivatives.evaluate(tree, &parameters, state);
    let n = tree.len();
    let got = DMatrix::from_fn(n, 1, |j, _| derivatives.torque(j));
    differences.add("torque_of_derivatives", &got, &expected_torque);
    for (order, name, expected) in [
        (0, "torque_by_position", &reference.torque_by_position),
        (1, "torque_by_velocity", &reference.torque_by_velocity),
        (2, "mass", &reference.mass),
    ] {
        let got = DMatrix::from_fn(n, n, |row, j| derivatives.slope(order, row, j));
        differences.add(name, &got, &square(expected));
    }
    if let Some(expected) = &reference.parameters {
        let expected = column(expected).select_rows(&bodies);
        differences.add("parameters", &column(&parameters), &expected);
    }
    if let Some(expected) = &reference.torque_regressor {
        let expected = matrix(expected).select_rows(order).select_columns(&bodies);
        let got = regressor(tree, Rows::Torque, state);
        differences.add("torque_regressor", &got, &expected);
    }
    if let Some(expected) = &reference.base_regressor {
        let expected = matrix(expected).select_columns(&bodies);
        differences.add(
            "base_regressor",
            &regressor(tree, Rows::Base, state),
            &expected,
        );
    }
    for (link, expected) in reference.placements.iter().flatten() {
        differences.add("placements", &placement(tree, &q, link), &column(expected));
    }
}

/// Position and rotation, row after row, of a link or fixed frame in the base frame.
fn placement(tree: &Tree, q: &[f64], name: &str) -> DMatrix<f64> {
    let (joint, fixed) = tree
        .frame(name)
        .expect("a link of the reference is a frame");
    let pose = match joint {
        Some(joint) => tree.forward_kinematics(q)[joint] * fixed,
        None => fixed,
    };
    let rotation = pose.rotation.to_rotation_matrix().matrix().transpose();
    let values: Vec<f64> = (pose.translation.vector.iter())
        .chain(rotation.iter())
        .copied()
        .collect();
    column(&values)
}

#[test]
fn matches_pinocchio_on_the_robots_of_the_repository() {
    let text = include_str!("reference/pinocchio.json");
    let document: Document = serde_json::from_str(text).unwrap();
    println!("reference: {} {}", document.generator, document.version);
    assert!(document.robots.len() >= 6);
    for robot in &document.robots {
        let differences = compare(robot);
        println!("{}:{differences}", robot.file.display());
        assert_eq!(differences.0.len(), 10, "every quantity has a reference");
        differences.assert_within(AGREEMENT, &robot.file);
    }
}

/// The robot files of the recordings and trials, in the order of their paths.
fn robot_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for room in ["data", "trials"] {
        for robot in folder.join(room).read_dir().into_iter().flatten() {
            for file in robot.unwrap().path().read_dir().into_iter().flatten() {
                files.push(file.unwrap().path());
            }
        }
    }
    files.retain(|file| {
        file.extension()
            .is_some_and(|extension| extension == "urdf")
    });
    files.sort();
    files
}

/// A state without symmetry: joint k at `sin(k + 1)`, and so on.
fn generic_state(n: usize) -> [Vec<f64>; 3] {
    let series = |pulsation: f64, size: f64| {
        let value = |k: usize| size * (pulsation * (k + 1) as f64).sin();
        (0..n).map(value).collect::<Vec<f64>>()
    };
    [series(1.0, 1.0), series(2.3, 2.0), series(3.7, 8.0)]
}

#[test]
fn invariant_regressors_are_differences_of_torque_in_the_parameters() {
    let Some(folder) = common::data_dir() else {
        return;
    };
    for file in robot_files(&folder) {
        let tree = read(&file);
        let [q, dq, ddq] = generic_state(tree.len());
        let state = [&q[..], &dq, &ddq];
        let parameters = tree.parameters();
        let y = regressor(&tree, Rows::Torque, state);
        let mut differences = Differences::default();
        let got = &y * DVector::from_column_slice(&parameters);
        let expected = column(&torque(&tree, &parameters, state));
        differences.add("torque", &column(got.as_slice()), &expected);
        // The torque is linear in the parameters: a step of any size gives the column.
        let mut columns = DMatrix::zeros(tree.len(), parameters.len());
        for k in 0..parameters.len() {
            let mut stepped = parameters.clone();
            stepped[k] += 1.0;
            let after = column(&torque(&tree, &stepped, state));
            columns
                .column_mut(k)
                .copy_from(&(after - &expected).column(0));
        }
        differences.add("regressor", &y, &columns);
        differences.assert_within(AGREEMENT, &file);
    }
}

#[test]
fn matches_pinocchio_on_the_robots_of_recordings_and_trials() {
    let Some(folder) = common::data_dir() else {
        return;
    };
    let Some(python) = std::env::var_os("EXID_PYTHON") else {
        common::skip("EXID_PYTHON does not name a Python with Pinocchio (package pin)");
        return;
    };
    let output = Command::new(python)
        .arg(root().join("tests/reference/pinocchio.py"))
        .arg("--compare")
        .args(robot_files(&folder))
        .output()
        .unwrap();
    let log = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{log}");
    let document: Document = serde_json::from_slice(&output.stdout).unwrap();
    println!("reference: {} {}", document.generator, document.version);
    assert_eq!(document.robots.len(), robot_files(&folder).len());
    for robot in &document.robots {
        let differences = compare(robot);
        println!("{}:{differences}", robot.file.display());
        differences.assert_within(AGREEMENT, &robot.file);
    }
}
