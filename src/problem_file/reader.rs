//! Reads the keys of one table: unknown ones are errors, the others become located values.

use std::borrow::Cow;

use crate::fault::{Fault, Place};
use crate::problem_file::document::{Entry, Node, NodeValue, Table, join};
use crate::problem_file::error::{KeyFault, ProblemFileError, ProblemFileErrorKind, ValueFault};
use crate::problem_file::key::Key;
use crate::problem_file::located::{Located, Named};
use crate::problem_file::values;

/// One table, whose keys are known.
pub(super) struct Reader<'a> {
    table: &'a Table,
    place: &'a Place,
}

impl<'a> Reader<'a> {
    /// # Errors
    /// `wrong-type` if the value is not a table, `unknown-key` for a key that is not in `known`.
    pub fn open(node: &'a Node, known: &[Key]) -> Result<Self, ProblemFileError> {
        let table = values::table(node)?;
        let has = |keys: &[Key], entry: &Entry| keys.iter().any(|key| key.name == entry.key);
        if let Some(entry) = table.entries.iter().find(|entry| !has(known, entry)) {
            return Err(ProblemFileError::new(
                &entry.place,
                KeyFault::Unknown {
                    found: entry.key.clone(),
                    known: known.iter().map(|key| key.name).collect(),
                    elsewhere: None,
                },
            ));
        }
        Ok(Self {
            table,
            place: &node.place,
        })
    }

    pub fn node(&self, key: &str) -> Option<&'a Node> {
        self.table.get(key)
    }

    /// Where the key would stand: the table's place, with the key.
    fn place(&self, key: &str) -> Place {
        self.place.clone().key(join(self.place.key.as_deref(), key))
    }

    pub fn missing(&self, key: &str, remedy: &str) -> ProblemFileError {
        ProblemFileError::new(
            &self.place(key),
            KeyFault::Missing {
                remedy: remedy.to_owned(),
            },
        )
    }

    pub fn required_node(&self, key: &str, remedy: &str) -> Result<&'a Node, ProblemFileError> {
        self.node(key).ok_or_else(|| self.missing(key, remedy))
    }

    pub fn optional<T>(
        &self,
        key: &str,
        parse: impl Fn(&Node) -> Result<T, ProblemFileError>,
    ) -> Result<Option<Located<T>>, ProblemFileError> {
        self.node(key).map(|n| located(n, &parse)).transpose()
    }

    pub fn required<T>(
        &self,
        key: &str,
        remedy: &str,
        parse: impl Fn(&Node) -> Result<T, ProblemFileError>,
    ) -> Result<Located<T>, ProblemFileError> {
        located(self.required_node(key, remedy)?, &parse)
    }

    /// The value, or its default with a place that has no line.
    pub fn or<T>(
        &self,
        key: &str,
        default: T,
        parse: impl Fn(&Node) -> Result<T, ProblemFileError>,
    ) -> Result<Located<T>, ProblemFileError> {
        Ok(self.optional(key, parse)?.unwrap_or_else(|| {
            let place = Place {
                line: None,
                column: None,
                ..self.place(key)
            };
            Located {
                value: default,
                place,
            }
        }))
    }

    /// A list, empty where the key is absent.
    pub fn list<T>(
        &self,
        key: &str,
        parse: impl Fn(&Node) -> Result<Vec<T>, ProblemFileError>,
    ) -> Result<Vec<T>, ProblemFileError> {
        self.node(key).map_or_else(|| Ok(Vec::new()), parse)
    }

    /// A table whose keys are names, empty where the key is absent.
    pub fn named<T>(
        &self,
        key: &str,
        parse: impl Fn(&Node) -> Result<T, ProblemFileError>,
    ) -> Result<Vec<Named<T>>, ProblemFileError> {
        let Some(node) = self.node(key) else {
            return Ok(Vec::new());
        };
        let entries = values::table(node)?.entries.iter();
        entries
            .map(|entry| {
                if entry.key.trim().is_empty() {
                    let kind = ValueFault::EmptyText;
                    return Err(ProblemFileError::new(&entry.place, kind));
                }
                Ok(Named {
                    name: entry.key.clone(),
                    value: located(&entry.node, &parse).map_err(|e| unquoted(entry, e))?,
                })
            })
            .collect()
    }

    /// A table, empty where the key is absent.
    pub fn table(&self, key: &str) -> Cow<'a, Node> {
        self.node(key).map_or_else(
            || {
                Cow::Owned(Node {
                    value: NodeValue::Table(Table::default()),
                    place: Place {
                        line: None,
                        column: None,
                        ..self.place(key)
                    },
                })
            },
            Cow::Borrowed,
        )
    }

    /// A list of tables, empty where the key is absent.
    pub fn tables(&self, key: &str) -> Result<&'a [Node], ProblemFileError> {
        self.node(key).map_or(Ok(&[]), |node| {
            values::items(
                node,
                "a list of tables, each under its own header in double brackets",
            )
        })
    }

    /// # Errors
    /// `conflict`, where the table has more than one of these keys; placed at the last of them.
    pub fn at_most_one(&self, keys: &[&str]) -> Result<(), ProblemFileError> {
        let mut given = Vec::new();
        for entry in &self.table.entries {
            if keys.contains(&entry.key.as_str()) {
                given.push(entry);
            }
        }
        match given.as_slice() {
            [.., first, last] => Err(ProblemFileError::new(
                &last.place,
                KeyFault::Conflict {
                    found: format!("both \"{}\" and \"{}\" are given", first.key, last.key),
                    remedy: format!("keep one of {}", keys.join(", ")),
                },
            )),
            _ => Ok(()),
        }
    }
}

/// A table where a name ought to have a value comes from a name with dots and no quotes.
fn unquoted(entry: &Entry, error: ProblemFileError) -> ProblemFileError {
    match (&entry.node.value, error.kind()) {
        (
            NodeValue::Table(_),
            ProblemFileErrorKind::Value(ValueFault::WrongType { expected, .. }),
        ) if *error.place() == entry.node.place => {
            ProblemFileError::new(&entry.place, ValueFault::UnquotedName { expected })
        }
        _ => error,
    }
}

fn located<T>(
    node: &Node,
    parse: &impl Fn(&Node) -> Result<T, ProblemFileError>,
) -> Result<Located<T>, ProblemFileError> {
    Ok(Located {
        value: parse(node)?,
        place: node.place.clone(),
    })
}
