//! Writes recordings as comma-separated text, every number with the fewest digits that read back to the
//! same bits.

use crate::simulate::SimulatedRecording;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::{self, Write};

/// Bytes that are gathered before they are handed on.
const BUFFER: usize = 1 << 18;

/// Writes a recording; compressed where its name ends with `.gz`.
///
/// # Errors
/// Those of the writer.
pub fn write_csv(out: impl Write, recording: &SimulatedRecording) -> io::Result<()> {
    if recording.name.ends_with(".gz") {
        let mut compressed = GzEncoder::new(out, Compression::default());
        write_rows(&mut compressed, recording)?;
        compressed.finish()?.flush()
    } else {
        let mut out = out;
        write_rows(&mut out, recording)?;
        out.flush()
    }
}

fn write_rows(out: &mut impl Write, recording: &SimulatedRecording) -> io::Result<()> {
    let table = &recording.table;
    let mut buffer: Vec<u8> = Vec::with_capacity(BUFFER + BUFFER / 4);
    buffer.extend_from_slice(table.header.join(",").as_bytes());
    buffer.push(b'\n');
    let rows = table.data.first().map_or(0, Vec::len);
    for row in 0..rows {
        for (k, column) in table.data.iter().enumerate() {
            if k > 0 {
                buffer.push(b',');
            }
            write!(buffer, "{}", column[row])?;
        }
        buffer.push(b'\n');
        if buffer.len() >= BUFFER {
            out.write_all(&buffer)?;
            buffer.clear();
        }
    }
    out.write_all(&buffer)
}
