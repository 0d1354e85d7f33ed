//! `simulate`: recordings from a model.

use crate::check::Extent;
use crate::outcome::estimate::Estimate;
use crate::outcome::folder::ResultFolder;
use crate::outcome::simulation::Simulation;
use crate::outcome::{Outcome, Part};
use crate::problem::count::Done;
use crate::problem_file::ProblemFile;
use crate::simulate::{self, Simulated, SimulatedRecording, write_csv};
use crate::verb::completed::{Completed, Found};
use crate::verb::ending::Ending;
use crate::verb::error::VerbError;
use crate::verb::inputs;
use crate::verb::settings::Settings;
use crate::verb::steps::Steps;

/// Simulates the recordings of a problem.
///
/// # Errors
/// As [`crate::verb::Verb::run`].
pub fn run(problem: &ProblemFile, settings: &Settings) -> Result<Completed, VerbError> {
    let mistakes = settings.mistakes(problem, Extent::Robot)?;
    let steps = Steps::new(settings.progress);
    steps.begin("simulating recordings");
    let done = |done: &Done| steps.done(done);
    let simulated = simulate::run(problem, settings.seed, &settings.counted(&done))?;
    let named = |recordings: &[SimulatedRecording]| -> Vec<String> {
        recordings.iter().map(|r| r.name.clone()).collect()
    };
    let mut files = named(&simulated.recordings);
    files.extend(named(&simulated.trajectories));
    Ok(Completed {
        outcome: Outcome {
            name: problem.name.value.clone(),
            run: settings.record(problem, &inputs::of_simulation(problem)),
            mistakes,
            estimate: Estimate {
                parameters: simulated.truth.clone(),
                ..Estimate::default()
            },
            part: Part::Simulate(Simulation {
                files,
                realised_noise: simulated.realised_noise.clone(),
                positions: simulated.positions.clone(),
                notes: simulated.notes.clone(),
            }),
        },
        ending: Ending::Done,
        found: Found::Simulation(Box::new(simulated)),
    })
}

pub(super) fn write(folder: &ResultFolder, simulated: &Simulated) -> Result<(), VerbError> {
    for recording in simulated.recordings.iter().chain(&simulated.trajectories) {
        folder.write(&recording.name, |out| write_csv(out, recording))?;
    }
    Ok(())
}
