//! Positions from a separate encoder: in another file, at its own rate and with its own noise, on the same clock.
//!
//! The sensor's samples become positions at the times of the signal by the natural cubic spline through them, which
//! bends no more than a motion within half the sensor's rate does: what lies above is for the low-pass of the positions
//! (`recordings.differentiation`). Samples of the signal before the sensor's first or after its last are dropped.

use std::path::Path;

use crate::recording::channels::column_map::ColumnMap;
use crate::recording::channels::columns::{File, Parts, RecordedJoint};
use crate::recording::channels::samples::{Recording, SignalKind};
use crate::recording::error::RecordingError;
use crate::recording::formats::reading::Reading;
use crate::recording::formats::table::require_rows;
use crate::recording::series::spline::Spline;
use crate::recording::time_base::timing::{examine, stamps};

/// The two files of a recording with an encoder of its own.
#[derive(Debug, Clone, Copy)]
pub struct EncoderFiles<'a> {
    /// Of the signal.
    pub signal: &'a Path,
    /// Of the encoder.
    pub positions: &'a Path,
}

/// Reads the signal from one file and the positions of the joints from another, both with time stamps.
///
/// Errors: those of both files, time stamps that are missing or do not increase, no common time.
pub fn read_with_separate_encoder(
    files: EncoderFiles<'_>,
    map: &ColumnMap,
    joints: &[RecordedJoint],
    kind: SignalKind,
    reading: &Reading,
) -> Result<Recording, RecordingError> {
    let EncoderFiles {
        signal: path,
        positions,
    } = files;
    let signal = File {
        path,
        parts: Parts::WithoutPosition,
    };
    let encoder = File {
        path: positions,
        parts: Parts::Position,
    };
    let mut recording = signal.read(map, joints, kind, reading)?;
    let mut sensor = encoder.read(map, joints, kind, reading)?;
    if let Some(mask) = sensor.mask.take() {
        let there: Vec<usize> = (0..mask.len()).filter(|&k| mask[k]).collect();
        sensor.keep(&there);
    }
    if let Some(missing) = &sensor.missing {
        recording.remarks.push(missing.words(positions));
    }
    examine(&sensor, None)?;
    let (time, knots) = (stamps(&recording)?, stamps(&sensor)?);
    let inside = |t: &f64| (knots[0]..=knots[knots.len() - 1]).contains(t);
    let kept: Vec<usize> = (0..time.len()).filter(|&k| inside(&time[k])).collect();
    require_rows(path, kept.len())?;
    let times: Vec<f64> = kept.iter().map(|&k| time[k]).collect();
    let splines = (sensor.position.iter()).map(|q| Spline::new(knots, q).at(&times));
    let position = splines.collect();
    recording.keep(&kept);
    recording.position = position;
    Ok(recording)
}
