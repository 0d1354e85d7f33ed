//! Text separated by commas, semicolons, tabs or blanks, with a line of names, which may be a
//! comment, or without; read line by line so that memory holds the wanted columns and one line.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind, excerpt};
use crate::recording::formats::date;
use crate::recording::formats::encoding::without_mark;
use crate::recording::formats::reading::Reading;
use crate::recording::formats::reading::from_io;
use crate::recording::formats::table::{Table, require_rows};
use crate::recording::units;

/// Longest line, bytes: 40 000 columns of 25 characters. A longer one is not a table of numbers,
/// and reading on would take memory without bound.
const LINE_LIMIT: usize = 1 << 20;

/// Most blank lines at the end of a file: an editor leaves a few, and without end they would be read on
/// and on.
const MOST_BLANK_LINES: usize = 10_000;

/// Most lines of comment before the names: what is longer is no table.
const MOST_COMMENTS: usize = 10_000;

/// Read-ahead, bytes: large enough that the cost of a system call vanishes.
pub(super) const BUFFER: usize = 1 << 18;

/// Column names of a text file.
pub fn columns(path: &Path, reading: &Reading) -> Result<Vec<String>, RecordingError> {
    columns_of(path, plain(path, reading)?)
}

/// The wanted columns of a text file.
pub fn read(path: &Path, wanted: &[String], reading: &Reading) -> Result<Table, RecordingError> {
    read_from(path, plain(path, reading)?, wanted, reading)
}

/// Column names of the text of a file.
pub(super) fn columns_of(path: &Path, text: Box<dyn Read>) -> Result<Vec<String>, RecordingError> {
    Ok(read_header(&mut Lines::new(path, text)?)?.names)
}

/// The wanted columns of the text of a file.
pub(super) fn read_from(
    path: &Path,
    text: Box<dyn Read>,
    wanted: &[String],
    reading: &Reading,
) -> Result<Table, RecordingError> {
    read_rows(Lines::new(path, text)?, wanted, reading)
}

fn plain(path: &Path, reading: &Reading) -> Result<Box<dyn Read>, RecordingError> {
    let file = File::open(path).map_err(|error| from_io(Place::file(path), &error))?;
    Ok(Box::new(reading.metered(file)))
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
    fn new(path: &'p Path, source: Box<dyn Read>) -> Result<Self, RecordingError> {
        let source = without_mark(source);
        let source = source.map_err(|e| stream_fault(Place::file(path).line(1), &e))?;
        Ok(Self {
            path,
            reader: BufReader::with_capacity(BUFFER, source),
            buffer: Vec::new(),
            number: 0,
        })
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
            return Err(stream_fault(self.place(), &error));
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
}

/// A plain file fails by its medium, a compressed one mostly by its content.
fn stream_fault(place: Place, error: &std::io::Error) -> RecordingError {
    match error.kind() {
        ErrorKind::UnexpectedEof => RecordingError::new(place, RecordingErrorKind::TruncatedGzip),
        ErrorKind::InvalidData | ErrorKind::InvalidInput => {
            let reason = error.to_string();
            RecordingError::new(place, RecordingErrorKind::CorruptGzip { reason })
        }
        _ => from_io(place, error),
    }
}

/// Separators of fields; where none of the others occurs, blanks do.
const SEPARATORS: [char; 4] = [',', ';', '\t', ' '];

/// How comments begin.
const COMMENTS: [&str; 3] = ["#", "%", "//"];

/// Words for a value that is not there, in lower case: those of pandas, R, MATLAB, spreadsheets and C libraries.
const MISSING: [&str; 11] = [
    "",
    "nan",
    "+nan",
    "-nan",
    "-nan(ind)",
    "na",
    "n/a",
    "#n/a",
    "<na>",
    "null",
    "none",
];

/// A line of comment without its mark; None of another line.
fn comment(line: &str) -> Option<&str> {
    let line = line.trim_ascii_start();
    let mark = COMMENTS.iter().find(|mark| line.starts_with(**mark))?;
    Some(line.trim_start_matches(mark).trim_ascii_start())
}

struct Header {
    /// Their positions from 1 where the file has no names.
    names: Vec<String>,
    separator: char,
    /// The line that follows comments, where it holds numbers.
    first_row: Option<String>,
}

/// Reads up to the names: the first line that is no comment or, where that holds numbers, the comment above it that has a
/// name for each.
fn read_header(lines: &mut Lines) -> Result<Header, RecordingError> {
    let mut comments: Vec<String> = Vec::new();
    let line = loop {
        let Some(line) = lines.next()? else {
            let kind = RecordingErrorKind::EmptyFile;
            return Err(RecordingError::new(Place::file(lines.path), kind));
        };
        match comment(line) {
            Some(text) if comments.len() < MOST_COMMENTS => comments.push(text.to_string()),
            Some(_) => return Err(lines.fault(RecordingErrorKind::NoHeader)),
            None => break line.to_string(),
        }
    };
    let by_comment = named_by_comment(&comments, &line);
    let (names, separator, first_row) = match (by_comment, separator_of_numbers(&line)) {
        (Some((names, separator)), _) => (names, separator, Some(line)),
        (None, Some(separator)) => {
            let count = fields(&line, separator).count();
            let names = (1..=count).map(|n| n.to_string()).collect();
            (names, separator, Some(line))
        }
        (None, None) => {
            let separator = separator_of(&line);
            let names = fields(&line, separator).map(String::from).collect();
            (names, separator, None)
        }
    };
    if names.iter().all(String::is_empty) {
        return Err(lines.fault(RecordingErrorKind::EmptyFile));
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
        first_row,
    })
}

/// Names in the last comment above a row that has as many fields, and what separates the fields of the row; of two such
/// comments the last may be a row of units.
fn named_by_comment(comments: &[String], row: &str) -> Option<(Vec<String>, char)> {
    let names = |comment: &String| -> Vec<String> {
        let separated = fields(comment, separator_of(comment));
        separated.map(String::from).collect()
    };
    let separator = |names: &[String]| {
        let same = |separator: &char| {
            fields(row, *separator).count() == names.len()
                && fields(row, *separator).any(|field| is_number(field, *separator))
        };
        let no_numbers = names.iter().all(|name| name.parse::<f64>().is_err());
        SEPARATORS.into_iter().find(|s| no_numbers && same(s))
    };
    let mut candidates = comments.iter().rev().map(names);
    let last = candidates.next()?;
    let found = separator(&last)?;
    let above = candidates
        .next()
        .filter(|above| separator(above) == Some(found));
    match above {
        Some(above) if last.iter().all(|name| units::is_unit(name)) => Some((above, found)),
        _ => Some((last, found)),
    }
}

/// The separator that makes numbers of a whole line; None if none does.
fn separator_of_numbers(line: &str) -> Option<char> {
    let all_numbers = |separator: &char| {
        let mut numbers = 0;
        let mut all = fields(line, *separator).map(|field| {
            numbers += usize::from(is_number(field, *separator));
            is_missing(field) || is_number(field, *separator)
        });
        all.all(|number| number) && numbers > 0
    };
    let mut separators: Vec<char> = SEPARATORS.into_iter().filter(all_numbers).collect();
    separators.sort_by_key(|s| std::cmp::Reverse(fields(line, *s).count()));
    separators.first().copied()
}

/// The separator that occurs most often in the names; blanks or, without any, a comma where none does.
fn separator_of(header: &str) -> char {
    let count = |separator: char| header.chars().filter(|c| *c == separator).count();
    let [comma, others @ .., blank] = SEPARATORS;
    let mut best = comma;
    for candidate in others {
        if count(candidate) > count(best) {
            best = candidate;
        }
    }
    match count(best) == 0 && fields(header, blank).count() > 1 {
        true => blank,
        false => best,
    }
}

/// The fields of a line; blanks separate together, and not within quotation marks.
fn fields(line: &str, separator: char) -> impl Iterator<Item = &str> {
    let by_blanks = (separator == ' ').then(|| blank_separated(line));
    let by_one = (separator != ' ').then(|| line.split(separator).map(bare));
    by_blanks
        .into_iter()
        .flatten()
        .chain(by_one.into_iter().flatten())
}

fn blank_separated(line: &str) -> impl Iterator<Item = &str> {
    let mut quoted = false;
    let at_blank = move |c: char| {
        quoted ^= c == '"';
        !quoted && c.is_ascii_whitespace()
    };
    let parts = line.split(at_blank).filter(|part| !part.is_empty());
    parts.map(bare)
}

/// A field without the blanks and quotation marks around it.
fn bare(field: &str) -> &str {
    let field = field.trim_ascii();
    field
        .strip_prefix('"')
        .and_then(|field| field.strip_suffix('"'))
        .unwrap_or(field)
}

fn is_missing(field: &str) -> bool {
    MISSING.iter().any(|word| field.eq_ignore_ascii_case(word))
}

fn is_number(field: &str, separator: char) -> bool {
    !is_missing(field) && number(field, separator).is_ok()
}

fn read_rows(
    mut lines: Lines,
    wanted: &[String],
    reading: &Reading,
) -> Result<Table, RecordingError> {
    let path = lines.path;
    let header = read_header(&mut lines)?;
    // Where each column of the file goes: None for those that are not wanted.
    let target: Vec<Option<usize>> = header
        .names
        .iter()
        .map(|name| wanted.iter().position(|column| column == name))
        .collect();
    let mut data: Vec<Vec<f64>> = vec![Vec::new(); wanted.len()];
    let mut numbers: Vec<usize> = Vec::new();
    let mut append = |line: &str, number: usize| {
        numbers.push(number);
        reading.takes_rows(path, numbers.len())?;
        append_row(line, header.separator, &target, &mut data).map_err(|fault| {
            let mut place = Place::file(path).line(number);
            if let Some(column) = fault.column {
                place = place.column(column + 1).key(&header.names[column]);
            }
            RecordingError::new(place, fault.kind)
        })
    };
    let mut may_be_units = header.first_row.is_none();
    if let Some(row) = &header.first_row {
        append(row, lines.number)?;
    }
    loop {
        let number = lines.number + 1;
        let Some(line) = lines.next()? else { break };
        if comment(line).is_some() {
            continue;
        }
        if std::mem::take(&mut may_be_units) && is_units(line, header.separator) {
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
    let first_line = numbers.first().copied().unwrap_or(1);
    let follow = numbers.iter().zip(first_line..).all(|(a, b)| *a == b);
    Ok(Table {
        columns: wanted.to_vec(),
        data,
        first_line,
        lines: (!follow).then_some(numbers),
        origins: Vec::new(),
    })
}

/// Whether a row holds words and no numbers, as of units under the names.
fn is_units(line: &str, separator: char) -> bool {
    let is_number = |field: &str| {
        field.parse::<f64>().is_ok_and(|x| !x.is_nan()) || is_number(field, separator)
    };
    let words = || fields(line, separator).filter(|field| !is_missing(field));
    words().next().is_some() && !words().any(is_number)
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
    separator: char,
    target: &[Option<usize>],
    data: &mut [Vec<f64>],
) -> Result<(), RowFault> {
    let mut found = 0;
    for field in fields(line, separator) {
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

/// A number, with a decimal comma where commas do not separate fields, or a date; NaN of a cell without a value.
fn number(field: &str, separator: char) -> Result<f64, RecordingErrorKind> {
    let with_comma = || match separator == ',' || field.contains('.') {
        true => None,
        false => field.replacen(',', ".", 1).parse().ok(),
    };
    match field
        .parse::<f64>()
        .ok()
        .or_else(with_comma)
        .or_else(|| date::seconds(field))
    {
        Some(value) if value.is_finite() => Ok(value),
        _ if is_missing(field) => Ok(f64::NAN),
        Some(_) => Err(RecordingErrorKind::NotFinite {
            found: excerpt(field),
        }),
        None => Err(RecordingErrorKind::NotANumber {
            found: excerpt(field),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2026-01-31 10:00:00 of Greenwich is 1769853600 s after the beginning of 1970 (`date -u -d 2026-01-31T10:00:00 +%s`).
    #[test]
    fn dates_are_seconds() {
        for (written, separator) in [
            ("2026-01-31T10:00:00.25", ','),
            ("2026-01-31 10:00:00,25", ';'),
            ("2026-01-31T10:00:00.250000Z", ','),
            ("2026-01-31T11:00:00.25+01:00", '\t'),
        ] {
            assert_eq!(
                number(written, separator).unwrap(),
                1_769_853_600.25,
                "{written}"
            );
        }
        for wrong in ["2026-13-31T10:00:00", "2026-01-31", "10:00:00", "1-2:3"] {
            assert!(number(wrong, ',').is_err(), "{wrong}");
        }
    }
}
