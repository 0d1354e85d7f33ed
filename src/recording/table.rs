//! A table of numbers with named columns, and the file formats that hold one.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use crate::fault::Place;
use crate::recording::bag::{mcap, ros1, sqlite};
use crate::recording::csv;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::reading::{Reading, Stop};
use crate::recording::{hdf5, mat, npz, parquet};

/// The wanted columns of a file, column by column; a cell without a number is NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
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

/// One file format: how its files are called and read.
pub struct Format {
    /// End of the file name with the dot, in lower case.
    pub extension: &'static str,
    /// Names of all columns, without reading the rows.
    pub columns: fn(&Path, &Reading) -> Result<Vec<String>, RecordingError>,
    /// The named columns, which all exist.
    pub read: fn(&Path, &[String], &Reading) -> Result<Table, RecordingError>,
}

impl Format {
    const fn text(extension: &'static str) -> Self {
        Self {
            extension,
            columns: csv::columns,
            read: csv::read,
        }
    }

    /// Text that is compressed.
    const fn packed(extension: &'static str) -> Self {
        Self {
            extension,
            columns: csv::columns_packed,
            read: csv::read_packed,
        }
    }
}

/// The known formats.
pub const FORMATS: &[Format] = &[
    Format::text(".csv"),
    Format::text(".tsv"),
    Format::text(".txt"),
    Format::text(".dat"),
    Format::packed(".csv.gz"),
    Format::packed(".tsv.gz"),
    Format::packed(".txt.gz"),
    Format::packed(".csv.bz2"),
    Format::packed(".csv.zst"),
    Format {
        extension: ".parquet",
        columns: parquet::columns,
        read: parquet::read,
    },
    Format {
        extension: ".npz",
        columns: npz::columns,
        read: npz::read,
    },
    Format {
        extension: ".mat",
        columns: mat::columns,
        read: mat::read,
    },
    Format {
        extension: ".h5",
        columns: hdf5::columns,
        read: hdf5::read,
    },
    Format {
        extension: ".hdf5",
        columns: hdf5::columns,
        read: hdf5::read,
    },
    Format {
        extension: ".mcap",
        columns: mcap::columns,
        read: mcap::read,
    },
    Format {
        extension: ".bag",
        columns: ros1::columns,
        read: ros1::read,
    },
    Format {
        extension: ".db3",
        columns: sqlite::columns,
        read: sqlite::read,
    },
];

/// The format of a file by the end of its name, after a look whether the file is there at all.
///
/// Errors: not found, a directory, no permission, unknown extension.
pub fn format_of(path: &Path) -> Result<&'static Format, RecordingError> {
    let at = || Place::file(path);
    let metadata = fs::metadata(path).map_err(|error| from_io(at(), &error))?;
    if metadata.is_dir() {
        return Err(RecordingError::new(at(), RecordingErrorKind::IsDirectory));
    }
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    FORMATS
        .iter()
        .find(|format| name.ends_with(format.extension))
        .ok_or_else(|| {
            let found = name
                .find('.')
                .map_or(String::new(), |dot| name[dot..].into());
            let kind = RecordingErrorKind::UnknownExtension { found };
            RecordingError::new(at(), kind)
        })
}

/// Names of all columns of a file, or of the arrays in memory that stand under its path.
///
/// Errors: as [`format_of`]; those of the format.
pub fn columns_at(path: &Path, reading: &Reading) -> Result<Vec<String>, RecordingError> {
    match reading.memory.at(path) {
        Some(arrays) => arrays.columns(path, reading),
        None => (format_of(path)?.columns)(path, reading),
    }
}

/// The named columns, which all exist, of a file or of the arrays in memory that stand under its path.
///
/// Errors: as [`columns_at`].
pub fn read_at(path: &Path, wanted: &[String], reading: &Reading) -> Result<Table, RecordingError> {
    match reading.memory.at(path) {
        Some(arrays) => arrays.read(path, wanted, reading),
        None => (format_of(path)?.read)(path, wanted, reading),
    }
}

/// Fails unless the table has the least number of rows.
pub(super) fn require_rows(path: &Path, rows: usize) -> Result<(), RecordingError> {
    if rows >= LEAST_ROWS {
        return Ok(());
    }
    let kind = RecordingErrorKind::TooFewRows {
        found: rows,
        least: LEAST_ROWS,
    };
    Err(RecordingError::new(Place::file(path), kind))
}

/// The recording error of an error of the operating system.
pub(super) fn from_io(place: Place, error: &std::io::Error) -> RecordingError {
    if let Some(stop) = Stop::of(error) {
        return stop.at(place);
    }
    let kind = match error.kind() {
        ErrorKind::NotFound => RecordingErrorKind::NotFound,
        ErrorKind::PermissionDenied => RecordingErrorKind::NoPermission,
        ErrorKind::IsADirectory => RecordingErrorKind::IsDirectory,
        _ => RecordingErrorKind::Unreadable {
            reason: error.to_string(),
        },
    };
    RecordingError::new(place, kind)
}
