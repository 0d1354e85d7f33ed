//! Writes `predictions.csv`: pages of lines are put into words side by side and written in order.

use std::io::{self, Write};

use crate::outcome::predictions::quantity::{Column, LEADING};
use crate::recording::split::Split;
use rayon::prelude::*;

/// Rows of one recording.
#[derive(Debug, Clone, Copy)]
pub struct Block<'a> {
    /// Name of the recording as the user wrote it.
    pub recording: &'a str,
    /// What the recording is for.
    pub split: Split,
    /// Time of each row in s.
    pub t: &'a [f64],
    /// The columns of the header, each as long as `t`.
    pub columns: &'a [&'a [f64]],
}

/// Writes the table to `out`.
#[derive(Debug)]
pub struct PredictionsWriter<W: Write> {
    out: W,
    columns: usize,
}

/// Rows of a page.
const PAGE_ROWS: usize = 256;

/// Pages that are in memory at a time.
const PAGES_TOGETHER: usize = 64;

impl<W: Write> PredictionsWriter<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// What writing to `out` gives.
    pub fn new(mut out: W, columns: &[Column]) -> io::Result<Self> {
        let mut line = LEADING.join(",").into_bytes();
        for Column { joint, quantity } in columns {
            line.push(b',');
            push_field(&mut line, &format!("{joint}_{}", quantity.as_str()));
        }
        line.push(b'\n');
        out.write_all(&line)?;
        Ok(Self {
            out,
            columns: columns.len(),
        })
    }

    /// Appends the rows of a block: ten significant digits, an empty field for what is not finite.
    ///
    /// # Errors
    /// `InvalidInput` if the block does not fit the header, else what writing to `out` gives.
    pub fn block(&mut self, block: &Block) -> io::Result<()> {
        let fits = block.columns.len() == self.columns
            && block
                .columns
                .iter()
                .all(|column| column.len() == block.t.len());
        if !fits {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "the columns of a block do not fit the header",
            ));
        }
        let mut lead = Vec::new();
        push_field(&mut lead, block.recording);
        write!(lead, ",{},", block.split.as_str())?;
        let rows: Vec<usize> = (0..block.t.len()).collect();
        for together in rows.chunks(PAGE_ROWS * PAGES_TOGETHER) {
            let pages: io::Result<Vec<Vec<u8>>> = together
                .par_chunks(PAGE_ROWS)
                .map(|rows| page(&lead, block, rows))
                .collect();
            for page in pages? {
                self.out.write_all(&page)?;
            }
        }
        Ok(())
    }
}

/// The lines of some rows.
fn page(lead: &[u8], block: &Block<'_>, rows: &[usize]) -> io::Result<Vec<u8>> {
    let mut lines = Vec::new();
    for &row in rows {
        lines.extend_from_slice(lead);
        // In full: time stamps may count from 1970, and ten digits would merge them.
        write!(lines, "{}", block.t[row])?;
        for column in block.columns {
            lines.push(b',');
            push_number(&mut lines, column[row])?;
        }
        lines.push(b'\n');
    }
    Ok(lines)
}

fn push_number(line: &mut Vec<u8>, value: f64) -> io::Result<()> {
    if value.is_finite() {
        write!(line, "{value:.9e}")?;
    }
    Ok(())
}

/// A text field, quoted where it holds what would end a field (RFC 4180).
fn push_field(line: &mut Vec<u8>, text: &str) {
    if text.contains([',', '"', '\n', '\r']) {
        line.push(b'"');
        line.extend_from_slice(text.replace('"', "\"\"").as_bytes());
        line.push(b'"');
    } else {
        line.extend_from_slice(text.as_bytes());
    }
}
