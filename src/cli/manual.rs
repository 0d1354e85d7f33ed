//! `exid completions` and `exid man`: what shells and `man` know of the command line, made from its definition.

use crate::cli::args::{Arguments, Pages, Shells};
use crate::cli::error::CliError;
use crate::cli::output::print;
use clap::CommandFactory;
use std::fs;

/// Prints the completions of a shell.
pub fn completions(query: &Shells) -> Result<u8, CliError> {
    let mut text = Vec::new();
    clap_complete::generate(query.shell, &mut Arguments::command(), "exid", &mut text);
    print(&String::from_utf8_lossy(&text))?;
    Ok(0)
}

/// Writes the pages of `man`, one of the program and one for each verb.
pub fn pages(query: &Pages) -> Result<u8, CliError> {
    let folder = &query.folder;
    fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Arguments::command(), folder))
        .map_err(|e| {
            CliError::WrongUse(format!(
                "{}: the pages cannot be written: {e}; name a folder that can be written",
                folder.display()
            ))
        })?;
    print(&format!("man -l {}", folder.join("exid.1").display()))?;
    Ok(0)
}
