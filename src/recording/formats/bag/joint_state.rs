//! One message of type sensor_msgs/JointState, in the serialisation of ROS 1 or in the Common Data
//! Representation of ROS 2. Source: Object Management Group, DDS-RTPS 2.2, section 10, and CORBA 3.0,
//! section 15.3; ROS wiki, message serialisation.

use crate::recording::formats::number_type::{ByteOrder, NumberType};

/// How a message is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Packed, the least significant byte first.
    Ros1,
    /// Four bytes that name the byte order, then numbers aligned to their size.
    Cdr,
}

/// Names and channels; a channel is empty where nothing is known of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct JointState {
    /// Time of measurement since 1970 (or since the start of a simulation), ns; 0: not stamped.
    pub stamp: i64,
    pub names: Vec<String>,
    /// Position, velocity, effort.
    pub channels: [Vec<f64>; 3],
}

impl JointState {
    /// Decodes a message. Errors: in words, where it ends too early or contradicts itself.
    pub fn decode(bytes: &[u8], encoding: Encoding) -> Result<Self, String> {
        let mut source = Source::new(bytes, encoding)?;
        if encoding == Encoding::Ros1 {
            source.word()?; // The sequence number of the header.
        }
        let seconds = i64::from(source.word()? as i32);
        let stamp = seconds * 1_000_000_000 + i64::from(source.word()?);
        source.text()?; // The frame of the header.
        let count = source.count()?;
        let names: Vec<String> = (0..count)
            .map(|_| source.text())
            .collect::<Result<_, _>>()?;
        let channels = [source.doubles()?, source.doubles()?, source.doubles()?];
        for (channel, what) in channels.iter().zip(["positions", "velocities", "efforts"]) {
            if !channel.is_empty() && channel.len() != names.len() {
                let (found, expected) = (channel.len(), names.len());
                return Err(format!("it has {found} {what} for {expected} joints"));
            }
        }
        Ok(Self {
            stamp,
            names,
            channels,
        })
    }
}

/// Takes values off a message.
struct Source<'a> {
    bytes: &'a [u8],
    at: usize,
    order: ByteOrder,
    encoding: Encoding,
}

impl<'a> Source<'a> {
    fn new(bytes: &'a [u8], encoding: Encoding) -> Result<Self, String> {
        let (bytes, order) = match (encoding, bytes) {
            (Encoding::Ros1, bytes) => (bytes, ByteOrder::Little),
            (Encoding::Cdr, [0, 0, _, _, rest @ ..]) => (rest, ByteOrder::Big),
            (Encoding::Cdr, [0, 1, _, _, rest @ ..]) => (rest, ByteOrder::Little),
            (Encoding::Cdr, _) => return Err("it is not in plain CDR".into()),
        };
        Ok(Self {
            bytes,
            at: 0,
            order,
            encoding,
        })
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let Some(taken) = rest.get(..count) else {
            return Err(format!("it ends after {} bytes", self.bytes.len()));
        };
        self.at += count;
        Ok(taken)
    }

    fn align(&mut self, size: usize) {
        if self.encoding == Encoding::Cdr {
            self.at = self.at.next_multiple_of(size);
        }
    }

    fn word(&mut self) -> Result<u32, String> {
        self.align(4);
        let bytes = self.take(4)?;
        Ok(NumberType::U32.decode(bytes, self.order)[0] as u32)
    }

    /// The length of a sequence, which has at least one byte per entry.
    fn count(&mut self) -> Result<usize, String> {
        let count = self.word()? as usize;
        match count <= self.bytes.len() - self.at.min(self.bytes.len()) {
            true => Ok(count),
            false => Err(format!("it promises {count} entries and ends before them")),
        }
    }

    fn text(&mut self) -> Result<String, String> {
        let count = self.count()?;
        let mut bytes = self.take(count)?;
        if self.encoding == Encoding::Cdr {
            bytes = bytes.strip_suffix(b"\0").unwrap_or(bytes);
        }
        let text = std::str::from_utf8(bytes).map_err(|_| "a name is not UTF-8 text")?;
        Ok(text.into())
    }

    fn doubles(&mut self) -> Result<Vec<f64>, String> {
        let count = self.count()?;
        if count == 0 {
            return Ok(Vec::new());
        }
        self.align(8);
        let bytes = self.take(8 * count)?;
        Ok(NumberType::F64.decode(bytes, self.order))
    }
}
