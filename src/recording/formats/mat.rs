//! MATLAB files; those of version 7.3 are HDF5, and those of version 4 a list of matrices. Here version 5 (`save -v6` and `-v7`): numeric arrays, also as fields of a structure,
//! which are named `structure.field`. Source: MathWorks, MAT-File Format, chapter 1.

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

use flate2::read::ZlibDecoder;

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::arrays::{Layout, Storage, assemble, column_names};
use crate::recording::formats::hdf5;
use crate::recording::formats::mat4;
use crate::recording::formats::number_type::{ByteOrder, NumberType};
use crate::recording::formats::reading::{Reading, Stop};
use crate::recording::formats::table::Table;

/// Bytes of the file's header: text, subsystem, version, byte order.
const HEADER: usize = 128;

/// Structures in structures that are followed; deeper ones hold no recording.
const DEEPEST: usize = 8;

// Types of data elements (table 1-1).
const TEXT: u32 = 1;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

// Classes of arrays (table 1-3).
const STRUCTURE: u8 = 2;
/// Tables, dates and strings, which the format description does not have.
const OBJECT: u8 = 17;
const FIRST_NUMERIC: u8 = 6;
const LAST_NUMERIC: u8 = 15;

/// The flag of a complex array, in the second byte of the array flags.
const COMPLEX: u8 = 0x08;

/// Column names of a file.
pub fn columns(path: &Path, reading: &Reading) -> Result<Vec<String>, RecordingError> {
    if hdf5::is_hdf5(path)? {
        return hdf5::columns(path, reading);
    }
    let Contents { arrays, skipped } = contents(path, reading)?;
    let layouts: Vec<Layout> = arrays.into_iter().map(|v| v.layout).collect();
    let mut names = column_names(&layouts);
    names.extend(skipped.into_iter().map(|s| s.name));
    Ok(names)
}

/// The wanted columns of a file.
pub fn read(path: &Path, wanted: &[String], reading: &Reading) -> Result<Table, RecordingError> {
    if hdf5::is_hdf5(path)? {
        return hdf5::read(path, wanted, reading);
    }
    let Contents { arrays, skipped } = contents(path, reading)?;
    if let Some(asked) = skipped.iter().find(|s| wanted.contains(&s.name)) {
        let kind = RecordingErrorKind::Unsupported {
            what: format!("the variable cannot be read: {}", asked.reason).into(),
            remedy: "save it as an array of numbers; other variables of the file can be read",
        };
        return Err(RecordingError::new(
            Place::file(path).key(&asked.name),
            kind,
        ));
    }
    let layouts: Vec<Layout> = arrays.iter().map(|v| v.layout.clone()).collect();
    assemble(path, &layouts, wanted, |at| {
        let variable = &arrays[at];
        let numbers = variable.number.decode(&variable.bytes, variable.order);
        Ok(Cow::Owned(numbers))
    })
}

/// A numeric array that can hold channels.
struct Variable {
    layout: Layout,
    number: NumberType,
    order: ByteOrder,
    bytes: Vec<u8>,
}

/// What a file holds.
#[derive(Default)]
struct Contents {
    arrays: Vec<Variable>,
    skipped: Vec<Skipped>,
}

/// A variable that is no array of numbers and cannot be looked into, such as an object.
struct Skipped {
    name: String,
    reason: String,
}

fn contents(path: &Path, reading: &Reading) -> Result<Contents, RecordingError> {
    let bytes = reading.whole_file(path)?;
    if mat4::is_of_this_version(&bytes) {
        let matrices = mat4::matrices(&bytes).map_err(|reason| corrupt(path, reason))?;
        let arrays = matrices.into_iter().map(|matrix| Variable {
            layout: matrix.layout,
            number: matrix.number,
            order: matrix.order,
            bytes: matrix.bytes.to_vec(),
        });
        return Ok(Contents {
            arrays: arrays.collect(),
            skipped: Vec::new(),
        });
    }
    let order = byte_order(path, &bytes)?;
    let mut contents = Contents::default();
    let cursor = Cursor::new(&bytes[HEADER..], order);
    match read_elements(cursor, &mut contents, reading) {
        Ok(()) => Ok(contents),
        Err(Fault::Stop(stop)) => Err(stop.at(Place::file(path))),
        Err(Fault::Content(reason)) => Err(corrupt(path, reason)),
    }
}

/// Why reading ends early.
enum Fault {
    Content(String),
    Stop(Stop),
}

impl From<String> for Fault {
    fn from(reason: String) -> Self {
        Self::Content(reason)
    }
}

fn corrupt(path: &Path, reason: String) -> RecordingError {
    let kind = RecordingErrorKind::Corrupt {
        format: "MATLAB file",
        reason: reason.into(),
    };
    RecordingError::new(Place::file(path), kind)
}

/// The byte order that the header states; fails unless it is one of version 5.
fn byte_order(path: &Path, bytes: &[u8]) -> Result<ByteOrder, RecordingError> {
    if bytes.is_empty() {
        let kind = RecordingErrorKind::EmptyFile;
        return Err(RecordingError::new(Place::file(path), kind));
    }
    match bytes.get(HEADER - 4..HEADER) {
        Some([0, 1, b'I', b'M']) => Ok(ByteOrder::Little),
        Some([1, 0, b'M', b'I']) => Ok(ByteOrder::Big),
        _ => Err(corrupt(
            path,
            "it does not begin as one of version 4 or 5; save it with the option '-v7'".into(),
        )),
    }
}

/// Reads the elements of a file.
fn read_elements(
    mut cursor: Cursor,
    contents: &mut Contents,
    reading: &Reading,
) -> Result<(), Fault> {
    while !cursor.rest.is_empty() {
        if reading.is_interrupted() {
            return Err(Fault::Stop(Stop::Interrupted));
        }
        let element = cursor.element()?;
        match element.kind {
            MATRIX => contents.add(&element),
            COMPRESSED => {
                let mut content = Vec::new();
                let mut decoder = reading.metered(ZlibDecoder::new(element.bytes));
                let inflated = decoder.read_to_end(&mut content);
                inflated.map_err(|error| match Stop::of(&error) {
                    Some(stop) => Fault::Stop(stop),
                    None => Fault::Content(format!("compressed data: {error}")),
                })?;
                let mut inner = Cursor::new(&content, element.order);
                let matrix = inner.element()?;
                if matrix.kind == MATRIX {
                    contents.add(&matrix);
                }
            }
            _ => {}
        }
    }
    Ok(())
}

impl Contents {
    /// Adds a variable; one that cannot be read is no reason to refuse the others.
    fn add(&mut self, matrix: &Element<'_>) {
        let mut arrays = Vec::new();
        match read_matrix(matrix.cursor(), None, DEEPEST, &mut arrays) {
            Ok(()) => self.arrays.extend(arrays),
            Err(reason) => self
                .skipped
                .extend(name_of(matrix).map(|name| Skipped { name, reason })),
        }
    }
}

/// The name of a variable: behind flags and dimensions, or behind the flags alone where it is an object.
fn name_of(matrix: &Element<'_>) -> Option<String> {
    let mut cursor = matrix.cursor();
    cursor.element().ok()?;
    let mut name = cursor.element().ok()?;
    if name.kind != TEXT {
        name = cursor.element().ok()?;
    }
    let text = String::from_utf8_lossy(name.bytes).into_owned();
    (name.kind == TEXT && !text.is_empty()).then_some(text)
}

/// Reads one array. `field`: the name of the array where its structure gives it one.
fn read_matrix(
    mut cursor: Cursor,
    field: Option<&str>,
    depth: usize,
    variables: &mut Vec<Variable>,
) -> Result<(), String> {
    if cursor.rest.is_empty() {
        return Ok(()); // An empty field of a structure has no content at all.
    }
    let flags = cursor.element()?.integers("array flags")?;
    let [flags, ..] = flags[..] else {
        return Err("array flags are missing".into());
    };
    let [class, flags, ..] = (flags as u32).to_le_bytes();
    if class == OBJECT {
        return Err("it is an object of MATLAB".into());
    }
    let dimensions: Vec<usize> = cursor
        .element()?
        .integers("dimensions")?
        .into_iter()
        .map(|side| usize::try_from(side).map_err(|_| "a negative dimension".to_string()))
        .collect::<Result<_, _>>()?;
    let name = cursor.element()?;
    let name = match field {
        Some(name) => name.to_string(),
        None => String::from_utf8_lossy(name.bytes).into_owned(),
    };
    match class {
        STRUCTURE if dimensions.iter().all(|&side| side == 1) && depth > 0 => {
            read_structure(cursor, &name, depth, variables)
        }
        FIRST_NUMERIC..=LAST_NUMERIC if flags & COMPLEX == 0 => {
            let Some(layout) = Layout::new(&name, &dimensions, Storage::ColumnMajor) else {
                return Ok(());
            };
            let element = cursor.element()?;
            variables.extend([variable(layout, &dimensions, &element)?]);
            Ok(())
        }
        _ => Ok(()),
    }
}

fn variable(layout: Layout, dimensions: &[usize], data: &Element) -> Result<Variable, String> {
    let Some(number) = data.number() else {
        return Err(format!("{}: elements of type {}", layout.name, data.kind));
    };
    let count = dimensions
        .iter()
        .try_fold(1, |n: usize, &d| n.checked_mul(d));
    let expected = count.and_then(|count| count.checked_mul(number.size()));
    if expected != Some(data.bytes.len()) {
        let (name, found) = (&layout.name, data.bytes.len());
        return Err(format!("{name}: {found} bytes for {dimensions:?} numbers"));
    }
    Ok(Variable {
        layout,
        number,
        order: data.order,
        bytes: data.bytes.to_vec(),
    })
}

/// Reads the fields of a structure: length of the names, names, one array for each.
fn read_structure(
    mut cursor: Cursor,
    name: &str,
    depth: usize,
    variables: &mut Vec<Variable>,
) -> Result<(), String> {
    let length = cursor.element()?.integers("length of field names")?;
    let length = match length[..] {
        [length] if length > 0 => length as usize,
        _ => return Err(format!("{name}: the length of its field names is missing")),
    };
    let names = cursor.element()?.bytes;
    for field in names.chunks(length) {
        let end = field.iter().position(|&byte| byte == 0);
        let field = String::from_utf8_lossy(&field[..end.unwrap_or(field.len())]);
        let element = cursor.element()?;
        if element.kind != MATRIX {
            return Err(format!("{name}.{field}: no array"));
        }
        let full = format!("{name}.{field}");
        read_matrix(element.cursor(), Some(&full), depth - 1, variables)?;
    }
    Ok(())
}

/// One data element: its type and bytes.
struct Element<'a> {
    kind: u32,
    bytes: &'a [u8],
    order: ByteOrder,
}

impl<'a> Element<'a> {
    fn cursor(&self) -> Cursor<'a> {
        Cursor::new(self.bytes, self.order)
    }

    fn number(&self) -> Option<NumberType> {
        Some(match self.kind {
            1 => NumberType::I8,
            2 => NumberType::U8,
            3 => NumberType::I16,
            4 => NumberType::U16,
            5 => NumberType::I32,
            6 => NumberType::U32,
            7 => NumberType::F32,
            9 => NumberType::F64,
            12 => NumberType::I64,
            13 => NumberType::U64,
            _ => return None,
        })
    }

    /// Its content as 32-bit integers.
    fn integers(&self, what: &str) -> Result<Vec<i64>, String> {
        match self.number() {
            Some(number @ (NumberType::I32 | NumberType::U32)) => {
                let values = number.decode(self.bytes, self.order);
                Ok(values.into_iter().map(|value| value as i64).collect())
            }
            _ => Err(format!("{what} of type {}", self.kind)),
        }
    }
}

/// Takes data elements off the front.
struct Cursor<'a> {
    rest: &'a [u8],
    order: ByteOrder,
}

impl<'a> Cursor<'a> {
    fn new(rest: &'a [u8], order: ByteOrder) -> Self {
        Self { rest, order }
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            let left = self.rest.len();
            return Err(format!(
                "it ends within an element: {left} of {count} bytes"
            ));
        };
        self.rest = rest;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32, String> {
        let bytes = self.take(4)?;
        Ok(NumberType::U32.decode(bytes, self.order)[0] as u32)
    }

    /// The next element: type, number of bytes, bytes padded to eight; or, where at most four bytes
    /// follow, all in eight bytes. A compressed element is not padded.
    fn element(&mut self) -> Result<Element<'a>, String> {
        let tag = self.word()?;
        let order = self.order;
        if tag >> 16 != 0 {
            let size = (tag >> 16) as usize;
            let bytes = self.take(4)?.get(..size);
            let bytes = bytes.ok_or("a small element of more than four bytes")?;
            let kind = tag & 0xffff;
            return Ok(Element { kind, bytes, order });
        }
        let size = self.word()? as usize;
        let bytes = self.take(size)?;
        if tag != COMPRESSED {
            let padding = size.next_multiple_of(8) - size;
            self.take(padding.min(self.rest.len()))?;
        }
        let kind = tag;
        Ok(Element { kind, bytes, order })
    }
}
