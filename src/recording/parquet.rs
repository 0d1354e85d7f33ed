//! Parquet files: every numeric column that is not a list, by its name; fields of a structure are
//! named `structure.field`. Time stamps of a date become seconds since the first row.

use std::fs::File;
use std::path::Path;

use parquet::basic::{LogicalType, TimeUnit, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use crate::fault::Place;
use crate::recording::arrays::require_finite;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::table::{Table, from_io, require_rows};

type Reader = SerializedFileReader<File>;

/// Rows decoded at a time.
const BATCH: usize = 8192;

/// Column names of a file.
pub fn columns(path: &Path) -> Result<Vec<String>, RecordingError> {
    let reader = open(path)?;
    let names = channels(&reader).into_iter().map(|channel| channel.name);
    Ok(names.collect())
}

/// The wanted columns of a file.
pub fn read(path: &Path, wanted: &[String]) -> Result<Table, RecordingError> {
    let reader = open(path)?;
    let channels = channels(&reader);
    let mut data = Vec::with_capacity(wanted.len());
    for name in wanted {
        let mut named = channels.iter().filter(|channel| channel.name == *name);
        let place = || Place::file(path).key(name.as_str());
        let column = match (named.next(), named.next()) {
            (Some(channel), None) => read_channel(&reader, channel)
                .map_err(|error| corrupt(place(), &error.to_string()))?,
            (Some(_), Some(_)) => {
                let kind = RecordingErrorKind::DuplicateColumn { name: name.clone() };
                return Err(RecordingError::new(place(), kind));
            }
            (None, _) => return Err(corrupt(place(), "the column is gone")),
        };
        data.push(column);
    }
    require_rows(path, data.first().map_or(0, Vec::len))?;
    let table = Table {
        columns: wanted.to_vec(),
        data,
        first_line: 1,
    };
    require_finite(path, &table)?;
    Ok(table)
}

fn open(path: &Path) -> Result<Reader, RecordingError> {
    let place = || Place::file(path);
    let file = File::open(path).map_err(|error| from_io(place(), &error))?;
    let reader = SerializedFileReader::new(file);
    let reader = reader.map_err(|error| corrupt(place(), &error.to_string()))?;
    let groups = reader.metadata().row_groups().iter();
    let negative = |chunk: &ColumnChunkMetaData| {
        let dictionary = chunk.dictionary_page_offset().unwrap_or(0);
        dictionary < 0 || chunk.data_page_offset() < 0 || chunk.compressed_size() < 0
    };
    // The library takes these for granted.
    if groups.flat_map(|group| group.columns()).any(negative) {
        return Err(corrupt(place(), "a column lies before the file"));
    }
    Ok(reader)
}

fn corrupt(place: Place, reason: &str) -> RecordingError {
    let kind = RecordingErrorKind::Corrupt {
        format: "Parquet file",
        reason: reason.into(),
    };
    RecordingError::new(place, kind)
}

/// A numeric column.
struct Channel {
    name: String,
    index: usize,
    /// Definition level of a value that is there; 0: none can be absent.
    deepest: i16,
    /// Parts of a second in one unit, where the column holds dates.
    ticks_per_second: Option<i64>,
    unsigned: bool,
}

fn channels(reader: &Reader) -> Vec<Channel> {
    let schema = reader.metadata().file_metadata().schema_descr();
    let described = schema.columns().iter().enumerate();
    described
        .filter(|(_, column)| is_numeric(column))
        .map(|(index, column)| Channel {
            name: column.path().string(),
            index,
            deepest: column.max_def_level(),
            ticks_per_second: ticks_per_second(column),
            unsigned: matches!(
                column.logical_type_ref(),
                Some(LogicalType::Integer(kind)) if !kind.is_signed
            ),
        })
        .collect()
}

fn is_numeric(column: &ColumnDescriptor) -> bool {
    let stored = matches!(
        column.physical_type(),
        Type::BOOLEAN | Type::INT32 | Type::INT64 | Type::FLOAT | Type::DOUBLE
    );
    let scaled = matches!(
        column.logical_type_ref(),
        Some(LogicalType::Decimal(_) | LogicalType::Date | LogicalType::Time(_))
    );
    stored && !scaled && column.max_rep_level() == 0
}

fn ticks_per_second(column: &ColumnDescriptor) -> Option<i64> {
    match column.logical_type_ref() {
        Some(LogicalType::Timestamp(kind)) => Some(match kind.unit {
            TimeUnit::MILLIS => 1_000,
            TimeUnit::MICROS => 1_000_000,
            TimeUnit::NANOS => 1_000_000_000,
        }),
        _ => None,
    }
}

/// All values of a column; a null is NaN.
fn read_channel(reader: &Reader, channel: &Channel) -> Result<Vec<f64>, ParquetError> {
    let mut values = Vec::new();
    let mut origin = None;
    let deepest = channel.deepest;
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group)?;
        match group.get_column_reader(channel.index)? {
            ColumnReader::BoolColumnReader(column) => {
                append(column, deepest, &mut values, |x| f64::from(u8::from(x)))?;
            }
            ColumnReader::Int32ColumnReader(column) => {
                append(column, deepest, &mut values, |x| match channel.unsigned {
                    true => f64::from(x.cast_unsigned()),
                    false => f64::from(x),
                })?;
            }
            ColumnReader::Int64ColumnReader(column) => {
                append(column, deepest, &mut values, |x| {
                    match channel.ticks_per_second {
                        None if channel.unsigned => x.cast_unsigned() as f64,
                        None => x as f64,
                        // Differences of integers first: seconds since 1970 leave no digits for microseconds.
                        Some(ticks) => {
                            let since = x.wrapping_sub(*origin.get_or_insert(x));
                            since as f64 / ticks as f64
                        }
                    }
                })?;
            }
            ColumnReader::FloatColumnReader(column) => {
                append(column, deepest, &mut values, f64::from)?
            }
            ColumnReader::DoubleColumnReader(column) => {
                append(column, deepest, &mut values, |x| x)?
            }
            _ => return Err(ParquetError::General("the column holds no numbers".into())),
        }
    }
    Ok(values)
}

/// Appends the values of one row group, batch by batch.
fn append<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    deepest: i16,
    values: &mut Vec<f64>,
    mut number: impl FnMut(T::T) -> f64,
) -> Result<(), ParquetError> {
    let (mut levels, mut present) = (Vec::new(), Vec::new());
    loop {
        levels.clear();
        present.clear();
        let (rows, ..) = column.read_records(BATCH, Some(&mut levels), None, &mut present)?;
        if rows == 0 {
            return Ok(());
        }
        let mut present = present.drain(..).map(&mut number);
        if deepest == 0 {
            values.extend(present);
            continue;
        }
        for &level in &levels {
            let defined = level == deepest;
            values.push(
                defined
                    .then(|| present.next())
                    .flatten()
                    .unwrap_or(f64::NAN),
            );
        }
    }
}
