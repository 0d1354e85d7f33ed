//! Missing values: rows that lack a value are left out as masked ones are, and linear interpolation bridges them, so that filters
//! have an even series.

use std::path::Path;

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::table::Table;
use crate::recording::series::differences::steps;
use crate::recording::series::interpolation::{Ends, fill};
use crate::stats::robust::median;

/// Share of the rows that may lack a value: beyond it more would be invented than was measured.
const MOST_MISSING: f64 = 0.5;

/// Cells of a recording that hold no number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingValues {
    /// Rows that are left out, and rows in all.
    pub rows: usize,
    /// Rows of the recording.
    pub of: usize,
    /// Columns that lack values, in the order of the channels.
    pub columns: Vec<MissingCells>,
}

/// Cells of one column that hold no number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingCells {
    /// Name of the column.
    pub column: String,
    /// How many of its cells.
    pub cells: usize,
}

impl MissingValues {
    /// What a reader of any result should know.
    pub fn words(&self, file: &Path) -> String {
        let cells = |c: &MissingCells| format!("{} ({})", c.column, c.cells);
        let columns: Vec<String> = self.columns.iter().map(cells).collect();
        format!(
            "{} of the {} rows of {} ({:.2} %) lack a value and are left out; empty cells by column: {}.",
            self.rows,
            self.of,
            file.display(),
            100.0 * self.rows as f64 / self.of as f64,
            columns.join(", ")
        )
    }
}

/// Columns of a table in which an empty cell is no missing sample.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::recording) struct Roles<'a> {
    /// A row without a stamp lies between its neighbours.
    pub time: Option<&'a str>,
    /// An empty cell leaves the row out.
    pub mask: Option<&'a str>,
    /// Channels that change slowly, and are recorded more slowly than the rest.
    pub slow: &'a [String],
}

/// A table without empty cells.
#[derive(Debug)]
pub(in crate::recording) struct CompleteTable {
    pub table: Table,
    /// false: the row lacks a value; None: no row does.
    pub valid: Option<Vec<bool>>,
    pub missing: Option<MissingValues>,
}

/// Bridges the empty cells of a table.
///
/// Errors: a number that is infinite, a column without any number, too many rows that lack one.
pub(in crate::recording) fn bridge(
    path: &Path,
    mut table: Table,
    roles: Roles<'_>,
) -> Result<CompleteTable, RecordingError> {
    require_no_infinity(path, &table)?;
    drop_empty_end(&mut table);
    let rows = table.rows();
    let mut valid = vec![true; rows];
    let mut columns = Vec::new();
    for (name, series) in table.columns.iter().zip(&mut table.data) {
        let there: Vec<bool> = series.iter().map(|x| !x.is_nan()).collect();
        let cells = there.iter().filter(|there| !**there).count();
        if cells == 0 {
            continue;
        }
        if cells == rows {
            let place = Place::file(path).key(name.as_str());
            return Err(RecordingError::new(
                place,
                RecordingErrorKind::EmptyColumn { rows },
            ));
        }
        let column = name.clone();
        columns.push(MissingCells { column, cells });
        if !roles.slow.contains(name) {
            valid.iter_mut().zip(&there).for_each(|(a, b)| *a &= *b);
        }
        match Some(name.as_str()) {
            name if name == roles.mask => series.iter_mut().for_each(|x| *x = x.max(0.0)),
            name if name == roles.time => bridge_stamps(series, &there),
            _ => fill(series, &there, Ends::Held),
        }
    }
    let missing = MissingValues {
        rows: valid.iter().filter(|valid| !**valid).count(),
        of: rows,
        columns,
    };
    require_most_rows(path, &missing)?;
    Ok(CompleteTable {
        table,
        valid: (missing.rows > 0).then_some(valid),
        missing: (!missing.columns.is_empty()).then_some(missing),
    })
}

/// Spreadsheets end in rows of empty cells where there was something once.
fn drop_empty_end(table: &mut Table) {
    let is_empty = |&row: &usize| table.data.iter().all(|series| series[row].is_nan());
    let rows = table.rows();
    let empty = (0..rows).rev().take_while(is_empty).count();
    // A table without any number is told by its columns.
    if empty < rows {
        (table.data.iter_mut()).for_each(|series| series.truncate(rows - empty));
    }
}

/// Stamps between their neighbours; beyond the ends at the usual step, so that they increase.
fn bridge_stamps(time: &mut [f64], there: &[bool]) {
    let known: Vec<f64> = time.iter().copied().filter(|t| !t.is_nan()).collect();
    let steps = steps(&known);
    let step = median(&steps).unwrap_or(0.0);
    fill(time, there, Ends::Held);
    let first = there.iter().position(|there| *there).unwrap_or(0);
    let last = there.iter().rposition(|there| *there).unwrap_or(0);
    for k in 0..first {
        time[k] -= step * (first - k) as f64;
    }
    for k in last + 1..time.len() {
        time[k] += step * (k - last) as f64;
    }
}

fn require_most_rows(path: &Path, missing: &MissingValues) -> Result<(), RecordingError> {
    let worst = missing.columns.iter().max_by_key(|c| c.cells);
    let Some(worst) = worst.filter(|_| missing.rows as f64 > MOST_MISSING * missing.of as f64)
    else {
        return Ok(());
    };
    let kind = RecordingErrorKind::TooManyMissing {
        rows: missing.rows,
        of: missing.of,
        cells: worst.cells,
    };
    let place = Place::file(path).key(worst.column.as_str());
    Err(RecordingError::new(place, kind))
}

/// Numbers of sensors are far below it, and the products of those beyond overflow.
const LARGEST: f64 = 1e100;

/// Fails at the first number that is infinite or that nothing can be computed with: it overflowed, or was never measured.
fn require_no_infinity(path: &Path, table: &Table) -> Result<(), RecordingError> {
    refuse(path, table, |x| x.abs() > LARGEST)
}

/// Fails at the first cell without a finite number, where a row cannot be left out.
pub fn require_complete(path: &Path, table: &Table) -> Result<(), RecordingError> {
    refuse(path, table, |x| x.is_nan() || x.abs() > LARGEST)
}

fn refuse(path: &Path, table: &Table, wrong: fn(&f64) -> bool) -> Result<(), RecordingError> {
    for (name, column) in table.columns.iter().zip(&table.data) {
        if let Some(row) = column.iter().position(wrong) {
            let place = Place::file(path).line(table.line(row)).key(name.as_str());
            let found = format!("{:e}", column[row]);
            let kind = RecordingErrorKind::NotFinite { found };
            return Err(RecordingError::new(place, kind));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: f64 = f64::NAN;

    fn table(columns: &[(&str, &[f64])]) -> Table {
        Table {
            columns: columns.iter().map(|(name, _)| name.to_string()).collect(),
            data: columns.iter().map(|(_, series)| series.to_vec()).collect(),
            first_line: 2,
            lines: None,
            origins: Vec::new(),
        }
    }

    fn bridged(columns: &[(&str, &[f64])]) -> Result<CompleteTable, RecordingError> {
        let slow = ["temp".to_string()];
        let roles = Roles {
            time: Some("t"),
            mask: Some("ok"),
            slow: &slow,
        };
        bridge(Path::new("a.csv"), table(columns), roles)
    }

    #[test]
    fn rows_that_lack_a_value_are_left_out_and_bridged() {
        let found = bridged(&[
            ("t", &[0.0, 1.0, 2.0, NONE, 4.0, 5.0]),
            ("q", &[0.0, NONE, NONE, 3.0, 4.0, 5.0]),
            ("temp", &[20.0, NONE, NONE, NONE, NONE, 25.0]),
        ])
        .unwrap();
        assert_eq!(
            found.valid,
            Some(vec![true, false, false, false, true, true])
        );
        assert_eq!(found.table.data[0], [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(found.table.data[1], [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(found.table.data[2], [20.0, 21.0, 22.0, 23.0, 24.0, 25.0]);
        let missing = found.missing.unwrap();
        assert_eq!((missing.rows, missing.of), (3, 6));
        let cells: Vec<usize> = missing.columns.iter().map(|c| c.cells).collect();
        assert_eq!(cells, [1, 2, 4]);
    }

    #[test]
    fn slow_channels_leave_every_row() {
        let found = bridged(&[("q", &[0.0, 1.0, 2.0]), ("temp", &[20.0, NONE, 22.0])]).unwrap();
        assert_eq!(found.valid, None);
        assert_eq!(found.missing.unwrap().rows, 0);
    }

    #[test]
    fn an_empty_end_is_no_row_and_stamps_beyond_the_known_ones_increase() {
        let found = bridged(&[
            ("t", &[NONE, 1.0, 2.0, 3.0, NONE, NONE]),
            ("q", &[0.0, 1.0, 2.0, 3.0, 4.0, NONE]),
        ])
        .unwrap();
        assert_eq!(found.table.data[0], [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(found.table.data[1].len(), 5);
    }

    #[test]
    fn an_empty_mask_leaves_its_row_out() {
        let found = bridged(&[("q", &[0.0, 1.0, 2.0]), ("ok", &[1.0, NONE, 1.0])]).unwrap();
        assert_eq!(found.table.data[1], [1.0, 0.0, 1.0]);
    }

    #[test]
    fn what_would_be_invented_is_refused() {
        let none = bridged(&[("q", &[0.0, 1.0, 2.0]), ("i", &[NONE, NONE, NONE])]).unwrap_err();
        assert_eq!(none.kind, RecordingErrorKind::EmptyColumn { rows: 3 });
        assert_eq!(none.place.key.as_deref(), Some("i"));
        let most = bridged(&[
            ("q", &[NONE, 1.0, 2.0, 3.0]),
            ("i", &[0.0, NONE, NONE, 3.0]),
        ]);
        let kind = RecordingErrorKind::TooManyMissing {
            rows: 3,
            of: 4,
            cells: 2,
        };
        assert_eq!(most.unwrap_err().kind, kind);
        assert!(bridged(&[("q", &[0.0, f64::INFINITY, 2.0])]).is_err());
    }
}
