//! Recordings as other programs leave them: with comments, in other encodings, with empty cells, lists, objects beside the
//! data. `tests/data/recordings/foreign/make.py` writes them and states the table.

use std::path::{Path, PathBuf};

use crate::fault::Fault;
use crate::recording::channels::column_map::{Column, ColumnMap, ColumnsAt, Factors};
use crate::recording::channels::columns::{RecordedJoint, read};
use crate::recording::channels::samples::{Recording, SignalKind};
use crate::recording::error::RecordingError;

const SAMPLES: usize = 40;

fn path(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/recordings/foreign");
    folder.join(name)
}

fn read_file(name: &str, map: &ColumnMap) -> Result<Recording, RecordingError> {
    let joints = RecordedJoint::all(&["shoulder".into(), "elbow".into()]);
    read(&path(name), map, &joints, SignalKind::Current)
}

fn map(time: &str, position: &str, current: &str) -> ColumnMap {
    ColumnMap {
        time: Some(time.into()),
        position: Some(position.into()),
        current: Some(current.into()),
        ..ColumnMap::default()
    }
}

/// Compares with the table of the script; `rounding` of single precision or of decimals.
fn is_the_table(name: &str, recording: &Recording, rounding: f64) {
    let time = recording.time.as_ref().unwrap();
    assert_eq!(time.len(), SAMPLES, "{name}");
    for k in 0..SAMPLES {
        let t = k as f64 / 100.0;
        assert!(
            (time[k] - t).abs() <= rounding.max(1e-9),
            "{name}: t[{k}] is {}",
            time[k]
        );
        for j in 0..2 {
            let position = (j as f64 + 1.0) * k as f64 / 64.0;
            assert_eq!(recording.position[j][k], position, "{name}: q[{j}][{k}]");
            let counts = recording.mask.as_ref().is_none_or(|mask| mask[k]);
            let current = (k % 7) as f64 - 3.0 + j as f64 / 4.0;
            assert!(
                !counts || recording.signal[j][k] == current,
                "{name}: i[{j}][{k}]"
            );
        }
    }
}

#[test]
fn text_with_comments_and_in_other_encodings_is_the_table() {
    let names = [
        "savetxt.csv",
        "percent.csv",
        "matlab.csv",
        "comments.csv",
        "excel_unicode.csv",
        "utf16_big.csv",
        "utf8_mark.csv",
        "polars.csv",
        "index.csv",
        "quoted.csv",
        "blanks.csv",
    ];
    for name in names {
        let recording = read_file(name, &ColumnMap::default());
        let recording = recording.unwrap_or_else(|fault| panic!("{name}: {fault}"));
        is_the_table(name, &recording, 0.0);
        assert_eq!(recording.missing, None, "{name}");
    }
}

#[test]
fn lines_are_counted_with_the_comments_between_them() {
    let recording = read_file("comments.csv", &ColumnMap::default()).unwrap();
    let lines: Vec<usize> = [0, 3, 4, 39].map(|k| recording.line(k)).to_vec();
    assert_eq!(lines, [4, 7, 10, 45]);
    assert_eq!(
        read_file("savetxt.csv", &ColumnMap::default())
            .unwrap()
            .line(5),
        7
    );
}

#[test]
fn rows_with_empty_cells_are_left_out_whatever_the_file() {
    let names = [
        "empty_cells.csv",
        "na.csv",
        "spreadsheet.csv",
        "empty_end.csv",
        "polars_null.csv",
        "polars_null.parquet",
        "pandas_null.parquet",
        "nan.npz",
        "nan.mat",
    ];
    for name in names {
        let recording = read_file(name, &ColumnMap::default());
        let recording = recording.unwrap_or_else(|fault| panic!("{name}: {fault}"));
        // The position lies on a line through its neighbours, the current does not.
        is_the_table(name, &recording, 0.0);
        let mask = recording.mask.as_ref().unwrap();
        let left_out: Vec<usize> = (0..SAMPLES).filter(|&k| !mask[k]).collect();
        assert_eq!(left_out, [7, 11, 12], "{name}");
        let missing = recording.missing.as_ref().unwrap();
        assert_eq!((missing.rows, missing.of), (3, SAMPLES), "{name}");
        let said = missing.words(Path::new(name));
        assert!(said.contains("q1 (1), i2 (2)"), "{said}");
    }
}

#[test]
fn columns_of_lists_are_read_by_the_number_of_their_element() {
    let lerobot = ColumnMap {
        current: Some(Column {
            at: ColumnsAt::Names(vec![
                "observation.state3".into(),
                "observation.state4".into(),
            ]),
            factors: Factors::SI,
        }),
        ..map("timestamp", "observation.state{n}", "")
    };
    let recording = read_file("lerobot.parquet", &lerobot).unwrap();
    is_the_table("lerobot.parquet", &recording, 1e-6);
    let actions = ColumnMap {
        position: Some("action{n}".into()),
        ..lerobot.clone()
    };
    is_the_table(
        "actions",
        &read_file("lerobot.parquet", &actions).unwrap(),
        1e-6,
    );
    let beyond = map("timestamp", "observation.state{n}", "action{n}");
    let beyond = ColumnMap {
        current: Some(Column {
            at: ColumnsAt::Names(vec!["action2".into(), "action3".into()]),
            factors: Factors::SI,
        }),
        ..beyond
    };
    let fault = read_file("lerobot.parquet", &beyond).unwrap_err();
    assert_eq!(fault.describe().code, "missing-column", "{fault}");
    let holed = ColumnMap {
        current: Some(Column {
            at: ColumnsAt::Names(vec!["s3".into(), "s4".into()]),
            factors: Factors::SI,
        }),
        ..map("t", "s{n}", "")
    };
    let recording = read_file("null_list.parquet", &holed).unwrap();
    is_the_table("null_list.parquet", &recording, 0.0);
    assert_eq!(recording.missing.unwrap().rows, 1);
}

#[test]
fn durations_are_seconds() {
    let recording = read_file("duration.parquet", &ColumnMap::default()).unwrap();
    is_the_table("duration.parquet", &recording, 0.0);
}

#[test]
fn hdf5_and_matlab_files_that_are_hdf5_are_the_table() {
    for name in ["v73.mat", "latest.hdf5"] {
        let recording = read_file(name, &ColumnMap::default());
        let recording = recording.unwrap_or_else(|fault| panic!("{name}: {fault}"));
        is_the_table(name, &recording, 0.0);
    }
    let grouped = read_file("groups.h5", &map("t", "arm.q{n}", "arm.i{n}")).unwrap();
    is_the_table("groups.h5", &grouped, 0.0);
    let mut fields = map("t", "run.q{n}", "run.i{n}");
    fields.current.as_mut().unwrap().factors = Factors::Same(0.25);
    is_the_table("fields", &read_file("v73.mat", &fields).unwrap(), 0.0);
}

#[test]
fn an_object_beside_the_arrays_is_passed_over_until_it_is_asked_for() {
    let recording = read_file("object.mat", &ColumnMap::default()).unwrap();
    is_the_table("object.mat", &recording, 0.0);
    let asked = ColumnMap {
        mask: Some("log".into()),
        ..ColumnMap::default()
    };
    let fault = read_file("object.mat", &asked).unwrap_err();
    assert_eq!(fault.describe().code, "unsupported-content");
    assert!(fault.to_string().contains("object.mat: log"), "{fault}");
}
