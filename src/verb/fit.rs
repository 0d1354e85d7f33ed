//! `fit`: parameters from recordings.

use crate::check::Extent;
use crate::diagnose::simulator::{self, Side};
use crate::estimate::task::{self, FitRun};
use crate::outcome::estimate::Estimate;
use crate::outcome::folder::ResultFolder;
use crate::outcome::predictions::Quantity;
use crate::outcome::{Outcome, Part};
use crate::problem::count::Done;
use crate::problem_file::ProblemFile;
use crate::verb::completed::{Completed, Found};
use crate::verb::ending::Ending;
use crate::verb::error::VerbError;
use crate::verb::predictions::Predicted;
use crate::verb::settings::Settings;
use crate::verb::steps::Steps;
use crate::verb::{inputs, motors};

/// Fits a problem.
///
/// # Errors
/// As [`crate::verb::Verb::run`].
pub fn run(problem: &ProblemFile, settings: &Settings) -> Result<Completed, VerbError> {
    let mistakes = settings.mistakes(problem, Extent::Recordings)?;
    if problem.fit.is_of_motors() {
        return motors::run(problem, settings, mistakes);
    }
    let steps = Steps::new(settings.progress);
    let done = |done: &Done| steps.done(done);
    let control = settings.counted(&done);
    let simulated = match problem.of_simulator() {
        Some(simulator) => {
            steps.begin("identifying the simulator");
            Some(task::run(&simulator, &control, |_| {})?)
        }
        None => None,
    };
    let mut result = task::run(problem, &control, |step| steps.begin(step.words()))?;
    result.fitted.fit.simulator =
        simulated.map(|simulated| simulator::compare(&side(&simulated), &side(&result)));
    let defect = result.defect.take();
    let outcome = Outcome {
        name: problem.name.value.clone(),
        run: settings.record(problem, &inputs::of_recordings(problem)),
        mistakes,
        estimate: result.fitted.estimate.clone(),
        part: Part::Fit(result.fitted.fit.clone()),
    };
    Ok(Completed {
        ending: match defect {
            Some(defect) => Ending::Defect(defect),
            None => ending(control.is_interrupted(), &outcome.estimate),
        },
        outcome,
        found: Found::Fit(Box::new(result)),
    })
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

/// How an estimate ended that no defect did.
pub(super) fn ending(interrupted: bool, estimate: &Estimate) -> Ending {
    let unsolved = estimate.solver.as_ref().is_some_and(|s| !s.converged);
    match (interrupted, unsolved) {
        (true, _) => Ending::Interrupted,
        (false, true) => Ending::NoSolution,
        (false, false) => Ending::Done,
    }
}

pub(super) fn write(folder: &ResultFolder, run: &FitRun) -> Result<(), VerbError> {
    predicted(run, |predicted| predicted.write(folder))
}

/// Does something with what the fitted model predicts.
pub(super) fn predicted<T>(run: &FitRun, then: impl FnOnce(&Predicted<'_>) -> T) -> T {
    let FitRun { fitted, data, .. } = run;
    then(&Predicted {
        model: &fitted.model,
        data,
        series: &[(Quantity::Predicted, &fitted.predictions)],
    })
}
