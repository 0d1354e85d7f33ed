//! Parquet files: every numeric column by its name; fields of a structure are named `structure.field`, elements of a list
//! `list1`, `list2`, ... Time stamps of a date become seconds since the first row.

use std::collections::HashMap;
use std::collections::hash_map::Entry as Slot;
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
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::arrow_schema;
use crate::recording::formats::reading::Reading;
use crate::recording::formats::reading::from_io;
use crate::recording::formats::table::{Origin, Table, require_rows};

type Reader = SerializedFileReader<File>;

/// Rows decoded at a time.
const BATCH: usize = 8192;

/// Column names of a file.
pub fn columns(path: &Path, reading: &Reading) -> Result<Vec<String>, RecordingError> {
    reading.goes_on(path)?;
    let reader = open(path)?;
    let mut names = Vec::new();
    for channel in channels(&reader) {
        match channel.slot {
            None => names.push(channel.name),
            Some(slot) => {
                let length = first_length(&reader, &channel, slot);
                let length = length.map_err(|error| {
                    corrupt(Place::file(path).key(&channel.name), &error.to_string())
                })?;
                names.extend((1..=length).map(|n| format!("{}{n}", channel.name)));
            }
        }
    }
    Ok(names)
}

/// The wanted columns of a file.
pub fn read(path: &Path, wanted: &[String], reading: &Reading) -> Result<Table, RecordingError> {
    let reader = open(path)?;
    let rows = reader.metadata().file_metadata().num_rows();
    reading.takes_rows(path, usize::try_from(rows).unwrap_or(0))?;
    let channels = channels(&reader);
    let mut lists: HashMap<usize, Vec<Vec<f64>>> = HashMap::new();
    let mut data = Vec::with_capacity(wanted.len());
    let mut origins = Vec::new();
    for name in wanted {
        reading.goes_on(path)?;
        let place = || Place::file(path).key(name.as_str());
        let fault = |error: ParquetError| corrupt(place(), &error.to_string());
        let mut named = channels.iter().filter_map(|c| Some((c, c.element(name)?)));
        let (channel, element) = match (named.next(), named.next()) {
            (Some(found), None) => found,
            (Some(_), Some(_)) => {
                let kind = RecordingErrorKind::DuplicateColumn { name: name.clone() };
                return Err(RecordingError::new(place(), kind));
            }
            (None, _) => return Err(corrupt(place(), "the column is gone")),
        };
        let Some(slot) = channel.slot else {
            let (values, origin) = read_channel(&reader, channel).map_err(fault)?;
            origins.extend(origin.map(|nanoseconds| Origin {
                column: name.clone(),
                nanoseconds,
            }));
            data.push(values);
            continue;
        };
        let list = match lists.entry(channel.index) {
            Slot::Occupied(list) => list.into_mut(),
            Slot::Vacant(empty) => empty.insert(read_list(&reader, channel, slot).map_err(fault)?),
        };
        let column = list.get_mut(element).map(std::mem::take);
        data.push(column.ok_or_else(|| corrupt(place(), "the element is gone"))?);
    }
    require_rows(path, data.first().map_or(0, Vec::len))?;
    Ok(Table {
        columns: wanted.to_vec(),
        data,
        first_line: 1,
        lines: None,
        origins,
    })
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
    /// Of a column of lists, the definition level of an element that may be absent.
    slot: Option<i16>,
    /// Parts of a second in one unit, where the column holds dates.
    ticks_per_second: Option<i64>,
    unsigned: bool,
    /// Parts of a second in one unit, where the column holds durations.
    duration: Option<i64>,
}

fn channels(reader: &Reader) -> Vec<Channel> {
    let metadata = reader.metadata().file_metadata();
    let schema = metadata.schema_descr();
    let keys = metadata.key_value_metadata().map_or(&[][..], Vec::as_slice);
    let arrow = keys.iter().find(|pair| pair.key == arrow_schema::KEY);
    let arrow = arrow.and_then(|pair| pair.value.as_deref());
    let durations = arrow.map(arrow_schema::durations).unwrap_or_default();
    let described = schema.columns().iter().enumerate();
    described
        .filter(|(_, column)| is_numeric(column))
        .map(|(index, column)| Channel {
            name: name_of(column),
            index,
            deepest: column.max_def_level(),
            slot: (column.max_rep_level() == 1).then(|| {
                let may_be_absent = column.self_type().is_optional();
                column.max_def_level() - i16::from(may_be_absent)
            }),
            ticks_per_second: ticks_per_second(column),
            unsigned: matches!(
                column.logical_type_ref(),
                Some(LogicalType::Integer(kind)) if !kind.is_signed
            ),
            duration: durations.get(&name_of(column)).copied(),
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
    stored && !scaled && (column.max_rep_level() == 0 || is_list(column))
}

/// Whether the column is a list of numbers, in the layouts that Parquet has had for one.
fn is_list(column: &ColumnDescriptor) -> bool {
    let ends = [
        ["list", "element"],
        ["list", "item"],
        ["bag", "array_element"],
    ];
    let end = column.path().parts().iter().rev().take(2).rev();
    column.max_rep_level() == 1 && ends.iter().any(|words| end.clone().eq(words))
}

/// The name of a column; of a list without what the layout adds.
fn name_of(column: &ColumnDescriptor) -> String {
    let parts = column.path().parts();
    let added = if is_list(column) { 2 } else { 0 };
    parts[..parts.len() - added].join(".")
}

impl Channel {
    /// The element from 0 that a column name stands for; 0 of a channel that is no list.
    fn element(&self, name: &str) -> Option<usize> {
        let rest = name.strip_prefix(self.name.as_str())?;
        if self.slot.is_none() {
            return rest.is_empty().then_some(0);
        }
        let number: usize = rest.parse().ok()?;
        (number > 0 && rest == number.to_string()).then(|| number - 1)
    }

    fn number(&self, x: i64) -> f64 {
        match self.duration {
            Some(ticks) => x as f64 / ticks as f64,
            None if self.unsigned => x.cast_unsigned() as f64,
            None => x as f64,
        }
    }
}

/// Longest list, as of the channels of an array.
const MOST_ELEMENTS: usize = 10_000;

/// Elements of the first list of a column.
fn first_length(reader: &Reader, channel: &Channel, slot: i16) -> Result<usize, ParquetError> {
    let mut length = 0;
    for group in 0..reader.num_row_groups().min(1) {
        let slots = Slots {
            channel,
            slot,
            most: 1,
        };
        let rows = slots.read_group(reader, group, |row, _| length += usize::from(row == 1));
        rows?;
    }
    Ok(length.min(MOST_ELEMENTS))
}

/// The elements of a column of lists, one series for each; a list that is absent lacks all of them.
fn read_list(reader: &Reader, channel: &Channel, slot: i16) -> Result<Vec<Vec<f64>>, ParquetError> {
    let mut rows: Vec<(usize, usize)> = Vec::new();
    let mut values: Vec<f64> = Vec::new();
    let mut before = 0;
    for group in 0..reader.num_row_groups() {
        let slots = Slots {
            channel,
            slot,
            most: usize::MAX,
        };
        let count = slots.read_group(reader, group, |row, value| {
            let row = before + row;
            if rows.len() < row {
                rows.resize(row, (values.len(), values.len()));
                rows[row - 1] = (values.len(), values.len());
            }
            values.push(value);
            rows[row - 1].1 = values.len();
        })?;
        before += count;
        rows.resize(before, (values.len(), values.len()));
    }
    let length = rows
        .iter()
        .map(|(a, b)| b - a)
        .find(|n| *n > 0)
        .unwrap_or(0);
    let odd = rows
        .iter()
        .position(|(a, b)| ![0, length].contains(&(b - a)));
    if let Some(row) = odd {
        let found = rows[row].1 - rows[row].0;
        return Err(ParquetError::General(format!(
            "the list of row {} has {found} elements and the first {length}",
            row + 1
        )));
    }
    let element = |k: usize| {
        let of_row = |&(a, b): &(usize, usize)| if a < b { values[a + k] } else { f64::NAN };
        rows.iter().map(of_row).collect()
    };
    Ok((0..length.min(MOST_ELEMENTS)).map(element).collect())
}

/// How the elements of lists are told from lists that are empty or absent.
struct Slots<'a> {
    channel: &'a Channel,
    slot: i16,
    /// Rows that are read at most.
    most: usize,
}

impl Slots<'_> {
    /// Hands over the elements of the lists of one row group with the number of their row from 1; gives the number of
    /// rows.
    fn read_group(
        &self,
        reader: &Reader,
        group: usize,
        mut take: impl FnMut(usize, f64),
    ) -> Result<usize, ParquetError> {
        let group = reader.get_row_group(group)?;
        let channel = self.channel;
        match group.get_column_reader(channel.index)? {
            ColumnReader::BoolColumnReader(c) => {
                self.read(c, |x| f64::from(u8::from(x)), &mut take)
            }
            ColumnReader::Int32ColumnReader(c) => {
                self.read(c, |x| channel.number(x.into()), &mut take)
            }
            ColumnReader::Int64ColumnReader(c) => self.read(c, |x| channel.number(x), &mut take),
            ColumnReader::FloatColumnReader(c) => self.read(c, f64::from, &mut take),
            ColumnReader::DoubleColumnReader(c) => self.read(c, |x| x, &mut take),
            _ => Err(ParquetError::General("the column holds no numbers".into())),
        }
    }

    fn read<T: DataType>(
        &self,
        mut column: ColumnReaderImpl<T>,
        number: impl Fn(T::T) -> f64,
        take: &mut impl FnMut(usize, f64),
    ) -> Result<usize, ParquetError> {
        let (mut levels, mut starts, mut present) = (Vec::new(), Vec::new(), Vec::new());
        let mut rows = 0;
        loop {
            levels.clear();
            starts.clear();
            present.clear();
            let batch = BATCH.min(self.most - rows.min(self.most));
            let (records, ..) =
                column.read_records(batch, Some(&mut levels), Some(&mut starts), &mut present)?;
            if records == 0 {
                return Ok(rows);
            }
            let mut present = present.drain(..).map(&number);
            for (&level, &start) in levels.iter().zip(&starts) {
                rows += usize::from(start == 0);
                if level == self.channel.deepest {
                    take(rows, present.next().unwrap_or(f64::NAN));
                } else if level >= self.slot {
                    take(rows, f64::NAN);
                }
            }
        }
    }
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

/// All values of a column, a null is NaN; and of dates when the first of them is, ns since 1970.
fn read_channel(
    reader: &Reader,
    channel: &Channel,
) -> Result<(Vec<f64>, Option<i64>), ParquetError> {
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
                        None => channel.number(x),
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
    let nanoseconds = |(origin, ticks): (i64, i64)| origin.wrapping_mul(1_000_000_000 / ticks);
    Ok((
        values,
        origin.zip(channel.ticks_per_second).map(nanoseconds),
    ))
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
