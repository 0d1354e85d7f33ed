//! Reads `predictions.csv` back, for reports and exports.

use std::fs::File;
use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, StringRecord};

use crate::outcome::error::{Action, OutcomeError, OutcomeErrorKind};
use crate::outcome::predictions::quantity::{Column, LEADING, Quantity};
use crate::outcome::predictions::write::Block;
use crate::recording::split::Split;

/// The table, by recordings in the order of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Predictions {
    /// What each column holds.
    pub columns: Vec<Column>,
    /// Those that were fitted or held out, as the run had them.
    pub recordings: Vec<RecordingPredictions>,
}

/// The rows of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingPredictions {
    /// Name of the recording.
    pub recording: String,
    /// What the recording was for.
    pub split: Split,
    /// Time in s.
    pub t: Vec<f64>,
    /// Values by column, as long as `t`; not a number where a field is empty.
    pub values: Vec<Vec<f64>>,
}

impl RecordingPredictions {
    /// The rows of a block.
    pub fn of(block: &Block<'_>) -> Self {
        Self {
            recording: block.recording.to_owned(),
            split: block.split,
            t: block.t.to_vec(),
            values: block.columns.iter().map(|column| column.to_vec()).collect(),
        }
    }
}

impl Predictions {
    /// Reads the table at `path`.
    ///
    /// # Errors
    /// `not-readable`, or `not-predictions` with the line where the layout is broken.
    pub fn read(path: &Path) -> Result<Self, OutcomeError> {
        let file = File::open(path)
            .map_err(|error| OutcomeError::io(path, Action::ReadPredictions, &error))?;
        let mut reader = ReaderBuilder::new().from_reader(file);
        let header = reader.headers().map_err(|error| broken(path, &error))?;
        let mut table = Self {
            columns: parse_header(path, header)?,
            recordings: Vec::new(),
        };
        let mut row = ByteRecord::new();
        while reader
            .read_byte_record(&mut row)
            .map_err(|error| broken(path, &error))?
        {
            table.push(path, &row)?;
        }
        Ok(table)
    }

    /// Index of the column of a joint's quantity.
    pub fn column(&self, joint: &str, quantity: Quantity) -> Option<usize> {
        self.columns
            .iter()
            .position(|column| column.joint == joint && column.quantity == quantity)
    }

    fn push(&mut self, path: &Path, row: &ByteRecord) -> Result<(), OutcomeError> {
        let line = row
            .position()
            .map_or(0, |position| position.line() as usize);
        let bad = |what: &str, found: &[u8]| {
            let found = String::from_utf8_lossy(found);
            let reason = OutcomeErrorKind::NotPredictions(format!("{what} is `{found}`"));
            let mut error = OutcomeError::new(path, reason);
            error.place = error.place.line(line);
            error
        };
        let split = Split::ALL
            .into_iter()
            .find(|split| split.as_str().as_bytes() == &row[1])
            .ok_or_else(|| bad("the split", &row[1]))?;
        let continues = self
            .recordings
            .last()
            .is_some_and(|last| last.recording.as_bytes() == &row[0] && last.split == split);
        if !continues {
            self.recordings.push(RecordingPredictions {
                recording: String::from_utf8_lossy(&row[0]).into_owned(),
                split,
                t: Vec::new(),
                values: vec![Vec::new(); self.columns.len()],
            });
        }
        let Some(last) = self.recordings.last_mut() else {
            return Ok(());
        };
        last.t
            .push(number(&row[2]).ok_or_else(|| bad("the time", &row[2]))?);
        for (values, field) in last.values.iter_mut().zip(row.iter().skip(LEADING.len())) {
            values.push(number(field).ok_or_else(|| bad("a value", field))?);
        }
        Ok(())
    }
}

/// The number in a field; not a number where the field is empty.
fn number(field: &[u8]) -> Option<f64> {
    if field.is_empty() {
        return Some(f64::NAN);
    }
    std::str::from_utf8(field).ok()?.parse().ok()
}

fn parse_header(path: &Path, header: &StringRecord) -> Result<Vec<Column>, OutcomeError> {
    let refuse = |reason: String| OutcomeError::new(path, OutcomeErrorKind::NotPredictions(reason));
    if !header.iter().take(LEADING.len()).eq(LEADING) {
        let expected = LEADING.join(",");
        return Err(refuse(format!("the header does not begin with {expected}")));
    }
    header
        .iter()
        .skip(LEADING.len())
        .map(|name| {
            Quantity::ALL
                .into_iter()
                .find_map(|quantity| {
                    let joint = name.strip_suffix(quantity.as_str())?.strip_suffix('_')?;
                    Some(Column {
                        joint: joint.to_string(),
                        quantity,
                    })
                })
                .ok_or_else(|| refuse(format!("the column `{name}` is not known")))
        })
        .collect()
}

fn broken(path: &Path, error: &csv::Error) -> OutcomeError {
    OutcomeError::new(path, OutcomeErrorKind::NotPredictions(error.to_string()))
}
