//! The file formats of recordings, told by the ends of names.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
#[cfg(feature = "bags")]
use crate::recording::formats::bag::{mcap, ros1, sqlite};
#[cfg(feature = "compression")]
use crate::recording::formats::compressed;
use crate::recording::formats::csv;
#[cfg(feature = "npz")]
use crate::recording::formats::npz;
#[cfg(feature = "parquet")]
use crate::recording::formats::parquet;
use crate::recording::formats::reading::{Reading, from_io};
use crate::recording::formats::table::Table;
#[cfg(feature = "hdf5")]
use crate::recording::formats::{hdf5, mat};

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

    #[cfg(feature = "compression")]
    const fn compressed(extension: &'static str) -> Self {
        Self {
            extension,
            columns: compressed::columns,
            read: compressed::read,
        }
    }
}

/// The known formats: those of the features that the library is built with.
pub const FORMATS: &[Format] = &[
    Format::text(".csv"),
    Format::text(".tsv"),
    Format::text(".txt"),
    Format::text(".dat"),
    #[cfg(feature = "compression")]
    Format::compressed(".csv.gz"),
    #[cfg(feature = "compression")]
    Format::compressed(".tsv.gz"),
    #[cfg(feature = "compression")]
    Format::compressed(".txt.gz"),
    #[cfg(feature = "compression")]
    Format::compressed(".csv.bz2"),
    #[cfg(feature = "compression")]
    Format::compressed(".csv.zst"),
    #[cfg(feature = "parquet")]
    Format {
        extension: ".parquet",
        columns: parquet::columns,
        read: parquet::read,
    },
    #[cfg(feature = "npz")]
    Format {
        extension: ".npz",
        columns: npz::columns,
        read: npz::read,
    },
    #[cfg(feature = "hdf5")]
    Format {
        extension: ".mat",
        columns: mat::columns,
        read: mat::read,
    },
    #[cfg(feature = "hdf5")]
    Format {
        extension: ".h5",
        columns: hdf5::columns,
        read: hdf5::read,
    },
    #[cfg(feature = "hdf5")]
    Format {
        extension: ".hdf5",
        columns: hdf5::columns,
        read: hdf5::read,
    },
    #[cfg(feature = "bags")]
    Format {
        extension: ".mcap",
        columns: mcap::columns,
        read: mcap::read,
    },
    #[cfg(feature = "bags")]
    Format {
        extension: ".bag",
        columns: ros1::columns,
        read: ros1::read,
    },
    #[cfg(feature = "bags")]
    Format {
        extension: ".db3",
        columns: sqlite::columns,
        read: sqlite::read,
    },
];

/// Ends of the names of all of them, for people.
static KNOWN_EXTENSIONS: LazyLock<String> = LazyLock::new(|| {
    let all: Vec<&str> = FORMATS.iter().map(|format| format.extension).collect();
    all.join(", ")
});

/// The format of a file by the end of its name, after a look whether the file is there at all.
///
/// Errors: not found, a directory, a pipe, no permission, unknown extension.
pub fn format_of(path: &Path) -> Result<&'static Format, RecordingError> {
    let at = || Place::file(path);
    let metadata = fs::metadata(path).map_err(|error| from_io(at(), &error))?;
    if metadata.is_dir() {
        return Err(RecordingError::new(at(), RecordingErrorKind::IsDirectory));
    }
    if !metadata.is_file() {
        return Err(RecordingError::new(at(), RecordingErrorKind::IsPipe));
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
            let known = KNOWN_EXTENSIONS.as_str();
            let kind = RecordingErrorKind::UnknownExtension { found, known };
            RecordingError::new(at(), kind)
        })
}

/// Names of all columns of a file, or of the arrays in memory that stand under its path.
///
/// Errors: as [`format_of`]; those of the format.
pub fn columns_at(path: &Path, reading: &Reading) -> Result<Vec<String>, RecordingError> {
    match reading.memory.at(path) {
        Some(arrays) => {
            reading.goes_on(path)?;
            Ok(arrays.columns())
        }
        None => (format_of(path)?.columns)(path, reading),
    }
}

/// The named columns, which all exist, of a file or of the arrays in memory that stand under its path.
///
/// Errors: as [`columns_at`].
pub fn read_at(path: &Path, wanted: &[String], reading: &Reading) -> Result<Table, RecordingError> {
    match reading.memory.at(path) {
        Some(arrays) => {
            let table = arrays.read(path, wanted)?;
            reading.takes_rows(path, table.rows())?;
            Ok(table)
        }
        None => (format_of(path)?.read)(path, wanted, reading),
    }
}
