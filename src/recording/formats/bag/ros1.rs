//! ROS 1 bags, format 2.0: records of a header and data, most of them in chunks that may be
//! compressed by bzip2 or LZ4. Read from front to end, so that a bag without index is read too.
//! Source: ROS wiki, Bags/Format/2.0.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use bzip2::read::MultiBzDecoder;
use lz4_flex::frame::FrameDecoder;

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::bag::collect::{
    self, Entry, Message, Take, bad_message, is_joint_state,
};
use crate::recording::formats::bag::joint_state::Encoding;
use crate::recording::formats::number_type::{ByteOrder, NumberType};
use crate::recording::formats::reading::from_io;
use crate::recording::formats::reading::{self, Reading};
use crate::recording::formats::table::Table;

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

/// Longest header of a record, bytes: names of fields and topics, and numbers.
const HEADER_LIMIT: u32 = 1 << 16;

// Kinds of records.
const MESSAGE: u8 = 0x02;
const CHUNK: u8 = 0x05;
const CONNECTION: u8 = 0x07;

/// Column names of a bag.
pub fn columns(path: &Path, reading: &Reading) -> Result<Vec<String>, RecordingError> {
    collect::columns(path, reading, container)
}

/// The wanted columns of a bag.
pub fn read(path: &Path, wanted: &[String], reading: &Reading) -> Result<Table, RecordingError> {
    collect::read(path, reading, wanted, container)
}

fn container(path: &Path, reading: &Reading, take: &mut Take) -> Result<(), RecordingError> {
    let file = File::open(path).map_err(|error| from_io(Place::file(path), &error))?;
    let mut file = reading.metered(BufReader::new(file));
    let mut magic = Vec::new();
    let limit = MAGIC.len() as u64;
    let read = file.by_ref().take(limit).read_to_end(&mut magic);
    read.map_err(|error| from_io(Place::file(path), &error))?;
    if magic != MAGIC {
        let reason = "it does not begin with \"#ROSBAG V2.0\"";
        return Err(Stop::from(reason).at(path, 0));
    }
    let mut bag = Bag {
        topics: HashMap::new(),
        messages: 0,
        reading,
        take,
    };
    let read = bag.records(&mut file, Depth::File);
    read.map_err(|stop| stop.at(path, bag.messages))
}

/// Why reading ends early.
enum Stop {
    Container(String),
    Message(String),
    Compression(String),
    Reading(reading::Stop),
}

impl From<&str> for Stop {
    fn from(reason: &str) -> Self {
        Self::Container(reason.into())
    }
}

impl From<std::io::Error> for Stop {
    fn from(error: std::io::Error) -> Self {
        match reading::Stop::of(&error) {
            Some(stop) => Self::Reading(stop),
            None => Self::Container(error.to_string()),
        }
    }
}

impl Stop {
    fn at(self, path: &Path, messages: usize) -> RecordingError {
        let kind = match self {
            Self::Message(reason) => return bad_message(path, messages, reason),
            Self::Reading(stop) => return stop.at(Place::file(path)),
            Self::Container(reason) => RecordingErrorKind::Corrupt {
                format: "ROS 1 bag",
                reason: reason.into(),
            },
            Self::Compression(name) => RecordingErrorKind::Unsupported {
                what: format!("a chunk is compressed by {name:?}").into(),
                remedy: "write it again with bz2, lz4 or no compression",
            },
        };
        RecordingError::new(Place::file(path), kind)
    }
}

/// Whether records lie in the file itself or in a chunk, which holds no chunk.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Depth {
    File,
    Chunk,
}

struct Bag<'a, 't> {
    /// Topics of the connections that carry joint states.
    topics: HashMap<u32, String>,
    /// Joint states so far.
    messages: usize,
    reading: &'a Reading,
    take: &'a mut Take<'t>,
}

impl Bag<'_, '_> {
    fn records(&mut self, source: &mut impl Read, depth: Depth) -> Result<(), Stop> {
        let (mut header, mut data) = (Vec::new(), Vec::new());
        while let Some(length) = length(source)? {
            if length > HEADER_LIMIT {
                return Err("the header of a record is too long".into());
            }
            fill(source, length, &mut header)?;
            let Some(length) = self::length(source)? else {
                return Err("it ends within a record".into());
            };
            fill(source, length, &mut data)?;
            match field(&header, "op")? {
                [MESSAGE] => self.message(&header, &data)?,
                [CONNECTION] => self.connection(&header, &data)?,
                [CHUNK] if depth == Depth::File => self.chunk(&header, &data)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn chunk(&mut self, header: &[u8], data: &[u8]) -> Result<(), Stop> {
        match field(header, "compression")? {
            b"none" => self.records(&mut &data[..], Depth::Chunk),
            b"bz2" => {
                let chunk = MultiBzDecoder::new(data);
                self.records(&mut self.reading.metered(chunk), Depth::Chunk)
            }
            b"lz4" => {
                let chunk = FrameDecoder::new(data);
                self.records(&mut self.reading.metered(chunk), Depth::Chunk)
            }
            other => {
                let name = String::from_utf8_lossy(other).into_owned();
                Err(Stop::Compression(name))
            }
        }
    }

    fn connection(&mut self, header: &[u8], data: &[u8]) -> Result<(), Stop> {
        let topic = String::from_utf8_lossy(field(header, "topic")?).into_owned();
        let kind = String::from_utf8_lossy(field(data, "type")?).into_owned();
        let entry = Entry::Topic {
            topic: &topic,
            kind: &kind,
        };
        (self.take)(entry).map_err(Stop::Message)?;
        if is_joint_state(&kind) {
            self.topics.insert(number(header, "conn")?, topic);
        }
        Ok(())
    }

    fn message(&mut self, header: &[u8], data: &[u8]) -> Result<(), Stop> {
        let connection = number(header, "conn")?;
        let Some(topic) = self.topics.get(&connection) else {
            return Ok(());
        };
        let time = NumberType::U32.decode(field(header, "time")?, ByteOrder::Little);
        let [seconds, nanoseconds] = time[..] else {
            return Err("a message has no time".into());
        };
        self.messages += 1;
        let message = Message {
            topic,
            logged: seconds as i64 * 1_000_000_000 + nanoseconds as i64,
            encoding: Encoding::Ros1,
            bytes: data,
        };
        (self.take)(Entry::Message(message)).map_err(Stop::Message)
    }
}

/// The number of bytes that follow; None at the end.
fn length(source: &mut impl Read) -> Result<Option<u32>, Stop> {
    let mut bytes = Vec::new();
    source.by_ref().take(4).read_to_end(&mut bytes)?;
    match <[u8; 4]>::try_from(bytes) {
        Ok(bytes) => Ok(Some(u32::from_le_bytes(bytes))),
        Err(bytes) if bytes.is_empty() => Ok(None),
        Err(_) => Err("it ends within a record".into()),
    }
}

/// Reads exactly so many bytes; room grows with what is really there.
fn fill(source: &mut impl Read, length: u32, buffer: &mut Vec<u8>) -> Result<(), Stop> {
    buffer.clear();
    let length = u64::from(length);
    source.by_ref().take(length).read_to_end(buffer)?;
    match buffer.len() as u64 == length {
        true => Ok(()),
        false => Err("it ends within a record".into()),
    }
}

/// The value of a field of a header: length, name, `=`, value.
fn field<'h>(header: &'h [u8], name: &str) -> Result<&'h [u8], Stop> {
    let mut rest = header;
    while let Some((length, after)) = rest.split_first_chunk::<4>() {
        let length = u32::from_le_bytes(*length) as usize;
        let Some((entry, after)) = after.split_at_checked(length) else {
            break;
        };
        let value = entry.strip_prefix(name.as_bytes());
        if let Some(value) = value.and_then(|value| value.strip_prefix(b"=")) {
            return Ok(value);
        }
        rest = after;
    }
    Err(Stop::Container(format!("a record has no field {name}")))
}

fn number(header: &[u8], name: &str) -> Result<u32, Stop> {
    let bytes = field(header, name)?.try_into();
    let bytes = bytes.map_err(|_| Stop::Container(format!("the field {name} is no number")))?;
    Ok(u32::from_le_bytes(bytes))
}
