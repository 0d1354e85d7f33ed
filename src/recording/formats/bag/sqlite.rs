//! ROS 2 bags in SQLite databases, their messages as they are or each compressed by Zstandard
//! (`--compression-mode message`).

use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

use rusqlite::types::ValueRef;
use rusqlite::{Connection, Error, OpenFlags};

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::bag::collect::{
    self, Entry, Message, Take, bad_message, is_joint_state,
};
use crate::recording::formats::bag::joint_state::Encoding;
use crate::recording::formats::reading::{Reading, interrupted};
use crate::recording::formats::table::Table;

/// The first bytes of a message that is compressed by Zstandard; one that is not begins with 0.
const ZSTANDARD: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];

/// Longest message, bytes: a joint state of ten thousand joints stays below.
const MESSAGE_LIMIT: u64 = 1 << 20;

/// Steps of the virtual machine of SQLite between two looks at an interrupt, and such spans in all: a message takes some
/// twenty steps, so that bags of the most rows stay far below, and a query without end is over in a minute.
const STEPS: std::ffi::c_int = 10_000;
const MOST_STEPS: u64 = 1_000_000;

/// Column names of a bag.
pub fn columns(path: &Path, reading: &Reading) -> Result<Vec<String>, RecordingError> {
    collect::columns(path, reading, container)
}

/// The wanted columns of a bag.
pub fn read(path: &Path, wanted: &[String], reading: &Reading) -> Result<Table, RecordingError> {
    collect::read(path, reading, wanted, container)
}

fn container(path: &Path, reading: &Reading, take: &mut Take) -> Result<(), RecordingError> {
    let mut messages = 0;
    match read_database(path, reading, take, &mut messages) {
        Ok(()) => Ok(()),
        Err(Stop::Message(reason)) => Err(bad_message(path, messages, reason)),
        Err(Stop::Reading(error)) => Err(error),
        Err(Stop::Database(_)) if reading.is_interrupted() => Err(interrupted(path)),
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
    Reading(RecordingError),
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Database(error)
    }
}

fn read_database(
    path: &Path,
    reading: &Reading,
    take: &mut Take,
    messages: &mut usize,
) -> Result<(), Stop> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let mut database = Connection::open_with_flags(path, flags)?;
    let reading_too = reading.clone();
    let mut left = MOST_STEPS;
    database.progress_handler(
        STEPS,
        Some(move || {
            left = left.saturating_sub(1);
            left == 0 || reading_too.is_interrupted()
        }),
    )?;
    require_tables(&database)?;
    let topics = joint_state_topics(&database, take)?;
    let mut query =
        database.prepare("SELECT topic_id, timestamp, data FROM messages ORDER BY id")?;
    let mut rows = query.query([])?;
    let mut all = 0;
    while let Some(row) = rows.next()? {
        all += 1;
        reading.takes_rows(path, all).map_err(Stop::Reading)?;
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

/// Bags have tables: a view can name itself, and its rows have no end.
fn require_tables(database: &Connection) -> Result<(), Stop> {
    let sql = "SELECT count(*) FROM sqlite_master WHERE name IN ('topics', 'messages') AND type = 'table' \
               AND sql NOT LIKE 'CREATE VIRTUAL%'";
    let tables: i64 = database.query_row(sql, [], |row| row.get(0))?;
    match tables {
        2 => Ok(()),
        _ => Err(Stop::Database(Error::InvalidParameterName(
            "it has no tables `topics` and `messages`".into(),
        ))),
    }
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
