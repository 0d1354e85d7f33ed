//! MCAP bags, as ROS 2 writes them (and ROS 1 bags that were converted), with chunks that may be
//! compressed by LZ4 or Zstandard. Read from front to end, as a stream.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use mcap::McapError;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::bag::collect::{
    self, Entry, Message, Take, bad_message, is_joint_state,
};
use crate::recording::formats::bag::joint_state::Encoding;
use crate::recording::formats::reading::Reading;
use crate::recording::formats::reading::from_io;
use crate::recording::formats::table::Table;

/// Longest record and chunk, bytes. Writers make chunks of about a megabyte; room is made for what
/// a file claims before it is read.
const RECORD_LIMIT: usize = 1 << 28;

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
    let options = LinearReaderOptions::default()
        .with_validate_chunk_crcs(true)
        .with_record_length_limit(RECORD_LIMIT);
    let mut reader = LinearReader::new_with_options(options);
    let mut bag = Bag {
        path,
        schemas: HashMap::new(),
        channels: HashMap::new(),
        messages: 0,
        take,
    };
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| fault(path, &error))? {
            LinearReadEvent::ReadRequest(count) => {
                let read = file.read(reader.insert(count));
                reader.notify_read(read.map_err(|error| from_io(Place::file(path), &error))?);
            }
            LinearReadEvent::Record { data, opcode } => {
                let record = mcap::parse_record(opcode, data);
                bag.record(record.map_err(|error| fault(path, &error))?)?;
            }
        }
    }
    Ok(())
}

fn fault(path: &Path, error: &McapError) -> RecordingError {
    let kind = match error {
        McapError::UnsupportedCompression(name) => RecordingErrorKind::Unsupported {
            what: format!("a chunk is compressed by {name:?}").into(),
            remedy: "write it again with lz4, zstd or no compression",
        },
        error => RecordingErrorKind::Corrupt {
            format: "MCAP file",
            reason: error.to_string().into(),
        },
    };
    RecordingError::new(Place::file(path), kind)
}

struct Bag<'a, 't> {
    path: &'a Path,
    /// Types by the number of their schema.
    schemas: HashMap<u16, String>,
    /// Topic and encoding of the channels that carry joint states.
    channels: HashMap<u16, (String, Encoding)>,
    /// Joint states so far.
    messages: usize,
    take: &'a mut Take<'t>,
}

impl Bag<'_, '_> {
    fn record(&mut self, record: Record) -> Result<(), RecordingError> {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let kind = self.schemas.get(&channel.schema_id);
                let kind = kind.map_or("unknown type", String::as_str);
                let entry = Entry::Topic {
                    topic: &channel.topic,
                    kind,
                };
                (self.take)(entry).map_err(|why| bad_message(self.path, self.messages, why))?;
                if is_joint_state(kind) {
                    let encoding = encoding(self.path, &channel.message_encoding)?;
                    self.channels.insert(channel.id, (channel.topic, encoding));
                }
            }
            Record::Message { header, data } => {
                let Some((topic, encoding)) = self.channels.get(&header.channel_id) else {
                    return Ok(());
                };
                self.messages += 1;
                let message = Message {
                    topic,
                    logged: i64::try_from(header.log_time).unwrap_or(i64::MAX),
                    encoding: *encoding,
                    bytes: &data,
                };
                (self.take)(Entry::Message(message))
                    .map_err(|why| bad_message(self.path, self.messages, why))?;
            }
            _ => {}
        }
        Ok(())
    }
}

fn encoding(path: &Path, name: &str) -> Result<Encoding, RecordingError> {
    match name {
        "cdr" => Ok(Encoding::Cdr),
        "ros1" => Ok(Encoding::Ros1),
        other => Err(RecordingError::new(
            Place::file(path),
            RecordingErrorKind::Unsupported {
                what: format!("joint states are encoded as {other:?}").into(),
                remedy: "record them in the encoding of ROS 1 or ROS 2 (cdr)",
            },
        )),
    }
}
