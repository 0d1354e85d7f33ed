//! `exid fit`: parameters from recordings.

use crate::check::Extent;
use crate::cli::args::Run;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{inputs, interrupt, motors, output, predictions};
use crate::diagnose::simulator::{self, Side};
use crate::estimate::task::{self, FitRun};
use crate::outcome::predictions::Quantity;
use crate::outcome::{Outcome, Part};
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::problem_file::choices::Estimator;
use std::time::Instant;

pub fn run(run: &Run, problem: &ProblemFile) -> Result<u8, CliError> {
    let started = Instant::now();
    let target = output::target(run, problem, "fit")?;
    let control = Control {
        interrupt: Some(interrupt::flag()),
        ..Control::default()
    };
    let progress = Progress::new(run.printing);
    progress.say("looking for mistakes in the inputs");
    let mistakes = output::mistakes(run, problem, &control, Extent::Recordings)?;
    if problem.fit.estimator.value == Estimator::ConstantVelocity {
        return motors::run(run, problem, &target, mistakes, started);
    }
    let simulated = match problem.of_simulator() {
        Some(simulator) => {
            progress.say("identifying the simulator");
            Some(task::run(&simulator, &control, |_| {})?)
        }
        None => None,
    };
    let mut result = task::run(problem, &control, |step| progress.say(step.words()))?;
    result.fitted.fit.simulator =
        simulated.map(|simulated| simulator::compare(&side(&simulated), &side(&result)));
    progress.say("writing the results");
    let defect = result.defect.clone();
    let outcome = Outcome {
        name: problem.name.value.clone(),
        run: output::record(run, problem, &inputs::of_recordings(problem), started),
        mistakes,
        estimate: result.fitted.estimate.clone(),
        part: Part::Fit(result.fitted.fit.clone()),
    };
    progress.done();
    // The recordings go before the report reads what was written of them.
    output::finish(run.printing, &target, &outcome, move |folder| {
        let FitRun { fitted, data, .. } = result;
        let predicted = [(Quantity::Predicted, &fitted.predictions)];
        predictions::write(folder, (&fitted.model, &data), &predicted)
    })?;
    if let Some(defect) = defect {
        return Ok(output::exit_code_of_defect(&defect, &target));
    }
    Ok(output::exit_code(
        control.is_interrupted(),
        outcome.estimate.solver.as_ref(),
    ))
}

/// What a fit identified, to be compared.
fn side(run: &FitRun) -> Side<'_> {
    Side {
        estimate: &run.fitted.estimate,
        fit: &run.fitted.fit,
        findings: &[],
        model: &run.fitted.model,
        values: &run.fitted.values,
        data: &run.data,
    }
}
