//! The reference of problem files in Markdown, from the tables of keys: type, unit, default, meaning and example of each.

use crate::problem_file::KEYS;
use crate::problem_file::key::{Form, Key, Length, REQUIRED, Range, sections};

/// Every table with its keys.
pub fn markdown() -> String {
    let mut text = String::from(
        "# Keys of problem files\n\nPaths start from the problem file's folder. Units are SI; those of sliding joints stand in \
         brackets. A value per joint is one number for all joints or a list in their order. Keys are there since version 0.1.0, \
         the first, where their meaning names no later one.\n",
    );
    for section in sections(KEYS) {
        let title = match section.header.as_str() {
            "" => "Top level".to_owned(),
            header => format!("`{header}`"),
        };
        text.push_str(&format!(
            "\n## {title}\n\n| key | type | unit | default | meaning | example |\n|---|---|---|---|---|---|\n"
        ));
        for key in section.keys {
            text.push_str(&row(key));
        }
    }
    text
}

fn row(key: &Key) -> String {
    let code = |text: &str| match text {
        "" => String::new(),
        text => format!("`{text}`"),
    };
    let default = match key.default_is_value() {
        true => code(key.default),
        false => key.default.to_owned(),
    };
    let cells = [
        code(key.name),
        key.form.in_words(),
        key.unit.to_owned(),
        default,
        key.meaning.replace('<', "&lt;"),
        code(key.example),
    ];
    let cells = cells.map(|cell| cell.replace('|', "\\|"));
    format!("| {} |\n", cells.join(" | "))
}

impl Key {
    /// Whether the default is a value and not words.
    fn default_is_value(&self) -> bool {
        toml::from_str::<toml::Table>(&format!("value = {}", self.default)).is_ok()
    }

    /// Meaning, unit and default in a sentence or two, as an editor shows them.
    pub(super) fn in_words(&self) -> String {
        let unit = match self.unit {
            "" => String::new(),
            unit => format!(" Unit: {unit}."),
        };
        let default = match self.default {
            REQUIRED => " Required.".to_owned(),
            default => format!(" Default: {default}."),
        };
        format!("{}.{unit}{default}", self.meaning)
    }
}

impl Form {
    fn in_words(&self) -> String {
        match self {
            Self::Text => "text".to_owned(),
            Self::File => "file".to_owned(),
            Self::Boolean => "true or false".to_owned(),
            Self::Number(range) => range.of("number"),
            Self::PerJoint(range) => format!("{} per joint", range.of("number")),
            Self::Count(least) => format!("whole number from {least}"),
            Self::Words(words) => {
                let words: Vec<String> = words().iter().map(|w| format!("`\"{w}\"`")).collect();
                words.join(", ")
            }
            Self::Effect => "effect".to_owned(),
            Self::List(item, length) => format!("{} of: {}", length.in_words(), item.in_words()),
            Self::Table(_) => "table".to_owned(),
            Self::Named(form) => format!("by name: {}", form.in_words()),
            Self::NamedTables(_) => "by joint: table".to_owned(),
            Self::Either(forms) => {
                let forms: Vec<String> = forms.iter().map(Self::in_words).collect();
                forms.join("; or ")
            }
        }
    }
}

impl Range {
    fn of(self, noun: &str) -> String {
        match self {
            Self::Any => format!("{noun}, perhaps infinite"),
            Self::Finite => noun.to_owned(),
            Self::Positive => format!("{noun} > 0"),
            Self::NonNegative => format!("{noun} >= 0"),
            Self::Nonzero => format!("{noun} other than 0"),
            Self::Correlation => format!("0 <= {noun} < 1"),
            Self::Probability => format!("0 < {noun} < 1"),
        }
    }
}

impl Length {
    fn in_words(self) -> String {
        match self {
            Self::Any | Self::Distinct => "list".to_owned(),
            Self::Some | Self::SomeDistinct => "list, not empty,".to_owned(),
            Self::Exactly(count) => format!("list with {count}"),
            Self::SeveralDistinct => "list with at least 2".to_owned(),
            Self::TwoDistinct => "list with 2".to_owned(),
            Self::OneOrTwo => "list with 1 or 2".to_owned(),
        }
    }
}
