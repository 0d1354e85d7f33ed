//! The table of predictions: what is written is read back, to ten digits.

use std::fs;
use std::path::PathBuf;

use crate::outcome::predictions::{Block, Column, Predictions, PredictionsWriter, Quantity};
use crate::recording::split::Split;

fn columns() -> Vec<Column> {
    let of = |joint: &str| {
        [Quantity::Recorded, Quantity::Predicted].map(|quantity| Column {
            joint: joint.to_string(),
            quantity,
        })
    };
    [of("a1"), of("left, \"upper\"")].concat()
}

fn written(blocks: &[Block]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut writer = PredictionsWriter::new(&mut out, &columns()).unwrap();
    for block in blocks {
        writer.block(block).unwrap();
    }
    out
}

fn stored(content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("predictions.csv");
    fs::write(&path, content).unwrap();
    (folder, path)
}

#[test]
fn matches_the_promised_layout() {
    let content = written(&[Block {
        recording: "train.csv",
        split: Split::Train,
        t: &[0.0, 0.005],
        columns: &[&[1.5, -2.0], &[1.25, f64::NAN], &[0.0, 1e-12], &[1e9, 3.0]],
    }]);
    assert_eq!(
        String::from_utf8(content).unwrap(),
        "recording,split,t,a1_recorded,a1_predicted,\"left, \"\"upper\"\"_recorded\",\
         \"left, \"\"upper\"\"_predicted\"\n\
         train.csv,train,0,1.500000000e0,1.250000000e0,0.000000000e0,1.000000000e9\n\
         train.csv,train,0.005,-2.000000000e0,,1.000000000e-12,3.000000000e0\n"
    );
}

#[test]
fn invariant_what_is_written_is_read_to_ten_digits() {
    let t: Vec<f64> = (0..50).map(|k| 1.7e9 + 1e-4 * f64::from(k)).collect();
    let columns: Vec<Vec<f64>> = (0..4)
        .map(|c| t.iter().map(|x| (x + f64::from(c)).sin()).collect())
        .collect();
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let block = |recording, split| Block {
        recording,
        split,
        t: &t,
        columns: &columns,
    };
    let (_folder, path) = stored(&written(&[
        block("one.csv", Split::Train),
        block("one.csv", Split::Validation),
    ]));
    let table = Predictions::read(&path).unwrap();
    assert_eq!(
        table.column("left, \"upper\"", Quantity::Predicted),
        Some(3)
    );
    assert_eq!(table.column("a1", Quantity::Velocity), None);
    assert_eq!(table.recordings.len(), 2);
    let read = &table.recordings[1];
    assert_eq!(read.split, Split::Validation);
    assert_eq!(read.t, t, "time stamps keep all their digits");
    for (values, column) in read.values.iter().zip(&columns) {
        for (value, wanted) in values.iter().zip(*column) {
            // Ten significant digits: half a unit in the last of them.
            assert!((value - wanted).abs() <= 0.5e-9 * 10f64.powf(wanted.abs().log10().floor()));
        }
    }
}

#[test]
fn refuses_a_block_that_does_not_fit_the_header() {
    let mut writer = PredictionsWriter::new(Vec::new(), &columns()).unwrap();
    for columns in [&[[0.0].as_slice()] as &[&[f64]], &[&[], &[], &[], &[]]] {
        let block = Block {
            recording: "r",
            split: Split::Train,
            t: &[0.0],
            columns,
        };
        assert!(writer.block(&block).is_err());
    }
}

#[test]
fn names_the_line_that_breaks_the_layout() {
    let head = "recording,split,t,a1_recorded\n";
    for (content, expected) in [
        ("x,y\n1,2\n".to_string(), "the header does not begin"),
        (
            "recording,split,t,a1_odd\n".to_string(),
            "`a1_odd` is not known",
        ),
        (
            format!("{head}r,train,0,1\nr,trian,1,1\n"),
            "csv:3: the split is `trian`",
        ),
        (
            format!("{head}r,train,0,1\nr,train,1,one\n"),
            "csv:3: a value is `one`",
        ),
        (format!("{head}r,train,0\n"), "line: 2"),
        (String::new(), "the header does not begin"),
    ] {
        let (_folder, path) = stored(content.as_bytes());
        let error = Predictions::read(&path).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}
