//! MATLAB files of version 4 (`save -v4`, and what older programs write): full matrices of real numbers, one after the other.
//!
//! ```text
//! type  mrows  ncols  imagf  namlen    32-bit integers; type = 1000 M + 100 O + 10 P + T
//! name, with a zero at its end; the real part by columns; the imaginary part where imagf is not 0
//! M: 0 little, 1 big endian    P: 0 double, 1 single, 2 int32, 3 int16, 4 uint16, 5 uint8    T: 0 full, 1 text, 2 sparse
//! ```
//!
//! Source: MathWorks, MAT-File Format, chapter 2.

use crate::recording::formats::arrays::{Layout, Storage};
use crate::recording::formats::number_type::{ByteOrder, NumberType};

/// Bytes of the header of one matrix.
const HEADER: usize = 20;

/// Bytes of the longest name that is one.
const LONGEST_NAME: usize = 256;

/// A full matrix of real numbers that can hold channels.
pub(super) struct Matrix<'a> {
    pub layout: Layout,
    pub number: NumberType,
    pub order: ByteOrder,
    pub bytes: &'a [u8],
}

/// The header of one matrix.
struct Header {
    order: ByteOrder,
    number: NumberType,
    is_full: bool,
    rows: usize,
    columns: usize,
    is_complex: bool,
    name: usize,
}

impl Header {
    /// `None` unless the bytes begin as a matrix of this version.
    fn of(bytes: &[u8]) -> Option<Self> {
        let bytes = bytes.get(..HEADER)?;
        let in_order = |order| {
            let words = NumberType::I32.decode(bytes, order);
            let big = if order == ByteOrder::Big { 1000.0 } else { 0.0 };
            let kind = words[0] - big;
            ((0.0..60.0).contains(&kind)).then_some((order, kind as usize, words))
        };
        let (order, kind, words) =
            in_order(ByteOrder::Little).or_else(|| in_order(ByteOrder::Big))?;
        let number = match kind / 10 {
            0 => NumberType::F64,
            1 => NumberType::F32,
            2 => NumberType::I32,
            3 => NumberType::I16,
            4 => NumberType::U16,
            _ => NumberType::U8,
        };
        let count = |x: f64| (x >= 0.0).then_some(x as usize);
        let name = count(words[4]).filter(|name| (1..=LONGEST_NAME).contains(name))?;
        Some(Self {
            order,
            number,
            is_full: kind % 10 == 0,
            rows: count(words[1])?,
            columns: count(words[2])?,
            is_complex: words[3] != 0.0,
            name,
        })
    }
}

/// Whether a file begins as one of this version: where those of version 5 have text, it has zeros.
pub(super) fn is_of_this_version(bytes: &[u8]) -> bool {
    Header::of(bytes).is_some() && bytes[..4].contains(&0)
}

/// The matrices of a file; texts, sparse and complex ones are passed over.
///
/// # Errors
/// What is no header, or a matrix that is longer than the file.
pub(super) fn matrices(mut bytes: &[u8]) -> Result<Vec<Matrix<'_>>, String> {
    let mut found = Vec::new();
    while !bytes.is_empty() {
        let header = Header::of(bytes).ok_or("what follows a matrix is none of version 4")?;
        let name = &bytes[HEADER..]
            .get(..header.name)
            .ok_or("it ends within a name")?;
        let name = String::from_utf8_lossy(name.strip_suffix(&[0]).unwrap_or(name)).into_owned();
        let parts = if header.is_complex { 2 } else { 1 };
        let one = header.rows.checked_mul(header.columns);
        let one = one.and_then(|count| count.checked_mul(header.number.size()));
        let all = one.and_then(|one| one.checked_mul(parts));
        let rest = &bytes[HEADER + header.name..];
        let (content, rest) = all
            .and_then(|all| rest.split_at_checked(all))
            .ok_or_else(|| format!("it ends within the matrix {name}"))?;
        bytes = rest;
        if !header.is_full || header.is_complex {
            continue;
        }
        let sides = [header.rows, header.columns];
        found.extend(
            Layout::new(&name, &sides, Storage::ColumnMajor).map(|layout| Matrix {
                layout,
                number: header.number,
                order: header.order,
                bytes: content,
            }),
        );
    }
    Ok(found)
}
