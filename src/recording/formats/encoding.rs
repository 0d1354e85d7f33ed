//! Text as bytes: UTF-8, with or without a byte-order mark, and UTF-16 in either byte order, which its mark tells.

use std::io::{Cursor, Read, Result};

use crate::recording::formats::number_type::ByteOrder;

const UTF8_MARK: &[u8] = &[0xef, 0xbb, 0xbf];
const UTF16_LITTLE: &[u8] = &[0xff, 0xfe];
const UTF16_BIG: &[u8] = &[0xfe, 0xff];

/// Bytes transcoded at a time.
const CHUNK: usize = 1 << 16;

/// The source as UTF-8 without a byte-order mark. Other encodings without a mark are left as they are.
pub(super) fn without_mark(mut source: Box<dyn Read>) -> Result<Box<dyn Read>> {
    let mut head = Vec::new();
    source.by_ref().take(3).read_to_end(&mut head)?;
    let (order, mark) = if head.starts_with(UTF16_LITTLE) {
        (Some(ByteOrder::Little), UTF16_LITTLE.len())
    } else if head.starts_with(UTF16_BIG) {
        (Some(ByteOrder::Big), UTF16_BIG.len())
    } else if head.starts_with(UTF8_MARK) {
        (None, UTF8_MARK.len())
    } else {
        (None, 0)
    };
    let rest = Cursor::new(head.split_off(mark)).chain(source);
    Ok(match order {
        Some(order) => Box::new(Utf16::new(rest, order)),
        None => Box::new(rest),
    })
}

/// Turns UTF-16 into UTF-8; what is no character becomes the replacement character.
struct Utf16<R> {
    source: R,
    order: ByteOrder,
    /// Bytes of a character whose other half is still to come.
    left: Vec<u8>,
    text: Cursor<Vec<u8>>,
}

impl<R: Read> Utf16<R> {
    fn new(source: R, order: ByteOrder) -> Self {
        Self {
            source,
            order,
            left: Vec::new(),
            text: Cursor::default(),
        }
    }

    /// Transcodes the next chunk; false at the end.
    fn advance(&mut self) -> Result<bool> {
        let mut bytes = std::mem::take(&mut self.left);
        let before = bytes.len();
        (self.source.by_ref())
            .take(CHUNK as u64)
            .read_to_end(&mut bytes)?;
        let at_end = bytes.len() == before;
        let (pairs, odd) = bytes.as_chunks::<2>();
        let mut units: Vec<u16> = (pairs.iter())
            .map(|&pair| match self.order {
                ByteOrder::Little => u16::from_le_bytes(pair),
                ByteOrder::Big => u16::from_be_bytes(pair),
            })
            .collect();
        self.left = odd.to_vec();
        let is_half = |unit: &u16| (0xd800..0xdc00).contains(unit);
        if !at_end && units.last().is_some_and(is_half) {
            units.pop();
            self.left = bytes[bytes.len() - odd.len() - 2..].to_vec();
        }
        self.text = Cursor::new(String::from_utf16_lossy(&units).into_bytes());
        Ok(!at_end || !units.is_empty())
    }
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        loop {
            let count = self.text.read(buffer)?;
            if count > 0 || buffer.is_empty() || !self.advance()? {
                return Ok(count);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: Vec<u8>) -> String {
        let mut text = String::new();
        let mut source = without_mark(Box::new(Cursor::new(bytes))).unwrap();
        source.read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn recovers_text_in_either_byte_order_across_chunks() {
        // A character of two halves at every place of a chunk.
        let text = "größe_θ1,😀;x\n".repeat(9000);
        let units = || text.encode_utf16();
        let little = UTF16_LITTLE.to_vec().into_iter();
        let big = UTF16_BIG.to_vec().into_iter();
        assert_eq!(
            read(little.chain(units().flat_map(u16::to_le_bytes)).collect()),
            text
        );
        assert_eq!(
            read(big.chain(units().flat_map(u16::to_be_bytes)).collect()),
            text
        );
        assert_eq!(read([UTF8_MARK, text.as_bytes()].concat()), text);
        assert_eq!(read(text.clone().into_bytes()), text);
    }

    #[test]
    fn half_a_character_at_the_end_ends_the_text() {
        assert_eq!(read([UTF16_LITTLE, b"a\0b"].concat()), "a");
        assert_eq!(read([UTF16_LITTLE, &[0x00, 0xd8]].concat()), "\u{fffd}");
        assert_eq!(read(vec![]), "");
    }
}
