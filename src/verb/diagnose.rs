//! `diagnose`: where model and recordings differ, what physics is missing, the model with it.

use crate::chain::dataset::Dataset;
use crate::diagnose::task::{self, DiagnoseRun};
use crate::outcome::folder::ResultFolder;
use crate::outcome::predictions::Quantity;
use crate::outcome::rollout::Rollout;
use crate::outcome::{FORMULAS_FILE, NEXT_FILE, Outcome, Part};
use crate::problem::count::Done;
use crate::problem::defect::guarded;
use crate::problem::solution::Stop;
use crate::problem_file::ProblemFile;
use crate::rollout;
use crate::verb::completed::{Completed, Found};
use crate::verb::ending::Ending;
use crate::verb::error::VerbError;
use crate::verb::predictions::Predicted;
use crate::verb::settings::Settings;
use crate::verb::steps::Steps;
use crate::verb::{fit, inputs};
use std::io::Write;

/// Diagnoses a problem.
///
/// # Errors
/// As [`crate::verb::Verb::run`].
pub fn run(problem: &ProblemFile, settings: &Settings) -> Result<Completed, VerbError> {
    let mistakes = settings.mistakes_beside_physics(problem)?;
    let steps = Steps::new(settings.progress);
    let done = |done: &Done| steps.done(done);
    let control = settings.counted(&done);
    let mut result = task::run(problem, &control, &|stage| steps.begin(&stage.words()))?;
    let interrupted = control.is_interrupted();
    let stop = match (&result.defect, interrupted) {
        (Some(_), _) => Some(Stop::Defect),
        (None, true) => Some(Stop::Interrupted),
        (None, false) => None,
    };
    if let (Some(stop), Some(solver)) = (stop, &mut result.estimate.solver) {
        solver.stop = stop.name().to_string();
        solver.converged = false;
    }
    let defect = result.defect.take();
    let mut outcome = Outcome {
        name: problem.name.value.clone(),
        run: settings.record(problem, &inputs::of_recordings(problem)),
        mistakes,
        estimate: result.estimate.clone(),
        part: Part::Diagnose(Box::new(result.diagnosis.clone())),
    };
    if stop.is_none() {
        settings.say("simulating forward");
        let prepared = std::mem::take(&mut result.prepared);
        let rollout = rolled_out(problem, &outcome, prepared, settings);
        result.diagnosis.rollout.clone_from(&rollout);
        if let Part::Diagnose(diagnosis) = &mut outcome.part {
            diagnosis.rollout = rollout;
        }
    }
    Ok(Completed {
        ending: match defect {
            Some(defect) => Ending::Defect(defect),
            None => fit::ending(interrupted, &outcome.estimate),
        },
        outcome,
        found: Found::Diagnosis(Box::new(result)),
    })
}

/// The models of a diagnosis simulated forward; what stands in the way, a defect among it, is said by `exid rollout`.
fn rolled_out(
    problem: &ProblemFile,
    outcome: &Outcome,
    prepared: Dataset,
    settings: &Settings,
) -> Option<Rollout> {
    let task = rollout::Task {
        problem,
        outcome,
        source: "",
        set: &[],
        seed: settings.seed,
    };
    let rolled = guarded(|| rollout::over_prepared(task, prepared, &settings.control()));
    let rolled = rolled.ok()?.ok()?;
    Some(Rollout {
        examples: Vec::new(),
        skeleton: None,
        ..rolled.rollout
    })
}

pub(super) fn write(folder: &ResultFolder, result: &DiagnoseRun) -> Result<(), VerbError> {
    predicted(result, |predicted| predicted.write(folder))?;
    if let Some(next) = &result.diagnosis.next_experiment {
        folder.write(NEXT_FILE, |out| out.write_all(next.problem.as_bytes()))?;
    }
    let formulas = result
        .diagnosis
        .findings
        .iter()
        .filter_map(|finding| finding.formula.as_ref());
    let laws: Vec<&str> = formulas.map(|formula| formula.law.as_str()).collect();
    if !laws.is_empty() {
        folder.write(FORMULAS_FILE, |out| {
            out.write_all(laws.join("\n").as_bytes())
        })?;
    }
    Ok(())
}

/// Does something with what the declared and the final model predict.
pub(super) fn predicted<T>(result: &DiagnoseRun, then: impl FnOnce(&Predicted<'_>) -> T) -> T {
    then(&Predicted {
        model: &result.model,
        data: &result.data,
        series: &[
            (Quantity::Baseline, &result.baseline),
            (Quantity::Final, &result.finally),
        ],
    })
}
