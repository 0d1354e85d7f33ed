//! `design`: an excitation trajectory.

use crate::chain::words::count;
use crate::check::Extent;
use crate::design::results::designed::{Designed, End, NamedTrajectory};
use crate::design::task;
use crate::outcome::estimate::Estimate;
use crate::outcome::folder::ResultFolder;
use crate::outcome::{Outcome, Part};
use crate::problem_file::ProblemFile;
use crate::verb::completed::{Completed, Found};
use crate::verb::ending::Ending;
use crate::verb::error::VerbError;
use crate::verb::settings::Settings;
use crate::verb::{inputs, remaining};
use std::io::Write;
use std::time::Duration;

/// Name of the coefficients' file.
const COEFFICIENTS: &str = "coefficients.json";

/// Designs an experiment.
///
/// # Errors
/// As [`crate::verb::Verb::run`].
pub fn run(problem: &ProblemFile, settings: &Settings) -> Result<Completed, VerbError> {
    let mistakes = settings.mistakes(problem, Extent::Robot)?;
    settings.say("designing");
    let control = settings.control();
    let planned = problem.design.starts.as_ref().map(|starts| starts.value);
    let mut designed = task::run(problem, settings.seed, &control, |improvement| {
        let (value, made) = (improvement.value, improvement.starts);
        let elapsed = Duration::from_secs_f64(improvement.elapsed);
        let starts = planned.map_or_else(
            || count(made, "start"),
            |all| {
                format!(
                    "{made} of {}{}",
                    count(all, "start"),
                    remaining::left(elapsed, made, all)
                )
            },
        );
        settings.say(&format!("designing: {value:.6} after {starts}"));
    })?;
    designed.design.files = names(&designed);
    Ok(Completed {
        outcome: Outcome {
            name: problem.name.value.clone(),
            run: settings.record(problem, &inputs::of_design(problem)),
            mistakes,
            estimate: Estimate {
                solver: Some(designed.solver.clone()),
                ..Estimate::default()
            },
            part: Part::Design(designed.design.clone()),
        },
        ending: match designed.end {
            End::Feasible => Ending::Done,
            End::Infeasible => Ending::NoSolution,
            End::Interrupted => Ending::Interrupted,
        },
        found: Found::Design(Box::new(designed)),
    })
}

/// Names of the files in the results folder.
fn names(designed: &Designed) -> Vec<String> {
    let all = designed.trajectories.iter().chain(&designed.with_ramps);
    let mut names: Vec<String> = all.map(|t| format!("{}.csv", t.name)).collect();
    names.extend(designed.with_ramps.iter().map(yaml));
    names.push(COEFFICIENTS.to_string());
    names
}

fn yaml(trajectory: &NamedTrajectory) -> String {
    format!("{}.yaml", trajectory.name)
}

pub(super) fn write(folder: &ResultFolder, designed: &Designed) -> Result<(), VerbError> {
    for trajectory in designed.trajectories.iter().chain(&designed.with_ramps) {
        let name = format!("{}.csv", trajectory.name);
        folder.write(&name, |out| trajectory.sampled.write_csv(out))?;
    }
    for trajectory in &designed.with_ramps {
        folder.write(&yaml(trajectory), |out| trajectory.sampled.write_yaml(out))?;
    }
    folder.write(COEFFICIENTS, |out| {
        serde_json::to_writer_pretty(&mut *out, &designed.design.coefficients)?;
        writeln!(out)
    })?;
    Ok(())
}
