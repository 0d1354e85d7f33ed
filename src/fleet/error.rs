//! Why a fleet as a whole cannot be worked on; faults of single items are set aside with them.

use crate::fault::{Description, Fault, Place, write_fault};
use std::fmt;
use std::path::Path;

/// A fault of the manifest, of the folder of items or of the scratch database.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FleetError {
    /// The file with line or column where these are known.
    pub place: Place,
    /// What is wrong there.
    pub kind: FleetErrorKind,
}

/// What happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FleetErrorKind {
    /// The file ends in something else than the three known formats.
    UnknownFormat,
    /// The file cannot be opened or read.
    NotRead {
        /// What the system says.
        reason: String,
    },
    /// The file is not of the format that its name says.
    NotParsed {
        /// What its reader says.
        reason: String,
    },
    /// The table lacks a column that it needs.
    MissingColumn {
        /// Name of the column.
        name: &'static str,
        /// Names of those that it has.
        found: Box<str>,
    },
    /// The table has a column that means nothing here.
    UnknownColumn {
        /// Its name.
        name: Box<str>,
        /// The known name most like it.
        nearest: Option<&'static str>,
    },
    /// A cell does not hold what its column asks for.
    BadCell {
        /// As written.
        found: Box<str>,
        /// What it should hold, in words.
        expected: &'static str,
    },
    /// The table has no row.
    Empty,
    /// The folder of items.
    NotWritten {
        /// What the system says.
        reason: String,
    },
    /// The database in which results are sorted.
    NotSorted {
        /// What the database says.
        reason: String,
    },
    /// The table of results.
    TableNotWritten {
        /// What its writer says.
        reason: String,
    },
}

impl FleetError {
    /// A fault at a place.
    pub fn new(place: Place, kind: FleetErrorKind) -> Self {
        Self { place, kind }
    }

    /// A file that cannot be read.
    pub fn not_read(file: &Path, reason: &impl fmt::Display) -> Self {
        let reason = reason.to_string();
        Self::new(Place::file(file), FleetErrorKind::NotRead { reason })
    }

    /// A place in a file that cannot be understood.
    pub fn not_parsed(place: Place, reason: &impl fmt::Display) -> Self {
        let reason = reason.to_string().trim_end().replace('\n', ", ");
        Self::new(place, FleetErrorKind::NotParsed { reason })
    }

    /// A file of the folder of items that cannot be written.
    pub fn not_written(file: &Path, reason: &impl fmt::Display) -> Self {
        let reason = reason.to_string();
        Self::new(Place::file(file), FleetErrorKind::NotWritten { reason })
    }

    /// The temporary database fails.
    pub fn not_sorted(reason: &impl fmt::Display) -> Self {
        let reason = reason.to_string();
        Self::new(
            Place::file("the temporary database"),
            FleetErrorKind::NotSorted { reason },
        )
    }

    /// The table of results cannot be written.
    pub fn table_not_written(reason: &impl fmt::Display) -> Self {
        let reason = reason.to_string();
        Self::new(
            Place::file(super::settings::TABLE_FILE),
            FleetErrorKind::TableNotWritten { reason },
        )
    }
}

impl From<rusqlite::Error> for FleetError {
    fn from(error: rusqlite::Error) -> Self {
        Self::not_sorted(&error)
    }
}

impl From<parquet::errors::ParquetError> for FleetError {
    fn from(error: parquet::errors::ParquetError) -> Self {
        Self::table_not_written(&error)
    }
}

impl Fault for FleetError {
    fn place(&self) -> &Place {
        &self.place
    }

    fn describe(&self) -> Description {
        match &self.kind {
            FleetErrorKind::UnknownFormat => Description::new(
                "unknown-manifest",
                "the manifest is of no known format",
                "give a file that ends in .csv, .parquet or .toml",
            ),
            FleetErrorKind::NotRead { reason } => Description::new(
                "manifest-not-readable",
                format!("cannot be read: {reason}"),
                "check the path and its permissions",
            ),
            FleetErrorKind::NotParsed { reason } => Description::new(
                "manifest-not-parsed",
                format!("is no manifest: {reason}"),
                "write one row or [[item]] for each recording, with robot, recordings, problem and time",
            ),
            FleetErrorKind::MissingColumn { name, found } => Description::new(
                "manifest-column-missing",
                format!("there is no `{name}`; found: {found}"),
                format!("add `{name}`"),
            ),
            FleetErrorKind::UnknownColumn { name, nearest } => Description::new(
                "manifest-column-unknown",
                format!("`{name}` is not known"),
                match nearest {
                    Some(nearest) => format!("did you mean `{nearest}`?"),
                    None => "leave it out".to_string(),
                },
            ),
            FleetErrorKind::BadCell { found, expected } => Description::new(
                "manifest-cell",
                format!("found `{found}`, expected {expected}"),
                "correct the manifest",
            ),
            FleetErrorKind::Empty => Description::new(
                "manifest-empty",
                "the manifest has no items",
                "write one row or [[item]] for each recording",
            ),
            FleetErrorKind::NotWritten { reason } => Description::new(
                "items-not-written",
                format!("results of items cannot be kept: {reason}"),
                "check the free space and the permissions, or give another folder with --items",
            ),
            FleetErrorKind::NotSorted { reason } => Description::new(
                "results-not-sorted",
                format!("results cannot be sorted: {reason}"),
                "check the free space of the folder for temporary files, or set TMPDIR to another; results of items are kept",
            ),
            FleetErrorKind::TableNotWritten { reason } => Description::new(
                "table-not-written",
                format!("the table cannot be written: {reason}"),
                "check the free space; results of items are kept",
            ),
        }
    }
}

impl fmt::Display for FleetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_fault(f, self)
    }
}

impl std::error::Error for FleetError {}
