//! `exid compare`: two results side by side, and what differs significantly.

use crate::cli::args::Pair;
use crate::cli::error::CliError;
use crate::cli::output::print;
use crate::outcome::Outcome;
use crate::outcome::compare::compare;
use crate::report::compared::{self, Extent};

pub fn run(query: &Pair) -> Result<u8, CliError> {
    let first = Outcome::read(&query.first)?;
    let second = Outcome::read(&query.second)?;
    let found = compare(&first, &second);
    if query.json {
        print(&format!("{:#}", serde_json::json!(found)))?;
    } else {
        let names = [&query.first, &query.second].map(|path| path.display().to_string());
        let extent = match query.all {
            true => Extent::Everything,
            false => Extent::Brief,
        };
        print(&compared::text(&found, [&names[0], &names[1]], extent))?;
    }
    Ok(0)
}
