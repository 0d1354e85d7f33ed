//! Recordings as other programs leave them, one table of files with what a problem file says of their columns.
//! `tests/data/recordings/formats/make.py` writes the files and states what they hold.

use exid::recording::column_map::{Column, ColumnMap, ColumnsAt, Factors};
use exid::recording::columns::{RecordedJoint, read};
use exid::recording::samples::{Recording, SignalKind};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

const SAMPLES: usize = 24;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/recordings/formats")
}

/// What a problem file says of the columns of a file: nothing, where the usual names find them.
#[derive(Clone, Copy, Default)]
struct Columns {
    time: Option<Said>,
    position: Option<Said>,
    current: Option<Said>,
}

#[derive(Clone, Copy)]
enum Said {
    Name(&'static str),
    /// With so many SI units to a unit of the file.
    Scaled(&'static str, f64),
    Names([&'static str; 2]),
    Numbers([usize; 2]),
    Number(usize),
}

impl Said {
    fn column(self) -> Column {
        let names = |names: [&str; 2]| ColumnsAt::Names(names.map(String::from).to_vec());
        match self {
            Self::Name(name) => name.into(),
            Self::Scaled(name, factor) => Column {
                factors: Factors::Same(factor),
                ..name.into()
            },
            Self::Names(both) => Column {
                at: names(both),
                factors: Factors::SI,
            },
            Self::Numbers(numbers) => Column {
                at: ColumnsAt::Numbers(numbers.to_vec()),
                factors: Factors::SI,
            },
            Self::Number(number) => Column {
                at: ColumnsAt::Numbers(vec![number]),
                factors: Factors::SI,
            },
        }
    }
}

fn read_file(name: &str, columns: Columns) -> Result<Recording, String> {
    let map = ColumnMap {
        time: columns.time.map(Said::column),
        position: columns.position.map(Said::column),
        current: columns.current.map(Said::column),
        ..ColumnMap::default()
    };
    let joints = RecordedJoint::all(&["shoulder".into(), "elbow".into()]);
    // Two messages of one bag may be of either kind: its effort is a current here.
    read(&folder().join(name), &map, &joints, SignalKind::Current).map_err(|e| e.to_string())
}

/// What differs from the table of the script; `rounding` is of the file's own numbers.
fn difference(recording: &Recording, rounding: f64) -> Option<String> {
    let time = recording.time.as_ref()?;
    if time.len() != SAMPLES {
        return Some(format!("{} rows", time.len()));
    }
    for k in 0..SAMPLES {
        if ((time[k] - time[0]) - k as f64 / 100.0).abs() > rounding.max(1e-9) {
            return Some(format!("t[{k}] is {}", time[k]));
        }
        for j in 0..2 {
            let position = (j as f64 + 1.0) * k as f64 / 64.0;
            let current = (k % 7) as f64 - 3.0 + j as f64 / 4.0;
            let found = [recording.position[j][k], recording.signal[j][k]];
            if (found[0] - position).abs() > rounding || (found[1] - current).abs() > rounding {
                return Some(format!("row {k}, joint {j}: {found:?}"));
            }
        }
    }
    recording
        .missing
        .as_ref()
        .map(|missing| format!("{missing:?}"))
}

const PLAIN: Columns = Columns {
    time: None,
    position: None,
    current: None,
};

fn named(time: &'static str, position: &'static str, current: &'static str) -> Columns {
    Columns {
        time: Some(Said::Name(time)),
        position: Some(Said::Name(position)),
        current: Some(Said::Name(current)),
    }
}

/// Files whose columns have to be said, with how; of all others the usual names are enough.
fn said() -> Vec<(&'static str, Columns)> {
    let counts = |scale: Said| Columns {
        current: Some(scale),
        ..PLAIN
    };
    let quarters = counts(Said::Scaled("i{n}", 0.25));
    let states = Columns {
        current: Some(Said::Names(["observation.state3", "observation.state4"])),
        ..named("timestamp", "observation.state{n}", "")
    };
    vec![
        ("latin1.csv", named("Zeit", "Stärke q{n}", "Größe {n}")),
        (
            "numpy_headless.txt",
            Columns {
                time: Some(Said::Number(1)),
                position: Some(Said::Numbers([2, 3])),
                current: Some(Said::Numbers([4, 5])),
            },
        ),
        (
            "integers.parquet",
            Columns {
                time: Some(Said::Scaled("t", 0.01)),
                position: Some(Said::Scaled("q{n}", 1.0 / 64.0)),
                current: Some(Said::Scaled("i{n}", 0.25)),
            },
        ),
        ("lerobot_v2.parquet", states),
        ("nested.parquet", named("t", "state.q{n}", "state.i{n}")),
        ("big_endian.npz", quarters),
        ("lzf_free.h5", quarters),
        (
            "robomimic.hdf5",
            named(
                "data.demo_0.obs.t",
                "data.demo_0.obs.q{n}",
                "data.demo_0.obs.i{n}",
            ),
        ),
        (
            "v5_nested.mat",
            Columns {
                current: Some(Said::Scaled("log.data.i{n}", 0.25)),
                ..named("log.data.t", "log.data.q{n}", "")
            },
        ),
    ]
}

#[test]
fn files_of_other_programs_are_the_table() {
    let mut names: Vec<String> = fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name != "make.py")
        .collect();
    names.sort();
    let said = said();
    let known: BTreeSet<&str> = said.iter().map(|(name, _)| *name).collect();
    assert!(known.iter().all(|name| names.iter().any(|n| n == name)));
    let mut wrong = Vec::new();
    for name in &names {
        let own = said.iter().find(|(of, _)| of == name);
        let columns = own.map_or(PLAIN, |(_, columns)| *columns);
        // Single precision, and headers of the savetxt kind with eight digits.
        let rounding = match name.contains("lerobot") {
            true => 1e-6,
            false => 0.0,
        };
        match read_file(name, columns) {
            Ok(recording) => {
                let differs = difference(&recording, rounding);
                wrong.extend(differs.map(|what| format!("{name}: {what}")));
            }
            Err(error) => wrong.push(format!("{name}: {error}")),
        }
    }
    eprintln!(
        "{} of {} files are read as they are",
        names.len() - wrong.len(),
        names.len()
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
