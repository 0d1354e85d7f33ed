//! `rollout`: the models of a result simulated forward beside the recording that was held out.

use crate::outcome::estimate::Estimate;
use crate::outcome::input::Input;
use crate::outcome::{Outcome, Part};
use crate::problem_file::ProblemFile;
use crate::rollout::error::RolloutError;
use crate::rollout::{self, Task};
use crate::verb::completed::{Completed, Found};
use crate::verb::ending::Ending;
use crate::verb::error::VerbError;
use crate::verb::inputs;
use crate::verb::settings::Settings;

/// A result whose models are rolled out.
#[derive(Debug)]
pub struct RolledResult<'a> {
    /// Of a fit or a diagnosis, with its models in full.
    pub outcome: &'a Outcome,
    /// The problem that it keeps, overrides included.
    pub problem: &'a ProblemFile,
    /// Where the result is, as the user named it, and its file; None of a result that was not written.
    pub source: String,
    /// The file of the result; None of a result that was not written.
    pub file: Option<Input>,
    /// The overrides.
    pub set: &'a [String],
    /// Anything a reader should know, one sentence each.
    pub notes: Vec<String>,
}

/// Only results that hold an identified robot are rolled out.
///
/// # Errors
/// The result is of another verb.
pub fn require_robot(outcome: &Outcome) -> Result<(), VerbError> {
    match &outcome.part {
        Part::Fit(_) | Part::Diagnose(_) => Ok(()),
        part => Err(RolloutError::NoRobot { verb: part.verb() }.into()),
    }
}

/// Rolls out the models of a result.
///
/// # Errors
/// As [`crate::verb::Verb::run`], and a result without a model.
pub fn run(result: RolledResult<'_>, settings: &Settings) -> Result<Completed, VerbError> {
    let RolledResult {
        outcome,
        problem,
        source,
        file,
        set,
        mut notes,
    } = result;
    require_robot(outcome)?;
    let task = Task {
        problem,
        outcome,
        source: &source,
        set,
        seed: settings.seed,
    };
    let say = |step: &str| settings.say(step);
    let mut rolled = rollout::run(task, &settings.control(), &say)?;
    notes.append(&mut rolled.rollout.notes);
    rolled.rollout.notes = notes;
    let mut run = settings.record(problem, &inputs::of_recordings(problem));
    run.inputs.extend(file);
    Ok(Completed {
        outcome: Outcome {
            name: outcome.name.clone(),
            run,
            mistakes: Vec::new(),
            estimate: Estimate::default(),
            part: Part::Rollout(Box::new(rolled.rollout)),
        },
        ending: Ending::Done,
        found: Found::Rollout(rolled.examples),
    })
}
