//! Damaged files of every format: an error with its code, whatever is missing or wrong.

use std::fs;
use std::path::Path;

use crate::fault::Fault;
use crate::recording::channels::column_map::ColumnMap;
use crate::recording::channels::columns::{RecordedJoint, read};
use crate::recording::channels::samples::SignalKind;
use crate::recording::error::RecordingError;

const FILES: [&str; 15] = [
    "plain.npz",
    "deflated.npz",
    "plain.mat",
    "structure.mat",
    "snappy.parquet",
    "typed.parquet",
    "plain.bag",
    "lz4.bag",
    "plain.db3",
    "messages.db3",
    "plain.mcap",
    "zstd.mcap",
    "foreign/v73.mat",
    "foreign/latest.hdf5",
    "foreign/duration.parquet",
];

fn content(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/recordings");
    fs::read(folder.join(name)).unwrap()
}

/// Reads the bytes as a file of this name; None: the file was accepted.
fn fault(name: &str, bytes: &[u8]) -> Option<RecordingError> {
    let last = Path::new(name).file_name().unwrap().to_str().unwrap();
    let (_folder, path) = super::write(last, bytes);
    let joints = RecordedJoint::all(&["shoulder".into(), "elbow".into()]);
    let map = match name {
        "structure.mat" => ColumnMap {
            position: Some("run.q{n}".into()),
            current: Some("run.i{n}".into()),
            ..ColumnMap::default()
        },
        _ => ColumnMap::default(),
    };
    read(&path, &map, &joints, SignalKind::Current).err()
}

#[test]
fn a_file_that_is_cut_off_is_refused() {
    for name in FILES {
        let whole = content(name);
        for parts in [1, 3, 5, 7] {
            let cut = &whole[..whole.len() * parts / 8];
            let fault = fault(name, cut).unwrap_or_else(|| panic!("{name}: {parts}/8 accepted"));
            let code = fault.describe().code;
            let usual = [
                "corrupt-file",
                "missing-column",
                "no-joint-state",
                "too-few-rows",
            ];
            assert!(usual.contains(&code), "{name}: {fault}");
        }
    }
}

#[test]
fn a_file_of_another_kind_is_refused() {
    let text = b"t,q1,q2,i1,i2\n0,0,0,0,0\n".repeat(40);
    for name in FILES {
        let fault = fault(name, &text).unwrap();
        assert_eq!(fault.describe().code, "corrupt-file", "{name}: {fault}");
    }
}

/// One byte at a time, over the whole file: an error or an accepted table, never a panic.
#[test]
fn a_changed_byte_is_refused_or_read() {
    for name in FILES {
        let whole = content(name);
        let step = (whole.len() / 200).max(1);
        for at in (0..whole.len()).step_by(step) {
            let mut changed = whole.clone();
            changed[at] ^= 0x41;
            if let Some(fault) = fault(name, &changed) {
                assert!(!fault.describe().remedy.is_empty(), "{name}: byte {at}");
            }
        }
    }
}

/// A NumPy archive of these arrays, stored.
fn archive(arrays: &[(&str, &str, &[u8])]) -> Vec<u8> {
    use std::io::Write;
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let stored =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, header, data) in arrays {
        zip.start_file(*name, stored).unwrap();
        zip.write_all(b"\x93NUMPY\x01\x00").unwrap();
        let length = u16::try_from(header.len()).unwrap();
        zip.write_all(&length.to_le_bytes()).unwrap();
        zip.write_all(header.as_bytes()).unwrap();
        zip.write_all(data).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn header(shape: &str) -> String {
    format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}")
}

/// The last bit of a number changes the result by next to nothing, and still the file is not what was written.
#[test]
fn a_changed_bit_of_a_number_is_found_by_the_checksum() {
    let data: Vec<u8> = (0..60).flat_map(|k| f64::from(k).to_le_bytes()).collect();
    let matrix = header("(30, 2)");
    let whole = archive(&[("q.npy", &matrix, &data), ("i.npy", &matrix, &data)]);
    assert!(fault("a.npz", &whole).is_none());
    let at = whole.windows(480).position(|bytes| bytes == data).unwrap();
    for number in [0, 13, 59] {
        let mut changed = whole.clone();
        changed[at + 8 * number] ^= 1;
        let fault = fault("a.npz", &changed).unwrap();
        assert_eq!(fault.describe().code, "corrupt-file", "{fault}");
        assert!(fault.place().to_string().ends_with("a.npz: q"), "{fault}");
    }
}

#[test]
fn faults_of_arrays_have_their_codes_and_places() {
    let column = |value: f64, rows: usize| -> Vec<u8> {
        let mut bytes = Vec::new();
        for row in 0..rows {
            let value = if row == 7 { value } else { row as f64 };
            bytes.extend(value.to_le_bytes());
        }
        bytes
    };
    let (long, short) = (header("(30,)"), header("(29,)"));
    let matrix = header("(30, 2)");
    let (good, infinite) = (column(0.0, 60), column(f64::INFINITY, 60));
    let cases: [(&str, &str, Vec<u8>); 5] = [
        (
            "not-finite",
            "a.npz:4: q2",
            archive(&[("q.npy", &matrix, &infinite), ("i.npy", &matrix, &good)]),
        ),
        (
            "unequal-lengths",
            "a.npz: q1",
            archive(&[
                ("t.npy", &short, &good[..232]),
                ("q.npy", &matrix, &good),
                ("i.npy", &matrix, &good),
            ]),
        ),
        (
            "duplicate-column",
            "a.npz: q1",
            archive(&[
                ("q.npy", &matrix, &good),
                ("q1.npy", &long, &good[..240]),
                ("i.npy", &matrix, &good),
            ]),
        ),
        (
            "too-few-rows",
            "a.npz",
            archive(&[
                ("q.npy", &header("(19, 2)"), &good[..304]),
                ("i.npy", &header("(19, 2)"), &good[..304]),
            ]),
        ),
        (
            "corrupt-file",
            "a.npz: q",
            archive(&[
                ("q.npy", &header("(99999999, 2)"), &good),
                ("i.npy", &header("(99999999, 2)"), &good),
            ]),
        ),
    ];
    for (code, place, bytes) in cases {
        let fault = fault("a.npz", &bytes).unwrap();
        assert_eq!(fault.describe().code, code, "{fault}");
        assert!(fault.place().to_string().ends_with(place), "{fault}");
    }
}
