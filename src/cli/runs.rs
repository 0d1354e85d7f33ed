//! `exid check`, `design`, `diagnose`, `fit`, `simulate`: a problem is run, its result written and printed.

use crate::cli::args::Run;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{interrupt, output};
use crate::problem_file::ProblemFile;
use crate::verb::Verb;
use crate::verb::settings::{OnMistakes, Settings};
use std::time::Instant;

pub fn run(verb: Verb, run: &Run, problem: &ProblemFile) -> Result<u8, CliError> {
    let started = Instant::now();
    let target = output::target(run, problem, verb.name())?;
    let progress = Progress::new(run.printing);
    let settings = Settings {
        seed: run.seed,
        on_mistakes: match run.force {
            true => OnMistakes::GoOn,
            false => OnMistakes::Refuse,
        },
        interrupt: Some(interrupt::flag()),
        progress: &|step| progress.say(step),
        command: output::command(),
        started,
    };
    let completed = verb.run(problem, &settings)?;
    progress.done();
    let ending = completed.ending.clone();
    // A design without a solution says so in its summary.
    let solver = match verb {
        Verb::Design => None,
        _ => completed.outcome.estimate.solver.clone(),
    };
    output::finish(run.printing, &target, completed)?;
    Ok(output::exit_code(&ending, solver.as_ref(), &target))
}
