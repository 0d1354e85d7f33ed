//! NumPy archives: a zip file of `.npy` arrays, stored or deflated. Source: NumPy's format
//! description, versions 1.0 to 3.0.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use zip::ZipArchive;
use zip::result::ZipError;

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::arrays::{Layout, Storage, assemble, column_names};
use crate::recording::formats::number_type::{ByteOrder, NumberType};
use crate::recording::formats::reading::from_io;
use crate::recording::formats::reading::{Reading, Stop};
use crate::recording::formats::table::Table;

/// Longest header of an array, bytes; NumPy itself refuses more than 10 000.
const HEADER_LIMIT: usize = 1 << 16;

const MAGIC: &[u8] = b"\x93NUMPY";

type Archive = ZipArchive<BufReader<File>>;

/// Column names of an archive.
pub fn columns(path: &Path, reading: &Reading) -> Result<Vec<String>, RecordingError> {
    reading.goes_on(path)?;
    let arrays = list(path, &mut open(path)?)?;
    let layouts: Vec<Layout> = arrays.into_iter().map(|array| array.layout).collect();
    Ok(column_names(&layouts))
}

/// The wanted columns of an archive.
pub fn read(path: &Path, wanted: &[String], reading: &Reading) -> Result<Table, RecordingError> {
    let mut archive = open(path)?;
    let arrays = list(path, &mut archive)?;
    let layouts: Vec<Layout> = arrays.iter().map(|array| array.layout.clone()).collect();
    assemble(path, &layouts, wanted, |at| {
        load(path, reading, &mut archive, &arrays[at]).map(Cow::Owned)
    })
}

/// An array of the archive whose elements are numbers.
struct Array {
    /// Index in the archive.
    entry: usize,
    layout: Layout,
    header: Header,
}

fn open(path: &Path) -> Result<Archive, RecordingError> {
    let file = File::open(path).map_err(|error| from_io(Place::file(path), &error))?;
    ZipArchive::new(BufReader::new(file)).map_err(|error| zip_fault(path, error))
}

fn zip_fault(path: &Path, error: ZipError) -> RecordingError {
    match error {
        ZipError::UnsupportedArchive(what) => {
            let kind = RecordingErrorKind::Unsupported {
                what: format!("the NumPy archive needs what is not read: {what}").into(),
                remedy: "write it with numpy.savez or numpy.savez_compressed",
            };
            RecordingError::new(Place::file(path), kind)
        }
        error => corrupt(path, None, error.to_string()),
    }
}

fn corrupt(path: &Path, array: Option<&str>, reason: impl Into<String>) -> RecordingError {
    let mut place = Place::file(path);
    if let Some(array) = array {
        place = place.key(array);
    }
    let kind = RecordingErrorKind::Corrupt {
        format: "NumPy archive",
        reason: reason.into().into(),
    };
    RecordingError::new(place, kind)
}

/// The arrays that can hold channels; entries that are no arrays, and arrays of texts or objects,
/// are passed over.
fn list(path: &Path, archive: &mut Archive) -> Result<Vec<Array>, RecordingError> {
    let mut arrays = Vec::new();
    for entry in 0..archive.len() {
        let mut file = archive
            .by_index(entry)
            .map_err(|error| zip_fault(path, error))?;
        let name = file.name().map_err(|error| zip_fault(path, error))?;
        let Some(name) = name.strip_suffix(".npy").map(String::from) else {
            continue;
        };
        let header = read_header(&mut file).map_err(|why| corrupt(path, Some(&name), why))?;
        let Some(header) = header else { continue };
        if let Some(layout) = Layout::new(&name, &header.shape, header.storage) {
            arrays.push(Array {
                entry,
                layout,
                header,
            });
        }
    }
    Ok(arrays)
}

fn load(
    path: &Path,
    reading: &Reading,
    archive: &mut Archive,
    array: &Array,
) -> Result<Vec<f64>, RecordingError> {
    let mut file = archive
        .by_index(array.entry)
        .map_err(|error| zip_fault(path, error))?;
    let fault = |reason: String| corrupt(path, Some(&array.layout.name), reason);
    read_header(&mut file).map_err(fault)?;
    let Header { number, order, .. } = array.header;
    let count = array
        .header
        .shape
        .iter()
        .try_fold(1, |n: usize, &d| n.checked_mul(d));
    let Some(expected) = count.and_then(|count| count.checked_mul(number.size())) else {
        return Err(fault("its dimensions overflow".into()));
    };
    let mut bytes = Vec::new();
    // Room grows with what is really there, whatever the header claims; one byte more meets the end of the entry, where
    // its checksum is compared.
    let mut bounded = reading.metered(file.take((expected as u64).saturating_add(1)));
    let read = bounded.read_to_end(&mut bytes);
    read.map_err(|error| match Stop::of(&error) {
        Some(stop) => stop.at(Place::file(path)),
        None => fault(error.to_string()),
    })?;
    if bytes.len() < expected {
        let found = bytes.len();
        return Err(fault(format!("it has {found} of {expected} bytes")));
    }
    if bytes.len() > expected {
        return Err(fault(format!(
            "it has more than the {expected} bytes of its shape"
        )));
    }
    Ok(number.decode(&bytes, order))
}

/// What the header of an array says.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Header {
    number: NumberType,
    order: ByteOrder,
    storage: Storage,
    shape: Vec<usize>,
}

/// Reads the header; None where the elements are not numbers.
fn read_header(source: &mut impl Read) -> Result<Option<Header>, String> {
    let mut fixed = [0; 8];
    let short = |error: std::io::Error| error.to_string();
    source.read_exact(&mut fixed).map_err(short)?;
    if !fixed.starts_with(MAGIC) {
        return Err("it does not begin as a NumPy array".into());
    }
    let length = match fixed[6] {
        1 => {
            let mut length = [0; 2];
            source.read_exact(&mut length).map_err(short)?;
            usize::from(u16::from_le_bytes(length))
        }
        2 | 3 => {
            let mut length = [0; 4];
            source.read_exact(&mut length).map_err(short)?;
            u32::from_le_bytes(length) as usize
        }
        version => return Err(format!("version {version} of the array format is unknown")),
    };
    if length > HEADER_LIMIT {
        return Err(format!("its header has {length} bytes"));
    }
    let mut text = vec![0; length];
    source.read_exact(&mut text).map_err(short)?;
    parse_header(&String::from_utf8_lossy(&text))
}

/// Parses `{'descr': '<f8', 'fortran_order': False, 'shape': (5027, 7), }`.
fn parse_header(text: &str) -> Result<Option<Header>, String> {
    let value = |key: &str| {
        let found = text.split_once(&format!("'{key}':"));
        found
            .map(|(_, rest)| rest.trim_start())
            .ok_or_else(|| format!("its header has no {key}"))
    };
    let descr = value("descr")?;
    let quoted = descr.strip_prefix('\'').and_then(|d| d.split_once('\''));
    let Some((number, order)) = quoted.and_then(|(code, _)| element(code)) else {
        return Ok(None);
    };
    let storage = match value("fortran_order")? {
        rest if rest.starts_with("True") => Storage::ColumnMajor,
        rest if rest.starts_with("False") => Storage::RowMajor,
        _ => return Err("its header has no storage order".into()),
    };
    let sides = value("shape")?.strip_prefix('(');
    let Some((sides, _)) = sides.and_then(|s| s.split_once(')')) else {
        return Err("its header has no shape".into());
    };
    let sides = sides.split(',').map(str::trim).filter(|s| !s.is_empty());
    let shape = sides
        .map(|side| {
            side.parse()
                .map_err(|_| format!("{side:?} is no dimension"))
        })
        .collect::<Result<_, _>>()?;
    Ok(Some(Header {
        number,
        order,
        storage,
        shape,
    }))
}

/// The element type of a code such as `<f8`: byte order, kind, bytes.
fn element(code: &str) -> Option<(NumberType, ByteOrder)> {
    let order = match code.chars().next()? {
        '<' | '|' | '=' => ByteOrder::Little,
        '>' => ByteOrder::Big,
        _ => return None,
    };
    let number = match &code[1..] {
        "b1" | "u1" => NumberType::U8,
        "i1" => NumberType::I8,
        "i2" => NumberType::I16,
        "u2" => NumberType::U16,
        "i4" => NumberType::I32,
        "u4" => NumberType::U32,
        "i8" => NumberType::I64,
        "u8" => NumberType::U64,
        "f4" => NumberType::F32,
        "f8" => NumberType::F64,
        _ => return None,
    };
    Some((number, order))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The length of the header has two bytes in version 1 and four in later ones.
    #[test]
    fn headers_of_every_version_are_read() {
        let text = "{'descr': '<f8', 'fortran_order': False, 'shape': (5027, 7), }\n";
        let of = |version: u8, length: &[u8]| {
            let bytes = [MAGIC, &[version, 0], length, text.as_bytes()].concat();
            read_header(&mut bytes.as_slice())
        };
        let length = text.len() as u32;
        for found in [
            of(1, &(length as u16).to_le_bytes()),
            of(2, &length.to_le_bytes()),
            of(3, &length.to_le_bytes()),
        ] {
            assert_eq!(found.unwrap().unwrap().shape, [5027, 7]);
        }
        assert!(of(4, &length.to_le_bytes()).is_err());
    }
}
