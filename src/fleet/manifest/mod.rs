//! The manifest: one row for each item, read one after the other so that its length does not matter.
//!
//! | column | what it holds |
//! |---|---|
//! | `robot` | name of the robot |
//! | `type` | robots of one type share means and spreads; default: the problem |
//! | `recordings` | file, or several with `;` between them (in TOML and Parquet also a list) |
//! | `validation` | recordings that are not fitted, in the same form; default: none |
//! | `problem` | the problem file, whose recordings these take the place of |
//! | `time` | a number, or a date or instant of RFC 3339 |
//! | `verb` | `fit` or `diagnose`; default: `fit` |
//!
//! Paths start from the folder of the manifest.

mod by_csv;
mod by_parquet;
mod by_toml;
mod row;

use crate::fault::Place;
use crate::fleet::error::{FleetError, FleetErrorKind};
use crate::fleet::manifest::row::{Placed, Row, Rows, check_columns};
use crate::fleet::time;
use std::path::{Path, PathBuf};

/// What is done with an item.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verb {
    /// Its declared model is fitted.
    Fit,
    /// It is diagnosed.
    Diagnose,
}

impl Verb {
    /// The word in the manifest.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Fit => "fit",
            Self::Diagnose => "diagnose",
        }
    }
}

/// One item of a manifest.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its position in the manifest, from 0.
    pub position: u64,
    /// Name of the robot.
    pub robot: String,
    /// Type of the robot, whose robots are compared.
    pub kind: String,
    /// Absolute, as are the others.
    pub recordings: Vec<PathBuf>,
    /// Recordings to judge the fit by; none where the manifest names none.
    pub validation: Vec<PathBuf>,
    /// The declared model and the settings of the run.
    pub problem: PathBuf,
    /// A number as it stands, or seconds since 1970.
    pub time: f64,
    /// What is done with it.
    pub verb: Verb,
}

/// The items of a manifest in their order; the first fault ends them.
pub struct Manifest {
    rows: Rows,
    folder: PathBuf,
    next: u64,
}

impl Manifest {
    /// Opens a manifest by the ending of its name.
    ///
    /// # Errors
    /// The file cannot be read, is of another format, or lacks a column.
    pub fn open(path: &Path) -> Result<Self, FleetError> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        let rows = match extension.to_lowercase().as_str() {
            "csv" => by_csv::rows(path)?,
            "parquet" => by_parquet::rows(path)?,
            "toml" => by_toml::rows(path)?,
            _ => {
                let kind = FleetErrorKind::UnknownFormat;
                return Err(FleetError::new(Place::file(path), kind));
            }
        };
        let absolute = std::path::absolute(path).map_err(|e| FleetError::not_read(path, &e))?;
        Ok(Self {
            rows,
            folder: absolute.parent().unwrap_or(Path::new("/")).to_path_buf(),
            next: 0,
        })
    }

    /// The folder that paths start from.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn entry(&self, Placed { row, place }: Placed) -> Result<Entry, FleetError> {
        let bad = |column: &str, found: &str, expected| {
            let found = found.to_string();
            let kind = FleetErrorKind::BadCell {
                found: found.into(),
                expected,
            };
            Err(FleetError::new(place.clone().key(column), kind))
        };
        if row.robot.is_empty() {
            return bad("robot", "", "the name of a robot");
        }
        if row.recordings.is_empty() {
            return bad("recordings", "", "a file");
        }
        if row.problem.is_empty() {
            return bad("problem", "", "a problem file");
        }
        let Some(time) = time::parse(&row.time) else {
            let expected = "a number, or a date such as 2026-01-31 or 2026-01-31T22:00:00Z";
            return bad("time", &row.time, expected);
        };
        let verb = match row.verb.as_str() {
            "" | "fit" => Verb::Fit,
            "diagnose" => Verb::Diagnose,
            other => return bad("verb", other, "fit or diagnose"),
        };
        let absolute = |files: &[String]| files.iter().map(|f| self.folder.join(f)).collect();
        Ok(Entry {
            position: self.next,
            recordings: absolute(&row.recordings),
            validation: absolute(&row.validation),
            problem: self.folder.join(&row.problem),
            kind: match row.kind.is_empty() {
                true => row.problem,
                false => row.kind,
            },
            robot: row.robot,
            time,
            verb,
        })
    }
}

impl Iterator for Manifest {
    type Item = Result<Entry, FleetError>;

    fn next(&mut self) -> Option<Self::Item> {
        let entry = self.rows.next()?.and_then(|row| self.entry(row));
        self.next += 1;
        Some(entry)
    }
}

#[cfg(test)]
mod tests;
