//! Columns with factors, and columns in two files.

use crate::recording::channels::column_map::{Column, ColumnMap, Factors};
use crate::recording::channels::columns::{RecordedJoint, read};
use crate::recording::channels::samples::{Commanded, SignalKind};
use crate::recording::formats::reading::Reading;
use crate::recording::join::separate_encoder::{EncoderFiles, read_with_separate_encoder};
use crate::recording::tests::{joints, rows, write};

#[test]
fn every_kind_of_column_has_its_factor() {
    let header = "t,q1,q2,dq1,dq2,ddq1,ddq2,tau1,tau2";
    let (_folder, path) = write("a.csv", rows(header, ',').as_bytes());
    let scaled = |name: &str, factor: f64| {
        let mut column = Column::from(name);
        column.factors = Factors::Same(factor);
        Some(column)
    };
    let map = ColumnMap {
        time: scaled("t", 0.5),
        position: scaled("q{n}", 2.0),
        velocity: scaled("dq{n}", 3.0),
        acceleration: scaled("ddq{n}", 4.0),
        torque: scaled("tau{n}", 5.0),
        ..ColumnMap::default()
    };
    let joints = RecordedJoint::all(&joints());
    let found = read(&path, &map, &joints, SignalKind::Torque).unwrap();
    assert_eq!(found.time.unwrap()[1], 0.5);
    assert_eq!(found.position[1][1], 2.0 * 201.0);
    assert_eq!(found.velocity.unwrap()[1][1], 3.0 * 401.0);
    assert_eq!(found.acceleration.unwrap()[1][1], 4.0 * 601.0);
    assert_eq!(found.signal[1][1], 5.0 * 801.0);
}

/// A parabola goes on where a sensor of its own left a sample out.
#[test]
fn samples_that_a_sensor_left_out_are_none_of_its_spline() {
    let rows = |header: &str, of: &dyn Fn(usize) -> String| {
        let rows: String = (0..200).map(|k| format!("{k},{}\n", of(k))).collect();
        format!("{header}\n{rows}")
    };
    let square = |k: usize| match k {
        100 => ",".to_string(),
        k => format!("{},{}", k * k, 2 * k),
    };
    let (_one, signal) = write(
        "a.csv",
        rows("t,tau1,tau2", &|_| "1,2".to_string()).as_bytes(),
    );
    let (_two, sensor) = write("b.csv", rows("t,q1,q2", &square).as_bytes());
    let joints = RecordedJoint::all(&joints());
    let files = EncoderFiles {
        signal: &signal,
        positions: &sensor,
    };
    let (map, reading) = (ColumnMap::default(), Reading::default());
    let found = read_with_separate_encoder(files, &map, &joints, SignalKind::Torque, &reading);
    let found = found.unwrap();
    assert!((found.position[0][100] - 10_000.0).abs() < 1e-3);
    assert!((found.position[1][100] - 200.0).abs() < 1e-3);
}

/// Commanded speeds and torques are behind the commanded positions where a file has them under their usual names, or where
/// they are named; they are no signal of their own.
#[test]
fn commands_beside_the_position_are_read_where_there_are_any() {
    let header = "t,q1,q2,q_cmd_1,q_cmd_2,dq_cmd_1,dq_cmd_2,tau_ff_1,tau_ff_2,x1,x2";
    let (_folder, path) = write("a.csv", rows(header, ',').as_bytes());
    let joints = RecordedJoint::all(&joints());
    let signal = |map: &ColumnMap| {
        let found = read(&path, map, &joints, SignalKind::PositionCommand).unwrap();
        let first: Vec<f64> = found.signal.iter().map(|series| series[0]).collect();
        (found.commanded, first)
    };
    let all = Commanded {
        velocity: true,
        feed_forward: true,
    };
    let usual = [300.0, 400.0, 500.0, 600.0, 700.0, 800.0];
    assert_eq!(signal(&ColumnMap::default()), (all, usual.to_vec()));
    let mut other = Column::from("x{n}");
    other.factors = Factors::Same(2.0);
    let named = ColumnMap {
        command: Some(Column::from("q_cmd_{n}")),
        velocity_command: Some(other),
        ..ColumnMap::default()
    };
    let speeds = Commanded {
        velocity: true,
        feed_forward: false,
    };
    let expected = vec![300.0, 400.0, 1800.0, 2000.0];
    assert_eq!(signal(&named), (speeds, expected));
    let position_alone = ColumnMap {
        command: Some(Column::from("q_cmd_{n}")),
        ..ColumnMap::default()
    };
    let expected = (Commanded::default(), vec![300.0, 400.0]);
    assert_eq!(signal(&position_alone), expected);
}

#[test]
fn a_file_without_commands_beside_the_position_has_none() {
    let header = "t,q1,q2,q_cmd_1,q_cmd_2,dq_cmd_1";
    let (_folder, path) = write("a.csv", rows(header, ',').as_bytes());
    let joints = RecordedJoint::all(&joints());
    let map = ColumnMap::default();
    let found = read(&path, &map, &joints, SignalKind::PositionCommand).unwrap();
    assert_eq!(found.commanded, Commanded::default());
    assert_eq!(found.signal.len(), 2);
}
