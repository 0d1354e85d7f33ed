//! Columns with factors, and columns in two files.

use crate::recording::apart::read_apart;
use crate::recording::column_map::{Column, ColumnMap, Factors};
use crate::recording::columns::{RecordedJoint, read};
use crate::recording::reading::Reading;
use crate::recording::samples::SignalKind;
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
    let read = (SignalKind::Torque, &Reading::default());
    let found = read_apart((&signal, &sensor), &ColumnMap::default(), &joints, read).unwrap();
    assert!((found.position[0][100] - 10_000.0).abs() < 1e-3);
    assert!((found.position[1][100] - 200.0).abs() < 1e-3);
}
