//! The columns of a manifest, and one row of it as text.

use crate::fault::Place;
use crate::fleet::error::{FleetError, FleetErrorKind};

/// Columns that a manifest may have, those that it must have first.
pub(super) const COLUMNS: [&str; 7] = [
    "robot",
    "recordings",
    "problem",
    "time",
    "type",
    "validation",
    "verb",
];

/// How many of [`COLUMNS`] a manifest must have.
pub(super) const REQUIRED: usize = 4;

/// The cells of one row.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Row {
    pub(super) robot: String,
    pub(super) kind: String,
    pub(super) recordings: Vec<String>,
    pub(super) validation: Vec<String>,
    pub(super) problem: String,
    pub(super) time: String,
    pub(super) verb: String,
}

impl Row {
    /// Puts a text into the cell of a column.
    pub(super) fn set(&mut self, column: &str, text: String) {
        match column {
            "robot" => self.robot = text,
            "type" => self.kind = text,
            "problem" => self.problem = text,
            "time" => self.time = text,
            "verb" => self.verb = text,
            "recordings" => self.recordings = listed(&text),
            _ => self.validation = listed(&text),
        }
    }

    /// Puts a list into the cell of a column that may have one.
    pub(super) fn set_list(&mut self, column: &str, list: Vec<String>) {
        match column {
            "recordings" => self.recordings = list,
            "validation" => self.validation = list,
            other => self.set(other, list.join(";")),
        }
    }
}

pub(super) fn listed(text: &str) -> Vec<String> {
    let parts = text.split(';').map(str::trim);
    parts
        .filter(|p| !p.is_empty())
        .map(str::to_string)
        .collect()
}

/// Rows with the place of each, as a format gives them.
pub(super) type Rows = Box<dyn Iterator<Item = Result<Placed, FleetError>> + Send>;

pub(super) struct Placed {
    pub(super) row: Row,
    pub(super) place: Place,
}

/// Refuses columns that are not known, and a manifest without one that it needs.
pub(super) fn check_columns(place: &Place, found: &[String]) -> Result<(), FleetError> {
    for name in found {
        if !COLUMNS.contains(&name.as_str()) {
            let distance = |known: &&&str| strsim::damerau_levenshtein(known, name);
            let nearest = COLUMNS.iter().min_by_key(distance);
            let nearest = nearest.filter(|known| distance(known) <= 2);
            let kind = FleetErrorKind::UnknownColumn {
                name: name.as_str().into(),
                nearest: nearest.copied(),
            };
            return Err(FleetError::new(place.clone(), kind));
        }
    }
    for name in &COLUMNS[..REQUIRED] {
        if !found.iter().any(|f| f == name) {
            let kind = FleetErrorKind::MissingColumn {
                name,
                found: found.join(", ").into(),
            };
            return Err(FleetError::new(place.clone(), kind));
        }
    }
    Ok(())
}
