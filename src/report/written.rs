//! Recordings that a simulation wrote into its results folder, read back for the page.

use std::fs::File;
use std::io::Read;
use std::path::{Component, Path};

use csv::ReaderBuilder;
use flate2::read::GzDecoder;

use crate::outcome::error::{Action, OutcomeError, OutcomeErrorKind};
use crate::outcome::predictions::Predictions;
use crate::outcome::{Outcome, Part};

/// Recordings of a simulation on a page at most.
const MOST: usize = 4;

/// What lies beside the result and is on the page.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tables {
    /// Recorded and predicted signals.
    pub predictions: Predictions,
    /// Other tables of the folder.
    pub written: Vec<Written>,
}

/// A table with named columns.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Written {
    /// Name of the file.
    pub name: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// `[column][row]`; not a number where a field is empty.
    pub columns: Vec<Vec<f64>>,
}

impl Written {
    /// A column by its name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let at = self.header.iter().position(|own| own == name)?;
        Some(&self.columns[at])
    }

    fn read(folder: &Path, name: &str) -> Result<Self, OutcomeError> {
        let path = folder.join(name);
        let unreadable =
            |error: &std::io::Error| OutcomeError::io(&path, Action::ReadPredictions, error);
        let file = File::open(&path).map_err(|error| unreadable(&error))?;
        let source: Box<dyn Read> = match name.ends_with(".gz") {
            true => Box::new(GzDecoder::new(file)),
            false => Box::new(file),
        };
        let broken = |error: csv::Error| {
            OutcomeError::new(&path, OutcomeErrorKind::NotPredictions(error.to_string()))
        };
        let mut reader = ReaderBuilder::new().from_reader(source);
        let header: Vec<String> = reader
            .headers()
            .map_err(broken)?
            .iter()
            .map(str::to_string)
            .collect();
        let mut columns = vec![Vec::new(); header.len()];
        for row in reader.records() {
            for (column, field) in columns.iter_mut().zip(row.map_err(broken)?.iter()) {
                column.push(field.parse().unwrap_or(f64::NAN));
            }
        }
        Ok(Self {
            name: name.to_string(),
            header,
            columns,
        })
    }
}

/// Whether a name leads to a file below the folder: a page shows nothing from elsewhere.
fn is_inside(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    parts.all(|part| matches!(part, Component::Normal(_)))
}

/// The recordings of a simulation, trajectories left out; none of another verb, and of files that were moved away.
///
/// # Errors
/// `not-readable`, `not-predictions` for a file that is there and is no table.
pub(super) fn read(folder: &Path, outcome: &Outcome) -> Result<Vec<Written>, OutcomeError> {
    let Part::Simulate(simulation) = &outcome.part else {
        return Ok(Vec::new());
    };
    let recordings = simulation.files.iter();
    recordings
        .filter(|name| !name.ends_with(".trajectory.csv"))
        .filter(|name| is_inside(name) && folder.join(name).exists())
        .take(MOST)
        .map(|name| Written::read(folder, name))
        .collect()
}
