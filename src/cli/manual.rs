//! `exid completions` and `exid man`: what shells and `man` know of the command line, made from its definition.

use crate::cli::args::{Arguments, Pages, Shells};
use crate::cli::error::CliError;
use crate::cli::output::print;
use clap::{Command, CommandFactory};
use clap_mangen::Man;
use std::path::Path;
use std::{fs, io};

/// Prints the completions of a shell.
pub fn completions(query: &Shells) -> Result<u8, CliError> {
    let mut text = Vec::new();
    clap_complete::generate(query.shell, &mut Arguments::command(), "exid", &mut text);
    print(&String::from_utf8_lossy(&text))?;
    Ok(0)
}

/// Writes the pages of a command and of its verbs.
fn write(command: Command, folder: &Path) -> io::Result<()> {
    let mut command = command.disable_help_subcommand(true);
    command.build();
    for verb in command.get_subcommands() {
        page(Man::new(verb.clone()), folder)?;
    }
    page(Man::new(command), folder)
}

/// What follows the help of a command are examples.
fn page(man: Man, folder: &Path) -> io::Result<()> {
    let mut text = Vec::new();
    man.render(&mut text)?;
    let mut text = String::from_utf8_lossy(&text).into_owned();
    for heading in ["Example", "Examples"] {
        text = text.replace(&format!(".SH EXTRA\n{heading}:\n"), ".SH EXAMPLES\n");
    }
    fs::write(folder.join(man.get_filename()), text)
}

/// Writes the pages of `man`, one of the program and one for each verb.
pub fn pages(query: &Pages) -> Result<u8, CliError> {
    let folder = &query.folder;
    fs::create_dir_all(folder)
        .and_then(|()| write(Arguments::command(), folder))
        .map_err(|e| {
            CliError::WrongUse(format!(
                "{}: the pages cannot be written: {e}; name a folder that can be written",
                folder.display()
            ))
        })?;
    print(&format!("man -l {}", folder.join("exid.1").display()))?;
    Ok(0)
}
