//! What is wrong, where, and what to do about it: the shape that the errors of every layer share.
//!
//! An error of any layer can be shown to a user as `place: message; remedy`, and a test can tell
//! two errors apart by their code.

use std::fmt;
use std::path::{Path, PathBuf};

/// Where a fault lies: a file, and as much of line, column and key or channel as is known.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Place {
    /// As it was opened or named; for what is not in a file, a word for where it is.
    pub file: PathBuf,
    /// Line in the file, from 1.
    pub line: Option<usize>,
    /// Column in the line, from 1: characters of a text, fields of a table.
    pub column: Option<usize>,
    /// Key of a problem file, channel of a recording, or element of a robot description.
    pub key: Option<String>,
}

impl Place {
    /// The file as a whole.
    pub fn file(file: impl AsRef<Path>) -> Self {
        Self {
            file: file.as_ref().to_path_buf(),
            ..Self::default()
        }
    }

    /// The same place, at a line counted from 1.
    pub fn line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }

    /// The same place, at a column counted from 1.
    pub fn column(mut self, column: usize) -> Self {
        self.column = Some(column);
        self
    }

    /// The same place, at a key, channel or element.
    pub fn key(mut self, key: impl Into<String>) -> Self {
        self.key = Some(key.into());
        self
    }
}

/// Similarities at which a suggestion helps more than it puzzles: by Jaro and Winkler, which favours a common beginning, as
/// that of names that are cut short, and by the share of letters that stay, where a short word has letters exchanged.
const SIMILAR: f64 = 0.75;
const STAYS: f64 = 0.65;

/// The known name that a word is most like, whatever its case, the first of equals; `None` where it is like none of them.
pub fn nearest<'n>(word: &str, known: impl Iterator<Item = &'n str>) -> Option<String> {
    let word = word.to_lowercase();
    let mut best = None;
    let mut most = 0.0;
    for name in known {
        let other = name.to_lowercase();
        let stays = strsim::normalized_damerau_levenshtein(&word, &other) - STAYS;
        let beyond = stays.max(strsim::jaro_winkler(&word, &other) - SIMILAR);
        if beyond > most {
            (best, most) = (Some(name.to_string()), beyond);
        }
    }
    best
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        match &self.key {
            Some(key) => write!(f, ": {key}"),
            None => Ok(()),
        }
    }
}

/// A fault in words: a stable code, what was found, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Description {
    /// Stable identifier in kebab-case, one per kind of fault.
    pub code: &'static str,
    /// What is wrong, with the value found.
    pub message: String,
    /// What the user can do about it.
    pub remedy: String,
}

impl Description {
    /// Puts the three together; the remedy is an imperative that stands behind a semicolon.
    pub fn new(code: &'static str, message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
            remedy: remedy.into(),
        }
    }
}

/// An error that knows its place and can describe itself.
pub trait Fault: std::error::Error {
    /// Where the fault lies.
    fn place(&self) -> &Place;
    /// Code, message and remedy.
    fn describe(&self) -> Description;
}

/// Writes `place: message; remedy`, the form in which users see every fault.
pub fn write_fault(f: &mut fmt::Formatter<'_>, fault: &impl Fault) -> fmt::Result {
    let Description {
        message, remedy, ..
    } = fault.describe();
    write!(f, "{}: {message}; {remedy}", fault.place())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_near_is_suggested() {
        let known = [
            "estimator",
            "feasible_by",
            "bounds",
            "compare",
            "Link3",
            "wls",
        ];
        let of = |word: &str| nearest(word, known.into_iter());
        assert_eq!(of("estmator").as_deref(), Some("estimator"));
        assert_eq!(of("bound").as_deref(), Some("bounds"));
        assert_eq!(of("link_3").as_deref(), Some("Link3"));
        assert_eq!(of("wsl").as_deref(), Some("wls"));
        for word in ["wibble", "gravitation", "weights", "x", ""] {
            assert_eq!(of(word), None, "{word}");
        }
    }
}
