//! Recordings that other programs wrote: one table, whatever the file. `tests/data/recordings/make.py`
//! writes them and states the table.

use std::path::{Path, PathBuf};

use super::{numbered, published};
use crate::fault::Fault;
use crate::recording::channels::column_map::ColumnMap;
use crate::recording::channels::columns::{RecordedJoint, read};
use crate::recording::channels::samples::{Recording, SignalKind};
use crate::recording::error::RecordingError;
use crate::recording::formats::format::format_of;
use crate::recording::formats::reading::Reading;

const SAMPLES: usize = 40;

fn written(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/recordings");
    folder.join(name)
}

fn joints() -> Vec<RecordedJoint> {
    RecordedJoint::all(&["shoulder".into(), "elbow".into()])
}

fn read_with(name: &str, map: &ColumnMap) -> Result<Recording, RecordingError> {
    read(&written(name), map, &joints(), SignalKind::Current)
}

fn map(time: &str, position: &str, velocity: &str, current: &str) -> ColumnMap {
    ColumnMap {
        time: Some(time.into()),
        position: Some(position.into()),
        velocity: Some(velocity.into()),
        current: Some(current.into()),
        ..ColumnMap::default()
    }
}

/// Compares with the table of the script; numbers are exact in binary, times to the nanosecond in
/// which a bag counts.
fn is_the_table(name: &str, recording: &Recording, current_scale: f64) {
    let time = recording.time.as_ref().unwrap();
    let velocity = recording.velocity.as_ref().unwrap();
    assert_eq!(time.len(), SAMPLES, "{name}");
    for k in 0..SAMPLES {
        let sample = k as f64;
        assert!((time[k] - sample / 100.0).abs() < 1e-9, "{name}: t[{k}]");
        for j in 0..2 {
            let joint = j as f64;
            let position = (joint + 1.0) * sample / 64.0;
            assert_eq!(recording.position[j][k], position, "{name}: {j} {k}");
            let speed = (joint + 1.0) / 2.0 + sample / 128.0;
            assert_eq!(velocity[j][k], speed, "{name}: {j} {k}");
            let current = (k % 7) as f64 - 3.0 + joint / 4.0;
            let found = recording.signal[j][k] / current_scale;
            assert_eq!(found, current, "{name}: {j} {k}");
        }
    }
}

#[test]
fn recovers_known_truth_from_files_of_other_programs_without_a_map() {
    let names = [
        "plain.npz",
        "plain.mat",
        "none.parquet",
        "snappy.parquet",
        "gzip.parquet",
        "lz4.parquet",
        "zstd.parquet",
        "brotli.parquet",
        "typed.parquet",
        "plain.bag",
        "bz2.bag",
        "lz4.bag",
        "plain.db3",
        "messages.db3",
        "plain.mcap",
        "storage.mcap",
        "lz4.mcap",
        "zstd.mcap",
        "unstamped.mcap",
    ];
    for name in names {
        match read_with(name, &ColumnMap::default()) {
            Ok(recording) => is_the_table(name, &recording, 1.0),
            Err(error) => panic!("{name}: {error}"),
        }
    }
}

#[test]
fn recovers_known_truth_whatever_the_element_type_byte_order_and_storage() {
    // The currents of these two are integers, four times as large.
    let recording = read_with("deflated.npz", &ColumnMap::default()).unwrap();
    is_the_table("deflated.npz", &recording, 4.0);
    let names = map("run.t", "run.q{n}", "run.dq{n}", "run.i{n}");
    let recording = read_with("structure.mat", &names).unwrap();
    is_the_table("structure.mat", &recording, 4.0);
}

#[test]
fn joint_states_of_one_of_several_topics_are_chosen_by_their_columns() {
    let topic = |name: &str| {
        let of = |column: &str| format!("/{name}/joint_states:{column}");
        map(
            &of("t"),
            &of("position_{joint}"),
            &of("velocity_{joint}"),
            &of("effort_{joint}"),
        )
    };
    for name in ["left", "right"] {
        let recording = read_with("two_topics.mcap", &topic(name)).unwrap();
        is_the_table("two_topics.mcap", &recording, 1.0);
    }
    let mut mixed = topic("left");
    mixed.current = topic("right").current;
    let error = read_with("two_topics.mcap", &mixed).unwrap_err();
    assert_eq!(error.describe().code, "two-topics");
}

#[test]
fn effort_serves_as_torque_or_current_as_the_signal_says() {
    let path = written("plain.bag");
    let read = |kind| read(&path, &ColumnMap::default(), &joints(), kind).unwrap();
    let (torque, current) = (read(SignalKind::Torque), read(SignalKind::Current));
    assert_eq!(torque.signal, current.signal);
}

#[test]
fn a_column_that_is_absent_is_named_with_what_the_file_holds() {
    let cases = [
        ("plain.npz", "q3", "q1, q2, "),
        ("structure.mat", "run.q3", "run.q1, run.q2"),
        ("typed.parquet", "elbow_speed", "elbow_position"),
        ("plain.bag", "position_wrist", "t, log_t, position_elbow"),
        ("plain.mcap", "position_wrist", "position_finger"),
        ("two_topics.mcap", "position_elbow", "/left/joint_states:t"),
    ];
    for (name, absent, listed) in cases {
        let joint = RecordedJoint::all(&["elbow".into()]);
        let names = map("t", absent, "dq1", "i1");
        let names = ColumnMap {
            time: None,
            ..names
        };
        let error = read(&written(name), &names, &joint, SignalKind::Current).unwrap_err();
        let words = error.describe();
        assert_eq!(words.code, "missing-column", "{name}: {error}");
        assert!(words.remedy.contains(listed), "{name}: {error}");
    }
}

/// Texts, scalars and arrays of more sides are not columns.
#[test]
fn only_channels_are_columns() {
    let columns = |name: &str| {
        let path = written(name);
        (format_of(&path).unwrap().columns)(&path, &Reading::default()).unwrap()
    };
    let arrays = ["t", "q1", "q2", "dq1", "dq2", "i1", "i2"];
    assert_eq!(columns("deflated.npz"), arrays);
    let fields = arrays.map(|name| format!("run.{name}"));
    assert_eq!(columns("structure.mat"), fields);
    let typed = columns("typed.parquet");
    assert!(typed.ends_with(&["list1".to_string(), "list2".to_string()]));
    assert!(!typed.iter().any(|name| name == "label"));
}

#[test]
fn published_measurements_are_the_same_in_their_original_files() {
    let Some(file) = published("data/lwr4/measurements_1.npz") else {
        return;
    };
    let names = ColumnMap {
        torque: Some("torques{n}".into()),
        current: None,
        ..map("times", "positions{n}", "velocities{n}", "")
    };
    let joints = RecordedJoint::all(&numbered(7));
    let original = read(&file, &names, &joints, SignalKind::Torque).unwrap();
    let text = file.with_extension("csv");
    let copy = read(&text, &ColumnMap::default(), &joints, SignalKind::Torque).unwrap();
    agree(&original, &copy);
}

#[test]
fn published_matlab_files_are_the_same_as_their_copies_in_text() {
    let pairs = [
        ("DATA_EMPS", "tracking"),
        ("DATA_EMPS_PULSES", "tracking_with_pulses"),
    ];
    for (original, copy) in pairs {
        let Some(file) = published(&format!("data/emps/{original}.mat")) else {
            return;
        };
        let joints = RecordedJoint::all(&numbered(1));
        let of = |time: &str, position: &str, torque: &str| ColumnMap {
            time: Some(time.into()),
            position: Some(position.into()),
            torque: Some(torque.into()),
            ..ColumnMap::default()
        };
        let names = of("t", "qm", "vir");
        let original = read(&file, &names, &joints, SignalKind::Torque).unwrap();
        let text = file.with_file_name(format!("{copy}.csv"));
        let names = of("t", "q1", "voltage1");
        let copy = read(&text, &names, &joints, SignalKind::Torque).unwrap();
        agree(&original, &copy);
    }
}

/// The copies in text keep seven significant digits, of times since the start: half a unit of the seventh
/// is at most 5e-7 of the number.
fn agree(original: &Recording, copy: &Recording) {
    let series = |r: &Recording| {
        let time = r.time.clone().unwrap();
        let since = time.iter().map(|t| t - time[0]).collect();
        let mut series: Vec<Vec<f64>> = vec![since];
        series.extend(r.position.iter().chain(&r.signal).cloned());
        series
    };
    for (a, b) in series(original).iter().zip(&series(copy)) {
        assert_eq!(a.len(), b.len());
        let largest = a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (x, y) in a.iter().zip(b) {
            assert!((x - y).abs() <= 5e-7 * largest, "{x} {y}");
        }
    }
}

#[test]
fn a_bag_without_joint_states_says_what_it_holds() {
    let Some(file) = published("data/ros/pr2_shoulder_pan.bag") else {
        return;
    };
    let error = read(&file, &ColumnMap::default(), &joints(), SignalKind::Torque).unwrap_err();
    let words = error.describe();
    assert_eq!(words.code, "no-joint-state");
    let held = "/di_controller/data (dynamics_identification/Data)";
    assert!(words.remedy.contains(held), "{}", words.remedy);
}
