//! The problem of a result, to be run again with its inputs as they were.

use crate::cli::error::CliError;
use crate::outcome::Outcome;
use crate::problem_file::ProblemFile;
use crate::verb::kept::KeptProblem;
use std::path::{Path, PathBuf};

/// The problem of a result, its inputs as they were; the process moves to the folder from which they are found.
pub(super) fn prepare(
    earlier: &Outcome,
    overrides: &[String],
    notes: &mut Vec<String>,
) -> Result<ProblemFile, CliError> {
    let mut kept = KeptProblem::of(earlier)?;
    if let Some(folder) = kept.elsewhere.take() {
        std::env::set_current_dir(&folder).map_err(|e| {
            CliError::WrongUse(format!(
                "{}: {e}; run exid where its inputs are",
                folder.display()
            ))
        })?;
    }
    notes.append(&mut kept.notes);
    Ok(kept.read(overrides)?)
}

pub(super) fn absolute(path: &Path) -> Result<PathBuf, CliError> {
    std::path::absolute(path)
        .map_err(|e| CliError::WrongUse(format!("{}: {e}; give another folder", path.display())))
}
