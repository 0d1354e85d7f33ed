//! `exid rollout`: the models of a result simulated forward beside the recording that was held out.

use crate::cli::args::Simulation;
use crate::cli::error::CliError;
use crate::cli::problem_of_result;
use crate::cli::progress::Progress;
use crate::cli::{interrupt, output};
use crate::outcome::input::Input;
use crate::outcome::{Outcome, RESULT_FILE};
use crate::verb::rollout::{self, RolledResult};
use crate::verb::settings::{OnMistakes, Settings};
use std::path::Path;
use std::time::Instant;

pub fn run(query: &Simulation) -> Result<u8, CliError> {
    let started = Instant::now();
    let outcome = Outcome::read(&query.result)?;
    rollout::require_robot(&outcome)?;
    output::set_threads(query.threads)?;
    let out = match &query.out {
        Some(out) => out.clone(),
        None => Path::new("results").join(&outcome.name).join("rollout"),
    };
    // Before the process moves to where the inputs are.
    let out = problem_of_result::absolute(&out)?;
    let result = match query.result.is_dir() {
        true => query.result.join(RESULT_FILE),
        false => query.result.clone(),
    };
    let file = Input::of(&result).ok();
    let mut notes = Vec::new();
    let mut problem = problem_of_result::prepare(&outcome, &query.set, &mut notes)?;
    // What has been read once is not too long.
    output::bound(&mut problem, Some(u64::MAX));
    let target = output::writable(out)?;
    let progress = Progress::new(query.printing);
    let settings = Settings {
        seed: query.seed,
        on_mistakes: OnMistakes::GoOn,
        interrupt: Some(interrupt::flag()),
        progress: &|step| progress.say(step),
        command: output::command(),
        started,
    };
    let result = RolledResult {
        outcome: &outcome,
        problem: &problem,
        source: query.result.display().to_string(),
        file,
        set: &query.set,
        notes,
    };
    let completed = rollout::run(result, &settings)?;
    progress.done();
    output::finish(query.printing, &target, completed)?;
    Ok(0)
}
