//! `exid trials`: how often the diagnosis is right on random robots.

use crate::cli::args::Campaign;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{interrupt, output};
use crate::outcome::estimate::Estimate;
use crate::outcome::run::{Run as Record, VERSION};
use crate::outcome::trials::Trial;
use crate::outcome::{Outcome, Part};
use crate::problem::solution::Control;
use crate::trials::conceal;
use crate::trials::plan::Scope;
use crate::trials::robot::KINDS;
use crate::trials::run as trial;
use crate::trials::tally::tally;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The results folder where none is given.
const FOLDER: &str = "results/trials/trials";

/// Trials between two writings of the result.
const BATCH: usize = 16;

pub fn run(campaign: &Campaign) -> Result<u8, CliError> {
    let started = Instant::now();
    let scope = scope(campaign)?;
    output::set_threads(campaign.threads)?;
    let folder = campaign.out.clone();
    let target = output::writable(folder.unwrap_or_else(|| PathBuf::from(FOLDER)))?;
    let control = Control {
        interrupt: Some(interrupt::flag()),
        ..Control::default()
    };
    let progress = Progress::new(campaign.printing);
    let mut done = earlier(&target, &scope, campaign.count);
    let is_open = |n: &u64| done.iter().all(|t| t.seed != *n);
    let open: Vec<u64> = (0..campaign.count).filter(is_open).collect();
    let mut made = 0;
    for batch in open.chunks(BATCH) {
        progress.say(format!("{} of {} trials", done.len(), campaign.count));
        let trials = batch.par_iter().map(|&n| trial::run(&scope, n, &control));
        let trials: Vec<Trial> = trials.collect();
        if control.is_interrupted() {
            break;
        }
        made += trials.len();
        done.extend(trials);
        done.sort_by_key(|t| t.seed);
        let outcome = outcome(&scope, done.clone(), (started, made));
        output::write(&target, &outcome, |_| Ok(()))?;
    }
    progress.done();
    let outcome = outcome(&scope, done, (started, made));
    output::finish(campaign.printing, &target, &outcome, |_| Ok(()))?;
    Ok(output::exit_code(control.is_interrupted(), true))
}

fn scope(campaign: &Campaign) -> Result<Scope, CliError> {
    let effects: Vec<&'static str> = conceal::effects().map(|e| e.id).collect();
    let mut scope = Scope::all(campaign.seed);
    if !campaign.effects.is_empty() {
        scope.effects = chosen(("--effects", &campaign.effects), &effects)?;
    }
    if !campaign.robots.is_empty() {
        scope.robots = chosen(("--robots", &campaign.robots), &KINDS)?;
    }
    Ok(scope)
}

fn chosen(
    (flag, wanted): (&str, &[String]),
    known: &[&'static str],
) -> Result<Vec<&'static str>, CliError> {
    let find = |name: &String| {
        let found = known.iter().find(|k| *k == name).copied();
        found.ok_or_else(|| {
            let all = known.join(", ");
            CliError::WrongUse(format!("{flag}: `{name}` is not one of {all}"))
        })
    };
    wanted.iter().map(find).collect()
}

/// What trials are drawn from, as the result states it.
fn drawn_from(scope: &Scope) -> serde_json::Value {
    serde_json::json!({ "effects": scope.effects, "robots": scope.robots })
}

/// Trials of an earlier run that are the same as those asked for.
fn earlier(target: &Path, scope: &Scope, count: u64) -> Vec<Trial> {
    let Ok(outcome) = Outcome::read(target) else {
        return Vec::new();
    };
    let same = outcome.run.seed == scope.seed
        && outcome.run.version == VERSION
        && outcome.run.problem == drawn_from(scope);
    match outcome.part {
        Part::Trials(trials) if same => {
            let asked = trials.trials.into_iter().filter(|t| t.seed < count);
            asked.collect()
        }
        _ => Vec::new(),
    }
}

fn outcome(scope: &Scope, trials: Vec<Trial>, (started, made): (Instant, usize)) -> Outcome {
    let wall_s = started.elapsed().as_secs_f64();
    let mut tallied = tally(trials);
    tallied.rates.core_seconds = processor_seconds()
        .filter(|_| made > 0)
        .map(|spent| spent / made as f64);
    Outcome {
        name: "trials".to_string(),
        run: Record {
            version: VERSION.to_string(),
            seed: scope.seed,
            problem: drawn_from(scope),
            inputs: Vec::new(),
            wall_s,
        },
        estimate: Estimate::default(),
        part: Part::Trials(tallied),
    }
}

/// Processor time that this program has taken, where the system tells it.
#[cfg(unix)]
fn processor_seconds() -> Option<f64> {
    use rustix::time::{ClockId, clock_gettime};
    let spent = clock_gettime(ClockId::ProcessCPUTime);
    Some(spent.tv_sec as f64 + 1e-9 * spent.tv_nsec as f64)
}

#[cfg(not(unix))]
fn processor_seconds() -> Option<f64> {
    None
}
