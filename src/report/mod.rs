//! Reports: pure renderers of an [`Outcome`] and its predictions, for a browser and a terminal.
//!
//! The page is a function of `result.json`, `predictions.csv` and the recordings of a simulation alone, so that it can be made
//! again at any time from the results folder. It is one file that loads nothing; its own script lets readers explore.

pub mod catalogue;
pub mod compared;
pub mod escape;
pub mod html;
pub mod text;
pub mod written;

mod explore;
mod facts;
mod number;
mod plots;
mod script;
mod section;
mod series;
mod table;
mod terminal;
mod terminal_fleet;
mod terminal_parameters;
mod terminal_rollout;
mod terminal_simulator;

use std::path::Path;

use crate::outcome::error::OutcomeError;
use crate::outcome::predictions::Predictions;
use crate::outcome::{Outcome, PREDICTIONS_FILE};
use crate::report::written::Tables;

/// Renders the HTML report of the results folder at `folder` from `result.json` and, where there
/// is one, `predictions.csv`, or the recordings that it lists.
///
/// # Errors
/// `not-readable`, `not-a-result`, `not-predictions` for what cannot be read back.
pub fn render(folder: &Path) -> Result<String, OutcomeError> {
    let outcome = Outcome::read(folder)?;
    let path = folder.join(PREDICTIONS_FILE);
    let predictions = if path.exists() {
        Predictions::read(&path)?
    } else {
        Predictions::default()
    };
    let tables = Tables {
        predictions,
        written: written::read(folder, &outcome)?,
    };
    Ok(html::page(&outcome, &tables))
}

#[cfg(test)]
mod tests;
