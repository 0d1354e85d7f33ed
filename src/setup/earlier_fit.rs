//! The result of an earlier fit that a problem file names.

use crate::outcome::estimate::Estimate;
use crate::outcome::fit::Fit;
use crate::outcome::{Outcome, Part};
use crate::problem_file::{FilePath, Located};
use crate::setup::error::{Mismatch, SetupError};

/// An earlier fit.
pub(super) struct EarlierFit {
    /// Its parameters.
    pub estimate: Estimate,
    /// What is of a fit alone.
    pub fit: Fit,
}

impl EarlierFit {
    /// # Errors
    /// A result that cannot be read, or is none of a fit.
    pub(super) fn read(path: &Located<FilePath>) -> Result<Self, SetupError> {
        let outcome =
            Outcome::read(&path.resolved).map_err(|e| SetupError::Earlier(Box::new(e)))?;
        let Part::Fit(fit) = outcome.part else {
            return Err(SetupError::mismatch(&path.place, Mismatch::NotAFit));
        };
        Ok(Self {
            estimate: outcome.estimate,
            fit,
        })
    }
}
