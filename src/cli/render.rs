//! `exid report`: renders the HTML report of a result again.

use crate::cli::args::Rendering;
use crate::cli::error::CliError;
use crate::cli::output::print;
use crate::outcome::{FLEET_REPORT_FILE, Outcome, Part, REPORT_FILE};
use crate::report;
use std::fs;

pub fn run(query: &Rendering) -> Result<u8, CliError> {
    let html = report::render(&query.result)?;
    let name = match Outcome::read(&query.result)?.part {
        Part::Fleet(_) => FLEET_REPORT_FILE,
        _ => REPORT_FILE,
    };
    let path = query.result.join(name);
    // A name beside it and a rename: the old page stays until the new one is whole.
    let partial = query.result.join(format!(".{name}.partial"));
    let written = fs::write(&partial, html).and_then(|()| fs::rename(&partial, &path));
    written.map_err(|e| {
        let _ = fs::remove_file(&partial);
        CliError::WrongUse(format!(
            "{}: cannot be written: {e}; check the permissions of the folder",
            path.display()
        ))
    })?;
    if !query.quiet {
        print(&format!("{}", path.display()))?;
    }
    Ok(0)
}
