//! A table of numbers with named columns.

use std::path::Path;

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};

/// The wanted columns of a file, column by column; a cell without a number is NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Names of the columns, in the order of `data`.
    pub columns: Vec<String>,
    /// `data[c][k]`: column c, row k.
    pub data: Vec<Vec<f64>>,
    /// Line of the first row in the file, from 1; row k is line `first_line + k`. In formats
    /// without lines, the number of the first record: 1.
    pub first_line: usize,
    /// Line of every row, where rows do not follow one another.
    pub lines: Option<Vec<usize>>,
    /// Columns that count from their first row, and when that was.
    pub origins: Vec<Origin>,
}

/// When a column of seconds since its first row begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// Name of the column.
    pub column: String,
    /// ns since 1970.
    pub nanoseconds: i64,
}

impl Table {
    /// When a column of seconds since its first row begins, ns since 1970; None of any other column.
    pub fn origin(&self, column: &str) -> Option<i64> {
        let found = self.origins.iter().find(|origin| origin.column == column);
        found.map(|origin| origin.nanoseconds)
    }

    /// Rows of every column.
    pub fn rows(&self) -> usize {
        self.data.first().map_or(0, Vec::len)
    }

    /// Line of a row in the file.
    pub fn line(&self, row: usize) -> usize {
        let listed = self.lines.as_ref().and_then(|lines| lines.get(row));
        listed.copied().unwrap_or(self.first_line + row)
    }

    /// Takes a column out of the table; None if it is not there.
    pub fn take(&mut self, name: &str) -> Option<Vec<f64>> {
        let at = self.columns.iter().position(|column| column == name)?;
        self.columns.swap_remove(at);
        Some(self.data.swap_remove(at))
    }
}

/// Fewest rows that can be differentiated, filtered and compared with a model.
pub const LEAST_ROWS: usize = 20;

/// Fails unless the table has the least number of rows.
pub(in crate::recording) fn require_rows(path: &Path, rows: usize) -> Result<(), RecordingError> {
    if rows >= LEAST_ROWS {
        return Ok(());
    }
    let kind = RecordingErrorKind::TooFewRows {
        found: rows,
        least: LEAST_ROWS,
    };
    Err(RecordingError::new(Place::file(path), kind))
}
