//! Types that Parquet has no word for and its writers keep in the schema of Arrow beside it: durations. The schema is a
//! flat buffer, encoded in base 64. Source: Apache Arrow, Schema.fbs and Message.fbs; FlatBuffers, internals.

use std::collections::HashMap;

/// The key under which writers keep the schema.
pub(in crate::recording) const KEY: &str = "ARROW:schema";

/// The type of a duration among the types of Schema.fbs, and its unit where none is written: milliseconds.
const DURATION: u8 = 18;
const MILLISECOND: u16 = 1;

/// Parts of a second in one unit of every column of durations; none where the schema cannot be read.
pub(super) fn durations(encoded: &str) -> HashMap<String, i64> {
    base64(encoded)
        .and_then(|bytes| of_message(&bytes))
        .unwrap_or_default()
}

fn of_message(bytes: &[u8]) -> Option<HashMap<String, i64>> {
    // A mark of continuation and the length of what follows; older writers have the length alone.
    let head = if bytes.starts_with(&[0xff; 4]) { 8 } else { 4 };
    let buffer = Buffer(bytes.get(head..)?);
    let message = buffer.at(0)?;
    let schema = buffer.at(buffer.field(message, 2)?)?;
    let fields = buffer.at(buffer.field(schema, 1)?)?;
    let count = buffer.word(fields)?;
    let mut durations = HashMap::new();
    for k in 0..count.min(bytes.len()) {
        let field = buffer.at(fields + 4 + 4 * k)?;
        let is_duration = |at| buffer.0.get(at) == Some(&DURATION);
        if !buffer.field(field, 2).is_some_and(is_duration) {
            continue;
        }
        let kind = buffer.at(buffer.field(field, 3)?)?;
        let unit = buffer
            .field(kind, 0)
            .map_or(Some(MILLISECOND), |at| buffer.half(at))?;
        let ticks = [1, 1_000, 1_000_000, 1_000_000_000].get(usize::from(unit))?;
        durations.insert(buffer.text(buffer.field(field, 0)?)?, *ticks);
    }
    Some(durations)
}

/// A flat buffer: tables of fields, which lie where a table of offsets says.
struct Buffer<'a>(&'a [u8]);

impl Buffer<'_> {
    fn half(&self, at: usize) -> Option<u16> {
        let bytes = self.0.get(at..at.checked_add(2)?)?;
        Some(u16::from_le_bytes(bytes.try_into().ok()?))
    }

    fn word(&self, at: usize) -> Option<usize> {
        let bytes = self.0.get(at..at.checked_add(4)?)?;
        usize::try_from(u32::from_le_bytes(bytes.try_into().ok()?)).ok()
    }

    /// Where an offset leads to.
    fn at(&self, offset: usize) -> Option<usize> {
        offset.checked_add(self.word(offset)?)
    }

    /// Where a field of a table lies; None where it has its default.
    fn field(&self, table: usize, number: usize) -> Option<usize> {
        let back = i64::from(u32::try_from(self.word(table)?).ok()?.cast_signed());
        let offsets = usize::try_from(i64::try_from(table).ok()? - back).ok()?;
        let slot = 4 + 2 * number;
        if slot + 2 > usize::from(self.half(offsets)?) {
            return None;
        }
        match self.half(offsets + slot)? {
            0 => None,
            offset => Some(table + usize::from(offset)),
        }
    }

    fn text(&self, offset: usize) -> Option<String> {
        let start = self.at(offset)?;
        let bytes = self
            .0
            .get(start + 4..(start + 4).checked_add(self.word(start)?)?)?;
        String::from_utf8(bytes.to_vec()).ok()
    }
}

/// The bytes of a text in base 64; None where a character is none of it.
fn base64(text: &str) -> Option<Vec<u8>> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => Some(c - b'A'),
        b'a'..=b'z' => Some(c - b'a' + 26),
        b'0'..=b'9' => Some(c - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let (mut bits, mut held) = (0u32, 0);
    let mut bytes = Vec::with_capacity(text.len());
    for c in text.trim_end_matches('=').bytes() {
        bits = (bits << 6 | u32::from(digit(c)?)) & 0xffff;
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push((bits >> held) as u8);
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns t (duration in µs), q (a number) and w (duration in ms, the unit that is not written): by pyarrow, in the
    /// format of its days before 0.15 and in that since, which begins with a mark.
    const OLDER: &str = "zAAAABAAAAAAAAoADAAGAAUACAAKAAAAAAEEAAwAAAAIAAgAAAAEAAgAAAAEAAAAAwAAAGwAAAAwAAAABAAAALD///8AAAASEAAA\
        ABgAAAAEAAAAAAAAAAEAAAB3AAAABAAEAAQAAADY////AAAAAxAAAAAUAAAABAAAAAAAAAABAAAAcQAAAMr///8AAAIAEAAUAAgA\
        AAAHAAwAAAAQABAAAAAAAAASEAAAABgAAAAEAAAAAAAAAAEAAAB0AAYACAAGAAYAAAAAAAIAAAAAAAAAAAA=";
    const NEWER: &str = "/////8gAAAAQAAAAAAAKAAwABgAFAAgACgAAAAABBAAMAAAACAAIAAAABAAIAAAABAAAAAMAAABsAAAAMAAAAAQAAACw////AAAA\
        EhAAAAAYAAAABAAAAAAAAAABAAAAdwAAAAQABAAEAAAA2P///wAAAAMQAAAAFAAAAAQAAAAAAAAAAQAAAHEAAADK////AAACABAA\
        FAAIAAAABwAMAAAAEAAQAAAAAAAAEhAAAAAYAAAABAAAAAAAAAABAAAAdAAGAAgABgAGAAAAAAACAA==";

    #[test]
    fn durations_are_read_from_older_schemas_as_from_newer_ones() {
        let expected = [("t", 1_000_000), ("w", 1000)];
        let expected = expected.map(|(name, ticks)| (name.to_string(), ticks));
        for schema in [OLDER, NEWER] {
            assert_eq!(durations(schema), HashMap::from(expected.clone()));
        }
    }

    #[test]
    fn a_schema_that_is_cut_has_no_durations() {
        for length in 0..OLDER.len() / 2 {
            assert_eq!(durations(&OLDER[..length]), HashMap::new(), "{length}");
        }
    }
}
