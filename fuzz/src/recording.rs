//! What has to hold of a recording that is accepted: channels of one length, finite numbers, a row for
//! every sample.

use exid::recording::column_map::ColumnMap;

use exid::recording::columns::{RecordedJoint, read};
use exid::recording::error::RecordingError;
use exid::recording::experiment::Experiment;
use exid::recording::preprocess::prepare;
use exid::recording::samples::SignalKind;
use exid::recording::settings::{Differentiation, InCommon, Preparation};
use std::fs;
use std::path::{Path, PathBuf};

/// Largest number that comes back finite from differences at the highest rates that are tried.
const LARGEST: f64 = 1e100;

/// Reads the bytes as a recording of two joints, in several ways, and makes each ready.
pub fn is_sound(extension: &str, bytes: &[u8]) {
    let path = scratch_file(extension);
    fs::write(&path, bytes).unwrap();
    let ways = [
        SignalKind::Current,
        SignalKind::Torque,
        SignalKind::BaseWrench,
    ];
    // The joints of the seeds: of the bags those of their messages.
    for joints in [["a", "b"], ["shoulder", "elbow"]] {
        let joints = RecordedJoint::all(&joints.map(String::from));
        for kind in ways {
            for map in [ColumnMap::default(), with_mask()] {
                if let Err(fault) = one_way(&path, &map, &joints, kind) {
                    crate::describes_itself(&fault);
                }
            }
        }
    }
}

/// A file of this process in memory, where the system has such a place.
fn scratch_file(extension: &str) -> PathBuf {
    let memory = Path::new("/dev/shm");
    let folder = match memory.is_dir() {
        true => memory.to_path_buf(),
        false => std::env::temp_dir(),
    };
    folder.join(format!("exid-fuzz-{}{extension}", std::process::id()))
}

fn with_mask() -> ColumnMap {
    ColumnMap {
        mask: Some("ok".into()),
        ..ColumnMap::default()
    }
}

fn one_way(
    path: &Path,
    map: &ColumnMap,
    joints: &[RecordedJoint],
    kind: SignalKind,
) -> Result<(), RecordingError> {
    let recording = read(path, map, joints, kind)?;
    let samples = recording.position[0].len();
    let channels = recording.position.iter().chain(&recording.signal);
    let mut moderate = true;
    for channel in channels {
        assert_eq!(channel.len(), samples);
        assert!(channel.iter().all(|x| x.is_finite()));
        moderate &= channel.iter().all(|x| x.abs() <= LARGEST);
    }
    for preparation in preparations() {
        match prepare(recording.clone(), &preparation) {
            Ok(experiment) => is_whole(&experiment, moderate),
            Err(fault) => crate::describes_itself(&fault),
        }
    }
    Ok(())
}

/// Without and with a rate, a period, and filters.
fn preparations() -> [Preparation; 4] {
    let filters = |cutoff_hz, parallel_hz| Differentiation {
        method: None,
        cutoff_hz,
        parallel_hz,
        in_common: InCommon::default(),
    };
    [
        Preparation::default(),
        Preparation {
            rate: Some(100.0),
            period: None,
            differentiation: filters(Some(10.0), Some(8.0)),
        },
        Preparation {
            rate: Some(100.0),
            period: Some(0.2),
            differentiation: filters(None, None),
        },
        Preparation {
            rate: None,
            period: Some(0.25),
            differentiation: filters(Some(5.0), Some(4.0)),
        },
    ]
}

fn is_whole(experiment: &Experiment, moderate: bool) {
    let rows = experiment.rows();
    assert!(rows > 0);
    let motion = &experiment.motion;
    let series = [&motion.position, &motion.velocity, &motion.acceleration];
    for channel in series.into_iter().flatten().chain(&experiment.signal) {
        assert_eq!(channel.len(), rows);
        if moderate && experiment.rate_hz <= 1e6 {
            assert!(channel.iter().all(|x| x.is_finite()));
        }
    }
    for k in 0..experiment.raw.t.len() {
        assert!(experiment.raw.row_of(k) < rows);
    }
}
