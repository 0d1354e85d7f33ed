//! `exid trials`: how often the diagnosis is right on random robots.

use crate::chain::effect::EFFECTS;
use crate::cli::args::Campaign;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{interrupt, output};
use crate::fleet::key;
use crate::fleet::store::Store;
use crate::outcome::estimate::Estimate;
use crate::outcome::provenance::VERSION;
use crate::outcome::run::Run as Record;
use crate::outcome::trials::Trial;
use crate::outcome::{Outcome, Part};
use crate::problem::solution::Control;
use crate::setup::laws;
use crate::trials::concealed_effect;
use crate::trials::motion::{Motion, Noise};
use crate::trials::plan::Scope;
use crate::trials::robot::KINDS;
use crate::trials::run as trial;
use crate::trials::tally::tally;
use crate::verb::{folder, remaining};
use rayon::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The results folder where none is given.
const FOLDER: &str = "results/trials/trials";

/// The same of single trials, so that they do not take the place of a campaign.
const FOLDER_OF_SINGLE: &str = "results/trials/only";

/// Trials between two writings of the result.
const BATCH: usize = 16;

pub fn run(campaign: &Campaign) -> Result<u8, CliError> {
    let started = Instant::now();
    let scope = scope(campaign)?;
    output::set_threads(campaign.threads)?;
    let folder = campaign.out.clone().unwrap_or_else(|| {
        PathBuf::from(match campaign.only.is_empty() {
            true => FOLDER,
            false => FOLDER_OF_SINGLE,
        })
    });
    let target = match campaign.shard {
        Some(_) => folder,
        None => output::writable(folder)?,
    };
    let control = Control {
        interrupt: Some(interrupt::flag()),
        ..Control::default()
    };
    let progress = Progress::new(campaign.printing);
    let items = Items::open(campaign, &scope)?;
    let earlier = match &items {
        Some(items) => items.done(campaign),
        None => earlier(&target, &scope),
    };
    let Work { mut done, open } = work(campaign, earlier);
    let place = Place::new(campaign.keep.as_deref(), &open)?;
    let all = done.len() + open.len();
    let mut made = 0;
    for batch in open.chunks(BATCH) {
        let left = remaining::left(started.elapsed(), made, made + all - done.len());
        progress.say(format!("{} of {all} trials{left}", done.len()));
        let trials = batch.par_iter().map(|&n| place.run(&scope, n, &control));
        let trials: Vec<Trial> = trials.collect::<Result<_, CliError>>()?;
        if control.is_interrupted() {
            break;
        }
        if let Some(items) = &items {
            trials.iter().try_for_each(|trial| items.keep(trial))?;
        }
        made += trials.len();
        done.extend(trials);
        if campaign.shard.is_some() {
            continue;
        }
        done.sort_by_key(|t| t.seed);
        let outcome = outcome(&scope, done.clone(), started, made);
        folder::write(&target, &outcome, |_| Ok(()))?;
    }
    progress.done();
    if campaign.shard.is_some() && !control.is_interrupted() {
        return Ok(0);
    }
    let outcome = outcome(&scope, done, started, made);
    output::finish_alone(campaign.printing, &target, &outcome)?;
    Ok(match control.is_interrupted() {
        true => CliError::INTERRUPTED,
        false => 0,
    })
}

/// Trials that an earlier run has made, and the numbers of those to make.
struct Work {
    done: Vec<Trial>,
    open: Vec<u64>,
}

/// Trials that are asked for one by one are made again; those of a campaign are made once.
fn work(campaign: &Campaign, earlier: Vec<Trial>) -> Work {
    let mut open: Vec<u64> = match campaign.only.is_empty() {
        true => (0..campaign.count).collect(),
        false => campaign.only.clone(),
    };
    open.retain(|number| campaign.shard.is_none_or(|shard| shard.holds(*number)));
    open.sort_unstable();
    open.dedup();
    let mut done = earlier;
    match campaign.only.is_empty() {
        true => {
            done.retain(|trial| trial.seed < campaign.count);
            open.retain(|number| done.iter().all(|trial| trial.seed != *number));
        }
        false => done.retain(|trial| !open.contains(&trial.seed)),
    }
    Work { done, open }
}

/// Trials of a campaign that several machines run, each kept under the hash of all that it depends on.
struct Items {
    store: Store<Trial>,
    drawn: Vec<String>,
}

impl Items {
    fn open(campaign: &Campaign, scope: &Scope) -> Result<Option<Self>, CliError> {
        let Some(folder) = &campaign.items else {
            return Ok(None);
        };
        // Laws by what they say: their files may change.
        let own = scope.catalogue.effects().iter().skip(EFFECTS.len());
        let own = own.map(|effect| format!("{effect:?}"));
        let drawn = ["exid trial 1".to_string(), scope.seed.to_string()];
        let drawn = drawn.into_iter().chain([drawn_from(scope).to_string()]);
        Ok(Some(Self {
            store: Store::open(folder)?,
            drawn: drawn.chain(own).collect(),
        }))
    }

    fn key(&self, number: u64) -> String {
        let mut parts = self.drawn.clone();
        parts.push(number.to_string());
        key::of_parts(&parts)
    }

    /// What is done of the campaign, or of the part of it.
    fn done(&self, campaign: &Campaign) -> Vec<Trial> {
        let is_ours = |number: &u64| campaign.shard.is_none_or(|shard| shard.holds(*number));
        let ours = (0..campaign.count).filter(is_ours);
        ours.filter_map(|number| self.store.read(&self.key(number)))
            .collect()
    }

    fn keep(&self, trial: &Trial) -> Result<(), CliError> {
        Ok(self.store.keep(&self.key(trial.seed), trial)?)
    }
}

/// Where the files of trials go.
struct Place<'a> {
    keep: Option<&'a Path>,
}

impl<'a> Place<'a> {
    /// Makes the folder in which trials are kept, and refuses one that has files of a trial to be made already.
    fn new(keep: Option<&'a Path>, open: &[u64]) -> Result<Self, CliError> {
        if let Some(folder) = keep {
            fs::create_dir_all(folder).map_err(|e| Self::fault(folder, &e.to_string()))?;
            let mut own = open.iter().map(|number| folder.join(number.to_string()));
            if let Some(taken) = own.find(|own| own.exists()) {
                let why = "exists already; remove it or name another folder";
                return Err(Self::fault(&taken, why));
            }
        }
        Ok(Self { keep })
    }

    fn fault(folder: &Path, why: &str) -> CliError {
        CliError::WrongUse(format!("--keep: {}: {why}", folder.display()))
    }

    fn run(&self, scope: &Scope, number: u64, control: &Control<'_>) -> Result<Trial, CliError> {
        let Some(keep) = self.keep else {
            return Ok(trial::run(scope, number, control));
        };
        let folder = keep.join(number.to_string());
        let kept = trial::run_in(scope, number, &folder, control);
        kept.map_err(|e| Self::fault(&folder, &e.to_string()))
    }
}

fn scope(campaign: &Campaign) -> Result<Scope, CliError> {
    let mut scope = Scope {
        outside: campaign.outside,
        ..Scope::all(campaign.seed)
    };
    if let Some(path) = &campaign.laws {
        let absolute = std::path::absolute(path).map_err(|e| {
            let path = path.display();
            CliError::WrongUse(format!("--laws {path}: {e}; name a file or a folder"))
        })?;
        scope.catalogue = laws::of_files(&absolute)?;
        scope.laws = vec![absolute];
    }
    let effects: Vec<&'static str> = concealed_effect::effects(&scope.catalogue)
        .map(|e| e.id)
        .collect();
    scope.effects.clone_from(&effects);
    if !campaign.effects.is_empty() {
        scope.effects = chosen("--effects", &campaign.effects, &effects)?;
    }
    scope.at_once = campaign.at_once;
    if !campaign.robots.is_empty() {
        scope.robots = chosen("--robots", &campaign.robots, &KINDS)?;
    }
    if !campaign.motion.is_empty() {
        let chosen = chosen("--motion", &campaign.motion, &Motion::ALL.map(Motion::name))?;
        scope
            .motions
            .retain(|motion| chosen.contains(&motion.name()));
    }
    if !campaign.noise.is_empty() {
        let chosen = chosen("--noise", &campaign.noise, &Noise::ALL.map(Noise::name))?;
        scope.noises.retain(|noise| chosen.contains(&noise.name()));
    }
    Ok(scope)
}

fn chosen(
    flag: &str,
    wanted: &[String],
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
    let motions: Vec<&str> = scope.motions.iter().map(|motion| motion.name()).collect();
    let noises: Vec<&str> = scope.noises.iter().map(|noise| noise.name()).collect();
    let mut drawn = serde_json::json!({
        "effects": scope.effects, "robots": scope.robots, "motion": motions, "noise": noises
    });
    if let Some(counts) = scope.at_once {
        drawn["at_once"] = serde_json::json!(counts.to_string());
    }
    if scope.outside {
        drawn["outside"] = true.into();
    }
    if !scope.laws.is_empty() {
        drawn["laws"] = serde_json::json!(scope.laws);
    }
    drawn
}

/// Trials of an earlier run that are drawn from the same.
fn earlier(target: &Path, scope: &Scope) -> Vec<Trial> {
    let Ok(outcome) = Outcome::read(target) else {
        return Vec::new();
    };
    let same = outcome.run.seed == scope.seed
        && outcome.run.version == VERSION
        && outcome.run.problem == drawn_from(scope);
    match outcome.part {
        Part::Trials(trials) if same => trials.trials,
        _ => Vec::new(),
    }
}

fn outcome(scope: &Scope, trials: Vec<Trial>, started: Instant, made: usize) -> Outcome {
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
            provenance: output::provenance(),
        },
        mistakes: Vec::new(),
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
