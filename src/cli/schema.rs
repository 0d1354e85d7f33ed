//! `exid schema`: what a problem file may hold, for editors and readers.

use crate::chain::effect;
use crate::cli::args::Schema;
use crate::cli::error::CliError;
use crate::cli::output::print;
use crate::problem_file::{reference, schema};

pub fn run(query: &Schema) -> Result<u8, CliError> {
    let text = match query.markdown {
        true => reference::markdown(),
        false => format!("{:#}", schema::schema(&effect::ids())),
    };
    print(&text)?;
    Ok(0)
}
