//! `exid simulate`: recordings from a model.

use crate::check::Extent;
use crate::cli::args::Run;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{inputs, interrupt, output};
use crate::outcome::estimate::Estimate;
use crate::outcome::folder::ResultFolder;
use crate::outcome::simulation::Simulation;
use crate::outcome::{Outcome, Part};
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::simulate::{self, Simulated, write_csv};
use std::time::Instant;

pub fn run(run: &Run, problem: &ProblemFile) -> Result<u8, CliError> {
    let started = Instant::now();
    let target = output::target(run, problem, "simulate")?;
    let control = Control {
        interrupt: Some(interrupt::flag()),
        ..Control::default()
    };
    let progress = Progress::new(run.printing);
    let mistakes = output::mistakes(run, problem, &control, Extent::Robot)?;
    progress.say("simulating");
    let simulated = simulate::run(problem, run.seed, &control)?;
    progress.done();
    let named = |recordings: &[simulate::SimulatedRecording]| -> Vec<String> {
        recordings.iter().map(|r| r.name.clone()).collect()
    };
    let mut files = named(&simulated.recordings);
    files.extend(named(&simulated.trajectories));
    let outcome = Outcome {
        name: problem.name.value.clone(),
        run: output::record(run, problem, &inputs::of_simulation(problem), started),
        mistakes,
        estimate: Estimate {
            parameters: simulated.truth.clone(),
            ..Estimate::default()
        },
        part: Part::Simulate(Simulation {
            files,
            realised_noise: simulated.realised_noise.clone(),
            notes: simulated.notes.clone(),
        }),
    };
    output::finish(run.printing, &target, &outcome, |folder| {
        write_all(folder, &simulated)
    })?;
    Ok(0)
}

fn write_all(folder: &ResultFolder, simulated: &Simulated) -> Result<(), CliError> {
    for recording in simulated.recordings.iter().chain(&simulated.trajectories) {
        folder.write(&recording.name, |out| write_csv(out, recording))?;
    }
    Ok(())
}
