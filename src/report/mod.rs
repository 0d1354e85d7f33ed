//! Reports: pure renderers of an [`Outcome`] and its predictions, for a browser and a terminal.
//!
//! The page is a function of `result.json` and `predictions.csv` alone, so that it can be made
//! again at any time from the results folder. It is one file that loads nothing.

pub mod catalogue;
pub mod compared;
pub mod html;
pub mod series;
pub mod text;

mod facts;
mod number;
mod plots;
mod section;
mod table;
mod terminal;
mod terminal_fleet;
mod terminal_parameters;
mod terminal_rollout;

use std::path::Path;

use crate::outcome::error::OutcomeError;
use crate::outcome::predictions::Predictions;
use crate::outcome::{Outcome, PREDICTIONS_FILE};
use crate::report::series::Series;

/// Renders the HTML report of the results folder at `folder` from `result.json` and, where there
/// is one, `predictions.csv`.
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
    Ok(html::page(&outcome, &Series::of(&predictions)))
}

#[cfg(test)]
mod tests;
