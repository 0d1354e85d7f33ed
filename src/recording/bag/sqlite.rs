//! ROS 2 bags in SQLite databases, their messages as they are or each compressed by Zstandard
//! (`--compression-mode message`).

use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

use rusqlite::types::ValueRef;
use rusqlite::{Connection, Error, OpenFlags};

use crate::fault::Place;
use crate::recording::bag::collect::{self, Entry, Message, Take, bad_message, is_joint_state};
use crate::recording::bag::joint_state::Encoding;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::table::Table;

/// The first bytes of a message that is compressed by Zstandard; one that is not begins with 0.
const ZSTANDARD: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];

/// Longest message, bytes: a joint state of ten thousand joints stays below.
const MESSAGE_LIMIT: u64 = 1 << 20;

/// Column names of a bag.
pub fn columns(path: &Path) -> Result<Vec<String>, RecordingError> {
    collect::columns(path, container)
}

/// The wanted columns of a bag.
pub fn read(path: &Path, wanted: &[String]) -> Result<Table, RecordingError> {
    collect::read(path, wanted, container)
}

fn container(path: &Path, take: &mut Take) -> Result<(), RecordingError> {
    let mut messages = 0;
    match read_database(path, take, &mut messages) {
        Ok(()) => Ok(()),
        Err(Stop::Message(reason)) => Err(bad_message(path, messages, reason)),
        Err(Stop::Database(error)) => {
            let kind = RecordingErrorKind::Corrupt {
                format: "ROS 2 bag in SQLite",
                reason: error.to_string().into(),
            };
            Err(RecordingError::new(Place::file(path), kind))
        }
    }
}

/// Why reading ends early.
enum Stop {
    Database(Error),
    Message(String),
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Database(error)
    }
}

fn read_database(path: &Path, take: &mut Take, messages: &mut usize) -> Result<(), Stop> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let database = Connection::open_with_flags(path, flags)?;
    let topics = joint_state_topics(&database, take)?;
    let mut query =
        database.prepare("SELECT topic_id, timestamp, data FROM messages ORDER BY id")?;
    let mut rows = query.query([])?;
    while let Some(row) = rows.next()? {
        let Some(topic) = topics.get(&row.get(0)?) else {
            continue;
        };
        *messages += 1;
        let (ValueRef::Integer(logged), ValueRef::Blob(bytes)) = (row.get_ref(1)?, row.get_ref(2)?)
        else {
            return Err(Stop::Message("its time or content has another type".into()));
        };
        let decompressed = decompress(bytes)?;
        let message = Message {
            topic,
            logged,
            encoding: Encoding::Cdr,
            bytes: decompressed.as_deref().unwrap_or(bytes),
        };
        take(Entry::Message(message)).map_err(Stop::Message)?;
    }
    Ok(())
}

/// Names of the topics with joint states, by their number.
fn joint_state_topics(
    database: &Connection,
    take: &mut Take,
) -> Result<HashMap<i64, String>, Stop> {
    let mut topics = HashMap::new();
    let mut query = database.prepare("SELECT id, name, type FROM topics")?;
    let mut rows = query.query([])?;
    while let Some(row) = rows.next()? {
        let (id, topic, kind): (i64, String, String) = (row.get(0)?, row.get(1)?, row.get(2)?);
        let entry = Entry::Topic {
            topic: &topic,
            kind: &kind,
        };
        take(entry).map_err(Stop::Message)?;
        if is_joint_state(&kind) {
            topics.insert(id, topic);
        }
    }
    Ok(topics)
}

/// The content of a compressed message; None where it is not compressed.
fn decompress(bytes: &[u8]) -> Result<Option<Vec<u8>>, Stop> {
    if !bytes.starts_with(ZSTANDARD) {
        return Ok(None);
    }
    let fault = |error: std::io::Error| Stop::Message(format!("decompressing it fails: {error}"));
    let decoder = zstd::stream::read::Decoder::new(bytes).map_err(fault)?;
    let mut content = Vec::new();
    let mut bounded = decoder.take(MESSAGE_LIMIT + 1);
    bounded.read_to_end(&mut content).map_err(fault)?;
    match content.len() as u64 > MESSAGE_LIMIT {
        true => Err(Stop::Message(format!(
            "it is longer than {MESSAGE_LIMIT} bytes"
        ))),
        false => Ok(Some(content)),
    }
}
