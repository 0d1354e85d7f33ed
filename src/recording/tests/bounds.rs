//! What is read of a file is bounded, and ends at an interrupt.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::{HEADER, gzip, joints, rows, write};
use crate::fault::Fault;
use crate::recording::channels::column_map::ColumnMap;
use crate::recording::channels::columns::{RecordedJoint, read_within};
use crate::recording::channels::samples::SignalKind;
use crate::recording::formats::reading::Reading;

/// The code of the fault of a file; empty where it is read.
fn code(path: &Path, reading: &Reading) -> &'static str {
    let joints = match path.parent().is_some_and(|p| p.ends_with("recordings")) {
        true => vec!["shoulder".to_string(), "elbow".to_string()],
        false => joints(),
    };
    let joints = RecordedJoint::all(&joints);
    let found = read_within(
        path,
        &ColumnMap::default(),
        &joints,
        SignalKind::Torque,
        reading,
    );
    found.err().map_or("", |fault| fault.describe().code)
}

fn data(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/recordings");
    folder.join(name)
}

const BAGS: [&str; 4] = ["plain.bag", "lz4.bag", "plain.db3", "plain.mcap"];

#[test]
fn rows_beyond_the_limit_are_refused() {
    let few = Reading {
        most_rows: 25,
        ..Reading::default()
    };
    let (_folder, table) = write("a.csv", rows(HEADER, ',').as_bytes());
    assert_eq!(code(&table, &few), "too-many-rows");
    for name in BAGS {
        assert_eq!(code(&data(name), &few), "too-many-rows", "{name}");
    }
}

#[test]
fn a_compressed_file_that_has_no_end_is_refused() {
    let most = Reading {
        most_bytes: 1 << 20,
        ..Reading::default()
    };
    let endless = rows(HEADER, ',') + &"0,0,0,0,0\n".repeat(200_000);
    let (_folder, table) = write("a.csv.gz", &gzip(endless.as_bytes()));
    assert_eq!(code(&table, &most), "too-many-bytes");
    let (_folder, line) = write("b.csv.gz", &gzip(&vec![b'#'; 4 << 20]));
    assert!(["too-many-bytes", "line-too-long"].contains(&code(&line, &most)));
}

#[test]
fn an_interrupt_ends_every_reader() {
    let interrupted = Reading {
        interrupt: Some(Arc::new(AtomicBool::new(true))),
        ..Reading::default()
    };
    let (_folder, table) = write("a.csv", rows(HEADER, ',').as_bytes());
    assert_eq!(code(&table, &interrupted), "interrupted");
    for name in BAGS
        .into_iter()
        .chain(["plain.npz", "plain.mat", "snappy.parquet"])
    {
        assert_eq!(code(&data(name), &interrupted), "interrupted", "{name}");
    }
}

/// SQLite runs a view that names itself without end.
#[test]
fn a_view_in_the_place_of_messages_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("endless.db3");
    let database = rusqlite::Connection::open(&path).unwrap();
    let endless = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT);
        INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState');
        CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n)
        SELECT id, 2 AS topic_id, id AS timestamp, x'00' AS data FROM n;";
    database.execute_batch(endless).unwrap();
    assert_eq!(code(&path, &Reading::default()), "corrupt-file");
}
