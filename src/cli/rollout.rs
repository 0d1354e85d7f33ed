//! `exid rollout`: the models of a result simulated forward beside the recording that was held out.

use crate::cli::args::Simulation;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{inputs, interrupt, output, repeat};
use crate::outcome::estimate::Estimate;
use crate::outcome::input::Input;
use crate::outcome::run::{Run, VERSION};
use crate::outcome::{Outcome, Part, RESULT_FILE, WINDOWS_FILE};
use crate::problem::solution::Control;
use crate::rollout::error::RolloutError;
use crate::rollout::{self, Task};
use std::io::Write;
use std::path::Path;
use std::time::Instant;

pub fn run(query: &Simulation) -> Result<u8, CliError> {
    let started = Instant::now();
    let outcome = Outcome::read(&query.result)?;
    if !matches!(outcome.part, Part::Fit(_) | Part::Diagnose(_)) {
        let verb = outcome.part.verb();
        return Err(RolloutError::NoRobot { verb }.into());
    }
    output::set_threads(query.threads)?;
    let out = match &query.out {
        Some(out) => out.clone(),
        None => Path::new("results").join(&outcome.name).join("rollout"),
    };
    // Before the process moves to where the inputs are.
    let out = repeat::absolute(&out)?;
    let result = match query.result.is_dir() {
        true => query.result.join(RESULT_FILE),
        false => query.result.clone(),
    };
    let source = Input::of(&result).ok();
    let mut notes = Vec::new();
    let mut problem = repeat::prepare(&outcome, &query.set, &mut notes)?;
    // What has been read once is not too long.
    output::bound(&mut problem, Some(u64::MAX));
    let target = output::writable(out)?;
    let control = Control {
        interrupt: Some(interrupt::flag()),
        ..Control::default()
    };
    let progress = Progress::new(query.printing);
    let task = Task {
        problem: &problem,
        outcome: &outcome,
        source: &query.result.display().to_string(),
        set: &query.set,
        seed: query.seed,
    };
    let mut rolled = rollout::run(task, &control, &|step| progress.say(step))?;
    progress.done();
    notes.append(&mut rolled.rollout.notes);
    rolled.rollout.notes = notes;
    let files = inputs::of_recordings(&problem);
    let files = std::iter::once(&problem.path).chain(&files);
    let inputs = files.filter_map(|file| Input::of(file).ok());
    let outcome = Outcome {
        name: outcome.name,
        run: Run {
            version: VERSION.to_string(),
            seed: query.seed,
            problem: problem.json.clone(),
            inputs: inputs.chain(source).collect(),
            wall_s: started.elapsed().as_secs_f64(),
            provenance: output::provenance(),
        },
        mistakes: Vec::new(),
        estimate: Estimate::default(),
        part: Part::Rollout(Box::new(rolled.rollout)),
    };
    output::finish(query.printing, &target, &outcome, |folder| {
        folder.write(WINDOWS_FILE, |out| {
            out.write_all(rollout::table(&rolled.examples).as_bytes())
        })?;
        Ok(())
    })?;
    Ok(0)
}
