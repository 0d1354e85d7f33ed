//! Writes the results folder of a run: result, the files beside it, report.

use crate::outcome::folder::ResultFolder;
use crate::outcome::{Outcome, REPORT_FILE, RESULT_FILE};
use crate::report;
use crate::verb::error::VerbError;
use std::io::Write;
use std::path::Path;

/// Writes result and report beside what `fill` writes and replaces the folder; gives the result as JSON.
///
/// # Errors
/// Those of the folder and of `fill`.
pub fn write(
    target: &Path,
    outcome: &Outcome,
    fill: impl FnOnce(&ResultFolder) -> Result<(), VerbError>,
) -> Result<String, VerbError> {
    let folder = ResultFolder::prepare(target)?;
    let json = outcome.to_json()?;
    folder.write(RESULT_FILE, |out| out.write_all(json.as_bytes()))?;
    fill(&folder)?;
    let html = report::render(folder.path())?;
    folder.write(REPORT_FILE, |out| out.write_all(html.as_bytes()))?;
    folder.commit()?;
    Ok(json)
}
