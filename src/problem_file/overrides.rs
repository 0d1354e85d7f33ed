//! Overrides `key=value` of a problem file: values are TOML, bare words are texts, and the place
//! of their faults is `--set key`.

use toml::de::DeTable;

use crate::fault::Place;
use crate::problem_file::document::{Entry, Node, NodeValue, Source, Table, join};
use crate::problem_file::error::{OverrideFault, ProblemFileError};
use crate::problem_file::key::{Key, is_table_of_names};

/// Most parts of a key: the deepest of the problem file has four, and tables are nested as deeply as
/// the key says.
const MOST_PARTS: usize = 16;

/// Applies the overrides in their order to the root table of a file, which has these `keys`.
pub(super) fn apply(
    root: &mut Node,
    keys: &'static [Key],
    overrides: &[String],
) -> Result<(), ProblemFileError> {
    let file = root.place.clone();
    for text in overrides {
        let place = file.clone().key(format!("--set {}", key_text(text)));
        let (segments, value) = split(text, keys).ok_or_else(|| {
            ProblemFileError::new(
                &place,
                OverrideFault::Form {
                    found: text.clone(),
                },
            )
        })?;
        check_depth(&segments, &file)?;
        let node = parse_value(value, &place)?;
        insert(root, &segments, node)?;
    }
    Ok(())
}

/// Puts a value at a key `a.b."c.d"` of the root table, which has these `keys`.
pub(super) fn set(
    root: &mut Node,
    keys: &'static [Key],
    key: &str,
    value: Node,
) -> Result<(), ProblemFileError> {
    let segments = parts(key, keys).ok_or_else(|| {
        let found = key.to_owned();
        ProblemFileError::new(&value.place, OverrideFault::Key { found })
    })?;
    check_depth(&segments, &root.place)?;
    insert(root, &segments, value)
}

fn check_depth(segments: &[String], file: &Place) -> Result<(), ProblemFileError> {
    let (parts, limit) = (segments.len(), MOST_PARTS);
    match parts > limit {
        true => Err(ProblemFileError::new(
            file,
            OverrideFault::TooDeep { parts, limit },
        )),
        false => Ok(()),
    }
}

/// The part before the value, or all of it where there is none.
fn key_text(text: &str) -> &str {
    text.split('=').next().unwrap_or(text).trim()
}

/// Splits `a.b."c.d" = value` into the parts of the key and the text of the value.
fn split<'t>(text: &'t str, keys: &'static [Key]) -> Option<(Vec<String>, &'t str)> {
    let mut quote = None;
    let equals = text.char_indices().find(|&(_, c)| match (quote, c) {
        (Some(open), c) if c == open => {
            quote = None;
            false
        }
        (None, '"' | '\'') => {
            quote = Some(c);
            false
        }
        (quote, c) => quote.is_none() && c == '=',
    });
    let (key, value) = text.split_at(equals?.0);
    let value = value[1..].trim();
    let segments = parts(key, keys)?;
    (!value.is_empty()).then_some((segments, value))
}

/// The parts of a key `a.b."c.d"`, none of them empty.
fn parts(key: &str, keys: &'static [Key]) -> Option<Vec<String>> {
    let mut segments = vec![String::new()];
    let mut quote = None;
    for c in key.chars() {
        match (quote, c) {
            (Some(open), c) if c == open => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, '.') => segments.push(String::new()),
            (None, c) if c.is_whitespace() => {}
            (_, c) => segments.last_mut()?.push(c),
        }
    }
    let segments = join_names(&segments, keys);
    let complete = segments.iter().all(|segment| !segment.is_empty());
    complete.then_some(segments)
}

/// Makes one name of what follows a table of names: a shell takes the quotes off a name with dots.
fn join_names(segments: &[String], keys: &'static [Key]) -> Vec<String> {
    for length in 1..segments.len().min(MOST_PARTS) {
        let (table, name) = segments.split_at(length);
        if is_table_of_names(keys, table) {
            let mut joined = table.to_vec();
            joined.push(name.join("."));
            return joined;
        }
    }
    segments.to_vec()
}

/// A TOML value; what is none and does not begin like a list, table or quoted text, is a text.
fn parse_value(text: &str, place: &Place) -> Result<Node, ProblemFileError> {
    const KEY: &str = "value";
    let document = format!("{KEY} = {text}");
    let bare = || Node {
        value: NodeValue::Text(text.to_owned()),
        place: place.clone(),
    };
    match DeTable::parse(&document) {
        Ok(table) if table.get_ref().len() == 1 => match table.get_ref().get(KEY) {
            Some(value) => Source::Override(place).node(value, KEY),
            None => Ok(bare()),
        },
        Err(error) if text.starts_with(['[', '{', '"', '\'']) => Err(ProblemFileError::new(
            place,
            OverrideFault::Value {
                found: text.to_owned(),
                reason: error.message().replace('\n', ", "),
            },
        )),
        _ => Ok(bare()),
    }
}

/// Puts the value at its key; tables on the way are made where they are missing.
fn insert(root: &mut Node, segments: &[String], value: Node) -> Result<(), ProblemFileError> {
    let place = value.place.clone();
    let file = root.place.clone();
    let Some((last, parents)) = segments.split_last() else {
        return Ok(());
    };
    let mut node = root;
    let mut path: Option<String> = None;
    for segment in parents {
        let below = join(path.as_deref(), segment);
        let empty = Node {
            value: NodeValue::Table(Table::default()),
            place: file.clone().key(&below),
        };
        let table = table_mut(node, path.as_deref(), &place)?;
        node = entry_mut(table, segment, || (place.clone(), empty));
        path = Some(below);
    }
    let table = table_mut(node, path.as_deref(), &place)?;
    table.entries.retain(|entry| entry.key != *last);
    table.entries.push(Entry {
        key: last.clone(),
        place,
        node: value,
    });
    Ok(())
}

fn table_mut<'a>(
    node: &'a mut Node,
    path: Option<&str>,
    place: &Place,
) -> Result<&'a mut Table, ProblemFileError> {
    let found = node.kind();
    match &mut node.value {
        NodeValue::Table(table) => Ok(table),
        _ => Err(ProblemFileError::new(
            place,
            OverrideFault::BelowValue {
                parent: path.unwrap_or_default().to_owned(),
                found,
            },
        )),
    }
}

/// The entry with this key, made where it is missing.
fn entry_mut<'a>(
    table: &'a mut Table,
    key: &str,
    make: impl FnOnce() -> (Place, Node),
) -> &'a mut Node {
    let index = table.entries.iter().position(|entry| entry.key == key);
    let index = index.unwrap_or_else(|| {
        let (place, node) = make();
        table.entries.push(Entry {
            key: key.to_owned(),
            place,
            node,
        });
        table.entries.len() - 1
    });
    &mut table.entries[index].node
}
