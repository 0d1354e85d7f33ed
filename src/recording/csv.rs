//! Comma-, semicolon- or tab-separated text with one header line, plain or gzip-compressed, read
//! line by line so that memory holds the wanted columns and one line.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind, excerpt};
use crate::recording::table::{Table, from_io, require_rows};

/// Longest line, bytes: 40 000 columns of 25 characters. A longer one is not a table of numbers,
/// and reading on would take memory without bound.
const LINE_LIMIT: usize = 1 << 20;

/// Most blank lines at the end of a file: an editor leaves a few, and without end they would be read on
/// and on.
const MOST_BLANK_LINES: usize = 10_000;

/// Read-ahead, bytes: large enough that the cost of a system call vanishes.
const BUFFER: usize = 1 << 18;

/// Column names of a text file.
pub fn columns(path: &Path) -> Result<Vec<String>, RecordingError> {
    let mut lines = Lines::plain(path)?;
    Ok(read_header(&mut lines)?.names)
}

/// Column names of a gzip-compressed text file.
pub fn columns_gzip(path: &Path) -> Result<Vec<String>, RecordingError> {
    let mut lines = Lines::gzip(path)?;
    Ok(read_header(&mut lines)?.names)
}

/// The wanted columns of a text file.
pub fn read(path: &Path, wanted: &[String]) -> Result<Table, RecordingError> {
    read_rows(Lines::plain(path)?, wanted)
}

/// The wanted columns of a gzip-compressed text file.
pub fn read_gzip(path: &Path, wanted: &[String]) -> Result<Table, RecordingError> {
    read_rows(Lines::gzip(path)?, wanted)
}

/// The lines of a file, one at a time, of bounded length.
struct Lines<'p> {
    path: &'p Path,
    reader: BufReader<Box<dyn Read>>,
    buffer: Vec<u8>,
    /// Number of the line in the buffer, from 1.
    number: usize,
}

impl<'p> Lines<'p> {
    fn plain(path: &'p Path) -> Result<Self, RecordingError> {
        let file = File::open(path).map_err(|error| from_io(Place::file(path), &error))?;
        Ok(Self::new(path, Box::new(file)))
    }

    fn gzip(path: &'p Path) -> Result<Self, RecordingError> {
        let file = File::open(path).map_err(|error| from_io(Place::file(path), &error))?;
        let file = BufReader::with_capacity(BUFFER, file);
        Ok(Self::new(path, Box::new(MultiGzDecoder::new(file))))
    }

    fn new(path: &'p Path, source: Box<dyn Read>) -> Self {
        Self {
            path,
            reader: BufReader::with_capacity(BUFFER, source),
            buffer: Vec::new(),
            number: 0,
        }
    }

    fn place(&self) -> Place {
        Place::file(self.path).line(self.number)
    }

    fn fault(&self, kind: RecordingErrorKind) -> RecordingError {
        RecordingError::new(self.place(), kind)
    }

    /// The next line without its end; None at the end of the file.
    fn next(&mut self) -> Result<Option<&str>, RecordingError> {
        self.buffer.clear();
        self.number += 1;
        // One byte above the limit tells a line that is too long from one that just fits.
        let mut bounded = self.reader.by_ref().take(LINE_LIMIT as u64 + 1);
        if let Err(error) = bounded.read_until(b'\n', &mut self.buffer) {
            return Err(self.stream_fault(&error));
        }
        if self.buffer.is_empty() {
            return Ok(None);
        }
        if self.buffer.contains(&0) {
            return Err(self.fault(RecordingErrorKind::NulByte));
        }
        if self.buffer.len() > LINE_LIMIT {
            return Err(self.fault(RecordingErrorKind::LineTooLong { limit: LINE_LIMIT }));
        }
        if std::str::from_utf8(&self.buffer).is_err() {
            // Latin-1, in which every byte is the character of its number: no other text is written so.
            let text: String = self.buffer.iter().map(|&byte| char::from(byte)).collect();
            self.buffer = text.into_bytes();
        }
        let line = std::str::from_utf8(&self.buffer).unwrap_or_default();
        Ok(Some(line.trim_end_matches(['\n', '\r'])))
    }

    /// A plain file fails by its medium, a compressed one mostly by its content.
    fn stream_fault(&self, error: &std::io::Error) -> RecordingError {
        match error.kind() {
            ErrorKind::UnexpectedEof => self.fault(RecordingErrorKind::TruncatedGzip),
            ErrorKind::InvalidData | ErrorKind::InvalidInput => {
                self.fault(RecordingErrorKind::CorruptGzip {
                    reason: error.to_string(),
                })
            }
            _ => from_io(self.place(), error),
        }
    }
}

struct Header {
    /// Their positions from 1 where the file has no names.
    names: Vec<String>,
    separator: u8,
    /// The first line where it holds numbers.
    first_row: Option<String>,
}

/// Reads the first line: `#` before it (as NumPy writes) and a byte-order mark are passed over.
fn read_header(lines: &mut Lines) -> Result<Header, RecordingError> {
    let line = match lines.next()? {
        Some(line) => line.trim_start_matches('\u{feff}').trim_start_matches('#'),
        None => {
            let kind = RecordingErrorKind::EmptyFile;
            return Err(RecordingError::new(Place::file(lines.path), kind));
        }
    };
    let separator = separator_of(line);
    let names: Vec<String> = line
        .split(separator as char)
        .map(|field| bare(field).to_string())
        .collect();
    if names.iter().all(String::is_empty) {
        return Err(lines.fault(RecordingErrorKind::EmptyFile));
    }
    if names.iter().all(|name| name.parse::<f64>().is_ok()) {
        return Ok(Header {
            first_row: Some(line.to_string()),
            names: (1..=names.len()).map(|n| n.to_string()).collect(),
            separator,
        });
    }
    let mut seen = HashSet::new();
    for (column, name) in names.iter().enumerate() {
        if !name.is_empty() && !seen.insert(name) {
            let place = lines.place().column(column + 1);
            let name = excerpt(name);
            let kind = RecordingErrorKind::DuplicateColumn { name };
            return Err(RecordingError::new(place, kind));
        }
    }
    Ok(Header {
        names,
        separator,
        first_row: None,
    })
}

/// The separator that occurs most often in the header; a comma where none does.
fn separator_of(header: &str) -> u8 {
    let count = |separator: u8| header.bytes().filter(|&byte| byte == separator).count();
    let mut best = b',';
    for candidate in *b";\t" {
        if count(candidate) > count(best) {
            best = candidate;
        }
    }
    best
}

/// A field without the blanks and quotation marks around it.
fn bare(field: &str) -> &str {
    let field = field.trim_ascii();
    field
        .strip_prefix('"')
        .and_then(|field| field.strip_suffix('"'))
        .unwrap_or(field)
}

fn read_rows(mut lines: Lines, wanted: &[String]) -> Result<Table, RecordingError> {
    let path = lines.path;
    let header = read_header(&mut lines)?;
    // Where each column of the file goes: None for those that are not wanted.
    let target: Vec<Option<usize>> = header
        .names
        .iter()
        .map(|name| wanted.iter().position(|column| column == name))
        .collect();
    let mut data: Vec<Vec<f64>> = vec![Vec::new(); wanted.len()];
    let mut append = |line: &str, number: usize| {
        append_row(line, header.separator, &target, &mut data).map_err(|fault| {
            let mut place = Place::file(path).line(number);
            if let Some(column) = fault.column {
                place = place.column(column + 1).key(&header.names[column]);
            }
            RecordingError::new(place, fault.kind)
        })
    };
    let mut first_line = lines.number + 1;
    if let Some(row) = &header.first_row {
        append(row, lines.number)?;
        first_line = lines.number;
    }
    loop {
        let number = lines.number + 1;
        let Some(line) = lines.next()? else { break };
        if number == first_line && is_units(line, header.separator) {
            first_line += 1;
            continue;
        }
        if line.trim_ascii().is_empty() {
            require_end(&mut lines, header.names.len())?;
            break;
        }
        append(line, number)?;
    }
    require_rows(path, data.first().map_or(0, Vec::len))?;
    data.iter_mut().for_each(Vec::shrink_to_fit);
    Ok(Table {
        columns: wanted.to_vec(),
        data,
        first_line,
    })
}

/// Whether a row holds words and no numbers, as of units under the names.
fn is_units(line: &str, separator: u8) -> bool {
    let mut fields = line.split(separator as char).map(bare);
    let is_word = |field: &str| number(field, separator).is_err() && field.parse::<f64>().is_err();
    !line.trim_ascii().is_empty() && fields.all(is_word)
}

/// Blank lines are fine at the end of a file; before further rows they are torn rows.
fn require_end(lines: &mut Lines, expected: usize) -> Result<(), RecordingError> {
    let blank = lines.place();
    let mut count = 1;
    while let Some(line) = lines.next()? {
        count += 1;
        if !line.trim_ascii().is_empty() || count > MOST_BLANK_LINES {
            let kind = RecordingErrorKind::WrongFieldCount { found: 0, expected };
            return Err(RecordingError::new(blank, kind));
        }
    }
    Ok(())
}

struct RowFault {
    column: Option<usize>,
    kind: RecordingErrorKind,
}

fn append_row(
    line: &str,
    separator: u8,
    target: &[Option<usize>],
    data: &mut [Vec<f64>],
) -> Result<(), RowFault> {
    let mut found = 0;
    for field in line.split(separator as char) {
        if let Some(&Some(slot)) = target.get(found) {
            let value = number(field, separator).map_err(|kind| RowFault {
                column: Some(found),
                kind,
            })?;
            data[slot].push(value);
        }
        found += 1;
    }
    if found == target.len() {
        return Ok(());
    }
    Err(RowFault {
        column: None,
        kind: RecordingErrorKind::WrongFieldCount {
            found,
            expected: target.len(),
        },
    })
}

/// A number, with a decimal comma where commas do not separate fields.
fn number(field: &str, separator: u8) -> Result<f64, RecordingErrorKind> {
    let field = bare(field);
    let with_comma = || match separator == b',' || field.contains('.') {
        true => None,
        false => field.replacen(',', ".", 1).parse().ok(),
    };
    match field.parse::<f64>().ok().or_else(with_comma) {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(RecordingErrorKind::NotFinite {
            found: excerpt(field),
        }),
        None => Err(RecordingErrorKind::NotANumber {
            found: excerpt(field),
        }),
    }
}
