//! What a run found as files: the results folder with `result.json` and what stands beside it.

use crate::outcome::WINDOWS_FILE;
use crate::outcome::folder::ResultFolder;
use crate::outcome::predictions::Predictions;
use crate::rollout;
use crate::verb::completed::{Completed, Found};
use crate::verb::error::VerbError;
use crate::verb::{design, diagnose, fit, folder, motors, simulate};
use std::io::Write;
use std::path::Path;

impl Completed {
    /// Writes the results folder and lets go of what was found; gives the result as JSON.
    ///
    /// # Errors
    /// The folder cannot be written; an earlier result then stands as it was.
    pub fn write(self, target: &Path) -> Result<String, VerbError> {
        let Self { outcome, found, .. } = self;
        // The recordings go before the report reads what was written of them.
        folder::write(target, &outcome, move |folder| found.write(folder))
    }

    /// Writes the results folder, as [`Self::write`] does, and keeps what was found.
    ///
    /// # Errors
    /// As there.
    pub fn save(&self, target: &Path) -> Result<String, VerbError> {
        folder::write(target, &self.outcome, |folder| self.found.write(folder))
    }
}

impl Found {
    /// What is recorded and what the models predict, of verbs that compare the two.
    pub fn predictions(&self) -> Option<Predictions> {
        match self {
            Self::Diagnosis(run) => Some(diagnose::predicted(run, |p| p.table())),
            Self::Fit(run) => Some(fit::predicted(run, |p| p.table())),
            Self::Motors(run) => Some(motors::table(run)),
            Self::Findings | Self::Design(_) | Self::Rollout(_) | Self::Simulation(_) => None,
        }
    }

    fn write(&self, folder: &ResultFolder) -> Result<(), VerbError> {
        match self {
            Self::Findings => Ok(()),
            Self::Design(designed) => design::write(folder, designed),
            Self::Diagnosis(run) => diagnose::write(folder, run),
            Self::Fit(run) => fit::write(folder, run),
            Self::Motors(run) => motors::write(folder, run),
            Self::Rollout(examples) => {
                let table = rollout::table(examples);
                folder.write(WINDOWS_FILE, |out| out.write_all(table.as_bytes()))?;
                Ok(())
            }
            Self::Simulation(simulated) => simulate::write(folder, simulated),
        }
    }
}
