//! `exid diagnose`: where model and recordings differ, what physics is missing, the model with it.

use crate::cli::args::Run;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{inputs, interrupt, output, predictions};
use crate::diagnose::task;
use crate::outcome::predictions::Quantity;
use crate::outcome::{NEXT_FILE, Outcome, Part};
use crate::problem::solution::{Control, Stop};
use crate::problem_file::ProblemFile;
use std::io::Write;
use std::time::Instant;

pub fn run(run: &Run, problem: &ProblemFile) -> Result<u8, CliError> {
    let started = Instant::now();
    let target = output::target(run, problem, "diagnose")?;
    let control = Control {
        interrupt: Some(interrupt::flag()),
        ..Control::default()
    };
    let progress = Progress::new(run.printing);
    let mut result = task::run(problem, &control, &|stage| progress.say(stage.words()))?;
    progress.say("writing the results");
    let stop = match (&result.defect, control.is_interrupted()) {
        (Some(_), _) => Some(Stop::Defect),
        (None, true) => Some(Stop::Interrupted),
        (None, false) => None,
    };
    if let (Some(stop), Some(solver)) = (stop, &mut result.estimate.solver) {
        solver.stop = stop.name().to_string();
        solver.converged = false;
    }
    let defect = result.defect.take();
    let outcome = Outcome {
        name: problem.name.value.clone(),
        run: output::record(run, problem, &inputs::of_recordings(problem), started),
        mistakes: std::mem::take(&mut result.mistakes),
        estimate: result.estimate.clone(),
        part: Part::Diagnose(Box::new(result.diagnosis.clone())),
    };
    progress.done();
    output::finish(run.printing, &target, &outcome, |folder| {
        let predicted = [
            (Quantity::Baseline, &result.baseline),
            (Quantity::Final, &result.finally),
        ];
        predictions::write(folder, (&result.model, &result.data), &predicted)?;
        if let Some(next) = &result.diagnosis.next_experiment {
            folder.write(NEXT_FILE, |out| out.write_all(next.problem.as_bytes()))?;
        }
        Ok(())
    })?;
    if let Some(defect) = defect {
        return Ok(output::exit_code_of_defect(&defect, &target));
    }
    Ok(output::exit_code(
        control.is_interrupted(),
        outcome.estimate.solver.as_ref(),
    ))
}
