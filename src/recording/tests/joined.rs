//! One recording from several files: a motion and its signals, written by loggers of their own.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::{joints, write};
use crate::fault::Fault;
use crate::recording::channels::column_map::ColumnMap;
use crate::recording::channels::columns::{RecordedJoint, read};
use crate::recording::channels::samples::{Recording, SignalKind};
use crate::recording::error::RecordingError;
use crate::recording::formats::reading::Reading;
use crate::recording::join::{Source, read_joined};

fn position(joint: usize, t: f64) -> f64 {
    (2.0 * t + joint as f64).sin()
}

fn torque(joint: usize, t: f64) -> f64 {
    3.0 * (1.5 * t).cos() + joint as f64
}

/// A table of functions of time, from one time to another at a rate.
fn table(
    header: &str,
    columns: &[&dyn Fn(f64) -> f64],
    (from, to, rate): (f64, f64, f64),
) -> String {
    let mut text = format!("{header}\n");
    for k in 0..((to - from) * rate).round() as usize {
        let t = from + k as f64 / rate;
        write!(text, "{t}").unwrap();
        columns
            .iter()
            .for_each(|x| write!(text, ",{}", x(t)).unwrap());
        text.push('\n');
    }
    text
}

fn positions(span: (f64, f64, f64)) -> String {
    table("t,q1,q2", &[&|t| position(0, t), &|t| position(1, t)], span)
}

fn torques(span: (f64, f64, f64)) -> String {
    table("t,tau1,tau2", &[&|t| torque(0, t), &|t| torque(1, t)], span)
}

fn join(files: &[&Path], maps: &[ColumnMap]) -> Result<Recording, RecordingError> {
    let sources: Vec<Source> = files
        .iter()
        .zip(maps)
        .map(|(path, map)| Source { path, map })
        .collect();
    let joints = RecordedJoint::all(&joints());
    read_joined(&sources, &joints, SignalKind::Torque, &Reading::default())
}

fn plain(files: &[&Path]) -> Result<Recording, RecordingError> {
    join(files, &vec![ColumnMap::default(); files.len()])
}

/// Largest errors of positions and of torques.
fn errors(recording: &Recording) -> [f64; 2] {
    let time = recording.time.as_ref().unwrap();
    let largest = |series: &[Vec<f64>], exact: fn(usize, f64) -> f64| {
        let of = |(j, x): (usize, &Vec<f64>)| {
            let errors = x.iter().zip(time).map(|(x, t)| (x - exact(j, *t)).abs());
            errors.fold(0.0, f64::max)
        };
        series.iter().enumerate().map(of).fold(0.0, f64::max)
    };
    [
        largest(&recording.position, position),
        largest(&recording.signal, torque),
    ]
}

#[test]
fn channels_come_to_the_times_of_the_first_file_and_its_ends_are_cut() {
    let (_a, first) = write("torques.csv", torques((0.0, 10.0, 100.0)).as_bytes());
    let (_b, second) = write("positions.csv", positions((1.0, 11.003, 77.0)).as_bytes());
    let recording = plain(&[&first, &second]).unwrap();
    let time = recording.time.as_ref().unwrap();
    assert!((time[0] - 1.0).abs() < 1e-9 && (time[time.len() - 1] - 9.99).abs() < 1e-9);
    assert_eq!(recording.line(0), 102);
    let [position, torque] = errors(&recording);
    // A natural spline is off by h² q''/8 or so at its ends, where q'' is not zero; torques are as recorded.
    assert!(position <= 4.0 / 77.0_f64.powi(2) / 8.0, "{position}");
    assert!(torque <= 1e-12, "{torque}");
    let said = recording.remarks.join(" ");
    assert!(
        said.contains("77.0000 Hz") && said.contains("100 rows"),
        "{said}"
    );
    // The other way around torques are on straight lines, off by h² τ''/8.
    let turned = plain(&[&second, &first]).unwrap();
    let [position, torque] = errors(&turned);
    assert!(
        position <= 1e-12 && torque <= 3.0 * 1.5_f64.powi(2) * 1e-4 / 8.0,
        "{torque}"
    );
}

#[test]
fn stamps_that_agree_give_the_samples_themselves_and_nothing_is_said() {
    let span = (0.0, 5.0, 100.0);
    let (_a, first) = write("positions.csv", positions(span).as_bytes());
    let (_b, second) = write("torques.csv", torques(span).as_bytes());
    let recording = plain(&[&first, &second]).unwrap();
    assert_eq!(errors(&recording), [0.0, 0.0]);
    assert!(recording.remarks.is_empty() && recording.mask.is_none());
    assert_eq!(recording.position[0].len(), 500);
}

#[test]
fn one_file_for_each_signal_with_maps_of_their_own() {
    let span = (0.0, 5.0, 100.0);
    let files = [
        write(
            "q1.csv",
            table("t,q1", &[&|t| position(0, t)], span).as_bytes(),
        ),
        write(
            "q2.csv",
            table("t,q2", &[&|t| position(1, t)], span).as_bytes(),
        ),
        write(
            "tau1.csv",
            table("t,tau1", &[&|t| torque(0, t)], span).as_bytes(),
        ),
        write(
            "tau2.csv",
            table("t,tau2", &[&|t| torque(1, t)], span).as_bytes(),
        ),
    ];
    let paths: Vec<PathBuf> = files.iter().map(|(_, path)| path.clone()).collect();
    let paths: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
    assert_eq!(errors(&plain(&paths).unwrap()), [0.0, 0.0]);
    // The second file has other names and milliseconds.
    let milli = |of: usize| move |t: f64| torque(of, 1e-3 * t);
    let text = table("stamp,m1,m2", &[&milli(0), &milli(1)], (0.0, 5000.0, 0.1));
    let (_a, first) = write("positions.csv", positions(span).as_bytes());
    let (_b, second) = write("m.csv", text.as_bytes());
    let mut own = ColumnMap {
        time: Some("stamp".into()),
        torque: Some("m{n}".into()),
        ..ColumnMap::default()
    };
    own.time.as_mut().unwrap().factors =
        crate::recording::channels::column_map::Factors::Same(1e-3);
    let recording = join(&[&first, &second], &[ColumnMap::default(), own]).unwrap();
    assert!(errors(&recording)[1] < 1e-6);
}

#[test]
fn a_gap_of_one_file_is_masked() {
    let (_a, first) = write("torques.csv", torques((0.0, 10.0, 100.0)).as_bytes());
    let text = positions((0.0, 10.0, 200.0));
    let kept = text
        .lines()
        .enumerate()
        .filter(|(k, _)| !(801..881).contains(k));
    let text: Vec<&str> = kept.map(|(_, line)| line).collect();
    let (_b, second) = write("positions.csv", text.join("\n").as_bytes());
    let mask = plain(&[&first, &second]).unwrap().mask.unwrap();
    let left_out: Vec<usize> = (0..mask.len()).filter(|&k| !mask[k]).collect();
    assert_eq!(left_out, (400..440).collect::<Vec<_>>());
}

#[test]
fn what_cannot_be_joined_is_refused() {
    let (_a, first) = write("torques.csv", torques((0.0, 5.0, 100.0)).as_bytes());
    let code = |text: String| {
        let (_b, second) = write("positions.csv", text.as_bytes());
        plain(&[&first, &second]).unwrap_err().describe().code
    };
    assert_eq!(code(positions((6.0, 9.0, 100.0))), "no-common-time");
    assert_eq!(
        code(positions((0.0, 5.0, 100.0)).replacen("t,", "k,", 1)),
        "join-without-time"
    );
    assert_eq!(
        code(positions((0.0, 5.0, 100.0)).replacen("q2", "x2", 1)),
        "missing-column"
    );
}

/// Bags count from their first message and say when that was: two of one instant agree.
#[test]
fn stamps_with_dates_are_brought_to_one_origin() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/recordings");
    let (bag, table) = (folder.join("plain.mcap"), folder.join("typed.parquet"));
    let joints = RecordedJoint::all(&["shoulder".into(), "elbow".into()]);
    let map = ColumnMap::default();
    let sources = [&bag, &table].map(|path| Source { path, map: &map });
    let (kind, reading) = (SignalKind::Current, &Reading::default());
    let joined = read_joined(&sources, &joints, kind, reading).unwrap();
    let alone = read(&bag, &map, &joints, SignalKind::Current).unwrap();
    assert_eq!(joined.position, alone.position);
    let (_c, seconds) = write("s.csv", positions((0.0, 5.0, 100.0)).as_bytes());
    let sources = [&bag, &seconds].map(|path| Source { path, map: &map });
    let fault = read_joined(&sources, &joints, kind, reading).unwrap_err();
    assert_eq!(fault.describe().code, "clocks-differ");
}
