//! Compressed text: gzip, bzip2 or Zstandard by the first bytes, not by the name, since what compresses is often renamed.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use bzip2::read::MultiBzDecoder;
use flate2::read::MultiGzDecoder;

use crate::fault::Place;
use crate::recording::error::RecordingError;
use crate::recording::formats::csv;
use crate::recording::formats::reading::{Reading, from_io};
use crate::recording::formats::table::Table;

/// First bytes of files by bzip2 and Zstandard (RFC 8878, section 3.1.1).
const BZIP2: &[u8] = b"BZh";
const ZSTANDARD: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];

/// Column names of a compressed text file.
pub fn columns(path: &Path, reading: &Reading) -> Result<Vec<String>, RecordingError> {
    csv::columns_of(path, open(path, reading)?)
}

/// The wanted columns of a compressed text file.
pub fn read(path: &Path, wanted: &[String], reading: &Reading) -> Result<Table, RecordingError> {
    csv::read_from(path, open(path, reading)?, wanted, reading)
}

/// The text of a file.
fn open(path: &Path, reading: &Reading) -> Result<Box<dyn Read>, RecordingError> {
    let fault = |error: &std::io::Error| from_io(Place::file(path), error);
    let file = File::open(path).map_err(|error| fault(&error))?;
    let mut file = BufReader::with_capacity(csv::BUFFER, file);
    let begin = file.fill_buf().map_err(|error| fault(&error))?;
    if begin.starts_with(BZIP2) {
        return Ok(Box::new(reading.metered(MultiBzDecoder::new(file))));
    }
    if begin.starts_with(ZSTANDARD) {
        let decoder = zstd::stream::read::Decoder::with_buffer(file);
        let decoder = decoder.map_err(|error| fault(&error))?;
        return Ok(Box::new(reading.metered(decoder)));
    }
    Ok(Box::new(reading.metered(MultiGzDecoder::new(file))))
}
