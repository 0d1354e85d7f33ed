//! `exid design`: an excitation trajectory.

use crate::check::Extent;
use crate::cli::args::Run;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{inputs, interrupt, output};
use crate::design::designed::{Designed, End, NamedTrajectory};
use crate::design::task;
use crate::outcome::estimate::Estimate;
use crate::outcome::folder::ResultFolder;
use crate::outcome::{Outcome, Part};
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use std::io::Write;
use std::time::Instant;

/// Name of the coefficients' file.
const COEFFICIENTS: &str = "coefficients.json";

pub fn run(run: &Run, problem: &ProblemFile) -> Result<u8, CliError> {
    let started = Instant::now();
    let target = output::target(run, problem, "design")?;
    let control = Control {
        interrupt: Some(interrupt::flag()),
        ..Control::default()
    };
    let progress = Progress::new(run.printing);
    let mistakes = output::mistakes(run, problem, &control, Extent::Robot)?;
    progress.say("designing");
    let mut designed = task::run(problem, run.seed, &control, |improvement| {
        progress.say(format!(
            "designing: {:.6} after {} starts",
            improvement.value, improvement.starts
        ));
    })?;
    progress.done();
    designed.design.files = names(&designed);
    let outcome = Outcome {
        name: problem.name.value.clone(),
        run: output::record(run, problem, &inputs::of_design(problem), started),
        mistakes,
        estimate: Estimate {
            solver: Some(designed.solver.clone()),
            ..Estimate::default()
        },
        part: Part::Design(designed.design.clone()),
    };
    output::finish(run.printing, &target, &outcome, |folder| {
        write_all(folder, &designed)
    })?;
    Ok(match designed.end {
        End::Feasible => 0,
        End::Infeasible => CliError::NO_SOLUTION,
        End::Interrupted => CliError::INTERRUPTED,
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

fn write_all(folder: &ResultFolder, designed: &Designed) -> Result<(), CliError> {
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
