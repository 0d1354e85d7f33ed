//! One trial: the robot is simulated, its recordings written, diagnosed, and judged.

use crate::chain::effect;
use crate::diagnose::task;
use crate::outcome::trials::Trial;
use crate::problem::defect::guarded;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::trials::error::TrialError;
use crate::trials::files::{CLEAN, PROBLEM, prepare, prepare_larger};
use crate::trials::forecast::forecast;
use crate::trials::longer_recording;
use crate::trials::plan::{Plan, Scope};
use crate::trials::reference_fits::{informed, sizes};
use crate::trials::score;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// Draws of a trial until a robot can follow its motion.
const ATTEMPTS: u64 = 8;

/// Runs one trial; a failure is an answer too.
pub fn run(scope: &Scope, number: u64, control: &Control<'_>) -> Trial {
    attempts(scope, number, |plan| {
        let scratch = tempfile::tempdir()?;
        one(plan, scratch.path(), control)
    })
}

/// Runs one trial and leaves its files, and what it came to, in `folder`, which is made.
///
/// # Errors
/// The folder exists, or cannot be written.
pub fn run_in(
    scope: &Scope,
    number: u64,
    folder: &Path,
    control: &Control<'_>,
) -> Result<Trial, std::io::Error> {
    fs::create_dir(folder)?;
    let trial = attempts(scope, number, |plan| {
        fs::remove_dir_all(folder)?;
        fs::create_dir(folder)?;
        one(plan, folder, control)
    });
    fs::write(folder.join(JUDGED), serde_json::to_string_pretty(&trial)?)?;
    Ok(trial)
}

/// Draws a trial until its robot can follow its motion, and runs it.
fn attempts(
    scope: &Scope,
    number: u64,
    mut one: impl FnMut(&Plan) -> Result<Trial, TrialError>,
) -> Trial {
    let started = Instant::now();
    let mut trial = Trial::default();
    for attempt in 0..ATTEMPTS {
        let plan = Plan::draw(scope, number, attempt);
        match guarded(|| one(&plan)).unwrap_or_else(|defect| Err(defect.into())) {
            Ok(done) => {
                trial = done;
                break;
            }
            Err(error) => {
                let could_not_move = matches!(&error, TrialError::Simulate(e) if !e.is_interrupt());
                trial = score::failed(&plan, error.to_string());
                if !could_not_move {
                    break;
                }
            }
        }
    }
    trial.seconds = started.elapsed().as_secs_f64();
    trial
}

fn one(plan: &Plan, folder: &Path, control: &Control<'_>) -> Result<Trial, TrialError> {
    let made = prepare(plan, folder, control)?;
    let problem = folder.join(PROBLEM);
    let diagnosed = {
        let read = ProblemFile::read(&problem, &[], &effect::ids())?;
        task::run(&read, control, &|_| ())?
    };
    if let Some(defect) = diagnosed.defect {
        return Err(defect.into());
    }
    let sizes = sizes(plan, &folder.join(CLEAN).join(PROBLEM), control)?;
    let informed = informed(plan, &problem, control)?;
    let mut trial = score::judge(plan, &diagnosed, informed.as_ref(), &sizes);
    let longer = folder.join(LONGER_FOLDER);
    longer_recording::judge(
        plan,
        &diagnosed.ambiguities,
        &mut trial.found,
        &longer,
        control,
    )?;
    if plan.counts_formulas {
        let mut nameless = score::nameless(plan, &diagnosed.diagnosis);
        if let Some(law) = &plan.law {
            let problem = prepare_larger(plan, &made, folder, control)?;
            let of_joint = forecast(plan, &diagnosed.nameless, law.joint, &problem, control)?;
            nameless.forecast = Some(of_joint);
        }
        trial.nameless = Some(nameless);
    }
    Ok(trial)
}

/// What the trial came to, in a folder that is kept.
const JUDGED: &str = "trial.json";

/// The folder in it with longer recordings.
const LONGER_FOLDER: &str = "longer";
