//! Files that other programs wrote, read as recordings: NumPy, MATLAB and ROS. The files are not shipped; without
//! them these tests say that they skip.

mod common;

use exid::fault::Fault;
use exid::recording::column_map::ColumnMap;
use exid::recording::columns::{RecordedJoint, read};
use exid::recording::samples::{Recording, SignalKind};
use std::path::Path;

/// Joints that are told apart by their numbers.
fn joints(count: usize) -> Vec<RecordedJoint> {
    let names: Vec<String> = (1..=count).map(|n| format!("joint{n}")).collect();
    RecordedJoint::all(&names)
}

/// A map that names time, position and torque.
fn map([time, position, torque]: [&str; 3]) -> ColumnMap {
    ColumnMap {
        time: Some(time.into()),
        position: Some(position.into()),
        torque: Some(torque.into()),
        ..ColumnMap::default()
    }
}

fn recording(path: &Path, columns: [&str; 3], count: usize) -> Recording {
    read(path, &map(columns), &joints(count), SignalKind::Torque).unwrap_or_else(|e| panic!("{e}"))
}

/// Largest difference of two sets of series of the same lengths.
fn apart(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(b);
    let of = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        assert_eq!(a.len(), b.len());
        let each = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        each.fold(0.0, f64::max)
    };
    pairs.map(of).fold(0.0, f64::max)
}

/// Half of the last digit of the CSV files beside the originals, of six decimals.
const ROUNDING: f64 = 0.51e-6;

/// Half of the last of seven significant digits, as a share of the number: the table beside the archive has so many.
const SEVEN_DIGITS: f64 = 0.51e-6;

#[test]
fn numpy_archive_holds_what_its_table_holds() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let folder = data.join("data/lwr4");
    let original = recording(
        &folder.join("measurements_1.npz"),
        ["times", "positions{n}", "torques{n}"],
        7,
    );
    let table = recording(
        &folder.join("measurements_1.csv"),
        ["t", "q{n}", "tau{n}"],
        7,
    );
    let first = original.position[0].len() - table.position[0].len();
    for (whole, written) in [
        (&original.position, &table.position),
        (&original.signal, &table.signal),
    ] {
        assert_eq!(whole.len(), written.len());
        for (whole, written) in whole.iter().zip(written) {
            let mut pairs = whole[first..].iter().zip(written);
            assert!(pairs.all(|(a, b)| (a - b).abs() <= SEVEN_DIGITS * b.abs()));
        }
    }
}

#[test]
fn matlab_files_hold_what_their_tables_hold() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let folder = data.join("data/emps");
    for (file, table) in [
        ("DATA_EMPS.mat", "tracking.csv"),
        ("DATA_EMPS_PULSES.mat", "tracking_with_pulses.csv"),
    ] {
        let original = recording(&folder.join(file), ["t", "qm", "vir"], 1);
        let table = recording(&folder.join(table), ["t", "q1", "voltage1"], 1);
        assert!(
            apart(&original.position, &table.position) <= ROUNDING,
            "{file}"
        );
        assert!(apart(&original.signal, &table.signal) <= ROUNDING, "{file}");
    }
}

/// The bag holds messages of a type of its own, and no joint states: the error says what it holds.
#[test]
fn a_bag_without_joint_states_is_refused_with_what_it_holds() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let bag = data.join("data/ros/pr2_shoulder_pan.bag");
    let error = read(&bag, &ColumnMap::default(), &joints(1), SignalKind::Torque).unwrap_err();
    let description = error.describe();
    assert_eq!(description.code, "no-joint-state");
    let words = error.to_string();
    assert!(words.contains("/di_controller/data"), "{words}");
}
