//! The text of a problem file as a tree of values that each know their place: file, line, column
//! and key.

use std::cell::Cell;
use std::fs;
use std::io::{self, Read};
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::fault::Place;
use crate::problem_file::error::{FileFault, NumberFault, ProblemFileError};

/// A value and its place.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub value: NodeValue,
    pub place: Place,
}

#[derive(Debug, Clone)]
pub(super) enum NodeValue {
    Text(String),
    Integer(i64),
    Number(f64),
    Boolean(bool),
    /// A date or time, as written.
    Date(String),
    List(Vec<Node>),
    Table(Table),
}

/// Entries in the order of the file, each key once.
#[derive(Debug, Clone, Default)]
pub(super) struct Table {
    pub entries: Vec<Entry>,
}

#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub key: String,
    /// Where the key stands.
    pub place: Place,
    pub node: Node,
}

impl Table {
    pub fn get(&self, key: &str) -> Option<&Node> {
        let entry = self.entries.iter().find(|entry| entry.key == key);
        entry.map(|entry| &entry.node)
    }
}

impl Node {
    /// What the value is, in words, for messages.
    pub fn kind(&self) -> &'static str {
        match self.value {
            NodeValue::Text(_) => "a text",
            NodeValue::Integer(_) | NodeValue::Number(_) => "a number",
            NodeValue::Boolean(_) => "true or false",
            NodeValue::Date(_) => "a date",
            NodeValue::List(_) => "a list",
            NodeValue::Table(_) => "a table",
        }
    }

    /// The value as JSON. Infinite numbers are texts there.
    pub fn to_json(&self) -> serde_json::Value {
        match &self.value {
            NodeValue::Text(text) | NodeValue::Date(text) => text.as_str().into(),
            NodeValue::Integer(integer) => (*integer).into(),
            NodeValue::Number(number) if number.is_finite() => (*number).into(),
            NodeValue::Number(number) => number.to_string().into(),
            NodeValue::Boolean(boolean) => (*boolean).into(),
            NodeValue::List(items) => items.iter().map(Self::to_json).collect(),
            NodeValue::Table(table) => table
                .entries
                .iter()
                .map(|entry| (entry.key.clone(), entry.node.to_json()))
                .collect(),
        }
    }

    /// The node that [`Self::to_json`] has written; its places have a key and no line.
    pub fn from_json(json: &serde_json::Value, place: Place) -> Self {
        let below = |key: &str| place.clone().key(join(place.key.as_deref(), key));
        let value = match json {
            serde_json::Value::String(text) => match text.as_str() {
                "inf" => NodeValue::Number(f64::INFINITY),
                "-inf" => NodeValue::Number(f64::NEG_INFINITY),
                text => NodeValue::Text(text.to_owned()),
            },
            serde_json::Value::Number(number) => match number.as_i64() {
                Some(integer) => NodeValue::Integer(integer),
                None => NodeValue::Number(number.as_f64().unwrap_or(f64::NAN)),
            },
            serde_json::Value::Bool(boolean) => NodeValue::Boolean(*boolean),
            serde_json::Value::Array(items) => {
                let items = items
                    .iter()
                    .map(|item| Self::from_json(item, place.clone()));
                NodeValue::List(items.collect())
            }
            serde_json::Value::Object(entries) => {
                let entries = entries.iter().map(|(key, value)| Entry {
                    key: key.clone(),
                    place: below(key),
                    node: Self::from_json(value, below(key)),
                });
                NodeValue::Table(Table {
                    entries: entries.collect(),
                })
            }
            // No value of a problem file is written as null; readers refuse it as not a number.
            serde_json::Value::Null => NodeValue::Number(f64::NAN),
        };
        Self { value, place }
    }

    /// The value as TOML. Dates are texts there.
    pub fn to_toml(&self) -> toml::Value {
        match &self.value {
            NodeValue::Text(text) | NodeValue::Date(text) => text.as_str().into(),
            NodeValue::Integer(integer) => (*integer).into(),
            NodeValue::Number(number) => (*number).into(),
            NodeValue::Boolean(boolean) => (*boolean).into(),
            NodeValue::List(items) => toml::Value::Array(items.iter().map(Self::to_toml).collect()),
            NodeValue::Table(table) => toml::Value::Table(
                table
                    .entries
                    .iter()
                    .map(|entry| (entry.key.clone(), entry.node.to_toml()))
                    .collect(),
            ),
        }
    }
}

/// Largest problem file, bytes: names and numbers of a thousand joints stay far below it.
const SIZE_LIMIT: u64 = 4 << 20;

/// Reads the text of a file.
pub(super) fn read_text(path: &Path) -> Result<String, ProblemFileError> {
    let place = Place::file(path);
    if path.is_dir() {
        return Err(ProblemFileError::new(&place, FileFault::IsDirectory));
    }
    let unreadable = |error: io::Error| {
        let kind = match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => FileFault::Missing,
            io::ErrorKind::PermissionDenied => FileFault::PermissionDenied,
            _ => FileFault::Unreadable {
                reason: error.to_string(),
            },
        };
        ProblemFileError::new(&place, kind)
    };
    let check_size = |bytes: u64| match bytes > SIZE_LIMIT {
        true => {
            let limit = SIZE_LIMIT;
            let kind = FileFault::TooLarge { bytes, limit };
            Err(ProblemFileError::new(&place, kind))
        }
        false => Ok(()),
    };
    let file = fs::File::open(path).map_err(unreadable)?;
    check_size(file.metadata().map_err(unreadable)?.len())?;
    let mut bytes = Vec::new();
    // A pipe or device states no size: at most the limit is read of it.
    let mut bounded = file.take(SIZE_LIMIT + 1);
    bounded.read_to_end(&mut bytes).map_err(unreadable)?;
    check_size(bytes.len() as u64)?;
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let bytes = error.as_bytes();
        let text = String::from_utf8_lossy(&bytes[..valid]);
        let byte = bytes.get(valid).copied().unwrap_or_default();
        ProblemFileError::new(
            &Positions::new(path, &text).place(valid, None),
            FileFault::NotUtf8 {
                byte,
                is_named_toml: is_named_toml(path),
            },
        )
    })
}

/// Whether a file is named as a problem file is.
fn is_named_toml(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Parses the text of the file at `path` into its root table.
pub(super) fn parse(path: &Path, text: &str) -> Result<Node, ProblemFileError> {
    if text.trim_start_matches('\u{feff}').trim().is_empty() {
        return Err(ProblemFileError::new(&Place::file(path), FileFault::Empty));
    }
    let positions = Positions::new(path, text);
    let table = DeTable::parse(text).map_err(|error| {
        let offset = error.span().map_or(text.len(), |span| span.start);
        let reason = error.message().replace('\n', ", ");
        let is_named_toml = is_named_toml(path);
        let fault = FileFault::Syntax {
            reason,
            is_named_toml,
        };
        ProblemFileError::new(&positions.place(offset, None), fault)
    })?;
    let source = Source::File(&positions);
    Ok(Node {
        value: NodeValue::Table(source.table(table.get_ref(), None)?),
        place: Place::file(path),
    })
}

/// Lines of a text, to turn an offset in bytes into line and column.
pub(super) struct Positions<'a> {
    path: &'a Path,
    text: &'a str,
    /// Offset of the first byte of each line.
    starts: Vec<usize>,
    /// The place that was asked for last: the next one is mostly on the same line, which can be as long as the file.
    last: Cell<Reached>,
}

/// An offset in bytes, and how many characters are before it on its line.
#[derive(Clone, Copy, Default)]
struct Reached {
    offset: usize,
    characters: usize,
}

impl<'a> Positions<'a> {
    fn new(path: &'a Path, text: &'a str) -> Self {
        let ends = text.match_indices('\n').map(|(offset, _)| offset + 1);
        Self {
            path,
            text,
            starts: std::iter::once(0).chain(ends).collect(),
            last: Cell::default(),
        }
    }

    fn place(&self, offset: usize, key: Option<&str>) -> Place {
        let line = self.starts.partition_point(|start| *start <= offset);
        let place = Place::file(self.path)
            .line(line)
            .column(self.characters_before(offset, self.starts[line - 1]) + 1);
        match key {
            Some(key) => place.key(key),
            None => place,
        }
    }

    /// Characters between the start of a line and an offset.
    fn characters_before(&self, offset: usize, start: usize) -> usize {
        let last = self.last.get();
        let known = match (start..=offset).contains(&last.offset) {
            true => last,
            false => Reached {
                offset: start,
                characters: 0,
            },
        };
        let further = self.text.get(known.offset..offset).unwrap_or_default();
        let characters = known.characters + further.chars().count();
        self.last.set(Reached { offset, characters });
        characters
    }
}

/// Where values come from.
pub(super) enum Source<'a> {
    File(&'a Positions<'a>),
    /// An override, whose place holds for all of its value.
    Override(&'a Place),
}

impl Source<'_> {
    fn place(&self, offset: usize, key: Option<&str>) -> Place {
        match self {
            Self::File(positions) => positions.place(offset, key),
            Self::Override(place) => (*place).clone(),
        }
    }

    fn table(&self, table: &DeTable, path: Option<&str>) -> Result<Table, ProblemFileError> {
        let mut entries: Vec<(usize, Entry)> = Vec::with_capacity(table.len());
        for (key, value) in table {
            let path = join(path, key.get_ref());
            let offset = key.span().start;
            let place = self.place(offset, Some(&path));
            let mut node = self.node(value, &path)?;
            if let NodeValue::Table(_) = node.value {
                // A fault of a table as a whole is shown at its header, not inside it.
                node.place = place.clone();
            }
            let key = key.get_ref().to_string();
            entries.push((offset, Entry { key, place, node }));
        }
        entries.sort_by_key(|(offset, _)| *offset);
        let entries = entries.into_iter().map(|(_, entry)| entry).collect();
        Ok(Table { entries })
    }

    pub(super) fn node(
        &self,
        value: &Spanned<DeValue>,
        path: &str,
    ) -> Result<Node, ProblemFileError> {
        let place = self.place(value.span().start, Some(path));
        let too_large = |found: &str| {
            ProblemFileError::new(
                &place,
                NumberFault::TooLarge {
                    found: found.to_owned(),
                },
            )
        };
        let value = match value.get_ref() {
            DeValue::String(text) => NodeValue::Text(text.to_string()),
            DeValue::Integer(integer) => NodeValue::Integer(
                i64::from_str_radix(integer.as_str(), integer.radix())
                    .map_err(|_| too_large(&integer.to_string()))?,
            ),
            DeValue::Float(float) => {
                let text = float.as_str();
                let number: f64 = text.parse().map_err(|_| too_large(text))?;
                if number.is_infinite() && !text.contains("inf") {
                    return Err(too_large(text));
                }
                NodeValue::Number(number)
            }
            DeValue::Boolean(boolean) => NodeValue::Boolean(*boolean),
            DeValue::Datetime(date) => NodeValue::Date(date.to_string()),
            DeValue::Array(items) => NodeValue::List(
                items
                    .iter()
                    .map(|item| self.node(item, path))
                    .collect::<Result<_, _>>()?,
            ),
            DeValue::Table(table) => NodeValue::Table(self.table(table, Some(path))?),
        };
        Ok(Node { value, place })
    }
}

/// The path of a key: `fit.estimator`, in quotes where the key has dots or other marks.
pub(super) fn join(parent: Option<&str>, key: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let key = match !key.is_empty() && key.chars().all(bare) {
        true => key.to_owned(),
        false => format!("\"{key}\""),
    };
    match parent {
        Some(parent) => format!("{parent}.{key}"),
        None => key,
    }
}
