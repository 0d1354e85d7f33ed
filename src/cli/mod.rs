//! The command line: one file per verb, from flags to task to results folder.

mod args;
mod colour;
mod columns;
mod compare;
mod effects;
mod error;
mod export;
mod fleet;
mod init;
mod interrupt;
mod manual;
mod messages;
mod output;
mod problem_of_result;
mod progress;
mod render;
mod repeat;
mod rollout;
mod runs;
mod schema;
mod trials;

use crate::cli::args::{Arguments, Verb};
use crate::cli::error::CliError;
use crate::cli::messages::complain;
use crate::problem::defect::guarded;
use crate::verb::Verb as Task;
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
        Ok(Err(error)) => failed(&error),
        Err(defect) => {
            complain(&format!("error: {defect}"));
            ExitCode::from(CliError::DEFECT)
        }
    }
}

fn dispatch(verb: &Verb) -> Result<u8, CliError> {
    match verb {
        Verb::Design(options) => runs::run(Task::Design, options, &output::open(options)?),
        Verb::Fit(options) => runs::run(Task::Fit, options, &output::open(options)?),
        Verb::Check(look) if look.columns => columns::run(look),
        Verb::Check(look) => runs::run(Task::Check, &look.run, &output::open(&look.run)?),
        Verb::Diagnose(options) => runs::run(Task::Diagnose, options, &output::open(options)?),
        Verb::Simulate(options) => runs::run(Task::Simulate, options, &output::open(options)?),
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

fn failed(error: &CliError) -> ExitCode {
    // Whoever interrupts a run is answered at once.
    if !error.is_interrupt() {
        complain(&format!("error: {error}"));
    }
    ExitCode::from(error.exit_code())
}

/// Help and version go to standard output and are no error; the rest is a wrong command line.
fn answer_without_run(error: &clap::Error) -> ExitCode {
    if error.use_stderr() {
        // There is nowhere else to say it.
        let _ = error.print();
        return ExitCode::from(CliError::WRONG_USE);
    }
    let printed = error.print().and_then(|()| std::io::stdout().flush());
    match output::unless_gone(printed) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => failed(&fault),
    }
}
