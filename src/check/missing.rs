//! Cells of a recording that hold no number.

use crate::check::context::RawRecording;
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};

/// Share of the rows up to which a logger drops a value now and then.
const NOW_AND_THEN: f64 = 0.05;

pub(super) fn check(read: &RawRecording<'_>) -> Vec<Mistake> {
    let Some(missing) = &read.recording.missing else {
        return Vec::new();
    };
    let severity = match missing.rows as f64 > NOW_AND_THEN * missing.of as f64 {
        true => Severity::Warning,
        false => Severity::Note,
    };
    let worst = missing.columns.iter().max_by_key(|c| c.cells);
    let place = match worst {
        Some(worst) => read.place().key(&worst.column),
        None => read.place(),
    };
    vec![finding(
        severity,
        place,
        Description::new(
            "missing-values",
            missing.words(&read.recording.file),
            "record and export every channel in every row; what is left out shows nothing",
        ),
    )]
}
