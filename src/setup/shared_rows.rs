//! Duplicate rows among the recordings of a problem: what was fitted is not held out, and what is given twice counts twice.

use crate::fault::Place;
use crate::problem_file::RecordingsTable;
use crate::recording::copies::{Shared, find};
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::row_faults::SharedRows;
use crate::recording::samples::Recording;
use crate::recording::split::Split;
use crate::recording::timing::examine;
use crate::setup::recording_file::ReadRecording;

/// Faults of recordings that have rows in common, by the one that is held out, or that comes second.
pub fn shared_rows(table: &RecordingsTable, read: &[ReadRecording<'_>]) -> Vec<RecordingError> {
    let recordings: Vec<&Recording> = read.iter().map(|read| &read.recording).collect();
    let split = |recording: usize| read[recording].named.split;
    let fault = |shared: Shared| {
        let turned =
            split(shared.first) == Split::Validation && split(shared.second) == Split::Train;
        let shared = if turned { shared.turned() } else { shared };
        let recording = recordings[shared.second];
        let rate = table.rate.as_ref().map(|rate| rate.value);
        let rate_hz = examine(recording, rate).map_or(f64::NAN, |timing| timing.rate_hz);
        let rows = recording.position.first().map_or(1, Vec::len);
        let words = SharedRows {
            other: read[shared.first].named.path.written.clone(),
            first: shared.second_row + 1,
            first_of_other: shared.first_row + 1,
            rows: shared.rows,
            seconds: shared.total as f64 / rate_hz,
            share: shared.total as f64 / rows as f64,
            held_out: split(shared.first) != split(shared.second),
        };
        RecordingError {
            place: Place::file(&recording.file).line(recording.line(shared.second_row)),
            kind: RecordingErrorKind::SharedRows(Box::new(words)),
        }
    };
    find(&recordings).into_iter().map(fault).collect()
}
