//! The command line: one file per verb, from flags to task to results folder.

mod args;
mod check;
mod colour;
mod columns;
mod compare;
mod design;
mod diagnose;
mod effects;
mod error;
mod export;
mod fit;
mod fleet;
mod init;
mod inputs;
mod interrupt;
mod manual;
mod motors;
mod output;
mod predictions;
mod progress;
mod render;
mod repeat;
mod rollout;
mod schema;
mod simulate;
mod trials;

use crate::cli::args::{Arguments, Verb};
use crate::cli::error::CliError;
use crate::problem::defect::guarded;
use clap::Parser;
use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

/// Parses the command line, runs the verb, prints the error; gives the exit code.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let parsed = match Arguments::try_parse_from(arguments) {
        Ok(parsed) => parsed,
        Err(error) => return answer_without_run(&error),
    };
    std::panic::set_hook(Box::new(|_| {}));
    match guarded(|| dispatch(&parsed.verb)) {
        Ok(Ok(code)) => ExitCode::from(code),
        Ok(Err(error)) => {
            complain(&format!("error: {error}"));
            ExitCode::from(error.exit_code())
        }
        Err(defect) => {
            complain(&format!("error: {defect}"));
            ExitCode::from(CliError::DEFECT)
        }
    }
}

fn dispatch(verb: &Verb) -> Result<u8, CliError> {
    match verb {
        Verb::Design(run) => design::run(run, &output::open(run)?),
        Verb::Fit(run) => fit::run(run, &output::open(run)?),
        Verb::Check(look) if look.columns => columns::run(look),
        Verb::Check(look) => check::run(&look.run, &output::open(&look.run)?),
        Verb::Diagnose(run) => diagnose::run(run, &output::open(run)?),
        Verb::Simulate(run) => simulate::run(run, &output::open(run)?),
        Verb::Trials(campaign) => trials::run(campaign),
        Verb::Fleet(query) => fleet::run(query),
        Verb::Effects(query) => effects::run(query),
        Verb::Export(query) => export::run(query),
        Verb::Rollout(query) => rollout::run(query),
        Verb::Report(query) => render::run(query),
        Verb::Repeat(query) => repeat::run(query),
        Verb::Compare(query) => compare::run(query),
        Verb::Init(query) => init::run(query),
        Verb::Schema(query) => schema::run(query),
        Verb::Completions(query) => manual::completions(query),
        Verb::Man(query) => manual::pages(query),
    }
}

/// Help and version go to standard output and are no error; the rest is a wrong command line.
fn answer_without_run(error: &clap::Error) -> ExitCode {
    // A closed pipe is no reason to fail.
    let _ = error.print();
    if error.use_stderr() {
        ExitCode::from(CliError::WRONG_USE)
    } else {
        ExitCode::SUCCESS
    }
}

fn complain(text: &str) {
    let mut stream = std::io::stderr();
    let _ = writeln!(stream, "{}", colour::for_stream(text, &stream));
}
