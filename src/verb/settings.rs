//! What a run is given beside its problem: seed, interrupt, progress, what to do with mistakes.

use crate::check::{self, Extent};
use crate::outcome::check::{Mistake, Severity};
use crate::outcome::input::Input;
use crate::outcome::provenance::{Provenance, VERSION};
use crate::outcome::run::Run as Record;
use crate::problem::count::Done;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::verb::error::VerbError;
use crate::verb::inputs;
use crate::verb::steps::Steps;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// What to do where mistakes in the inputs make every figure meaningless.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OnMistakes {
    /// End the run with the mistakes.
    Refuse,
    /// Report them beside the result.
    GoOn,
}

/// How a problem is run.
pub struct Settings<'a> {
    /// Seed of everything random.
    pub seed: u64,
    /// What to do where inputs have mistakes.
    pub on_mistakes: OnMistakes,
    /// Set from anywhere; the run ends with what it has.
    pub interrupt: Option<Arc<AtomicBool>>,
    /// Hears of every step, in words.
    pub progress: &'a (dyn Fn(&str) + Sync),
    /// Arguments of the command, for the record.
    pub command: Vec<String>,
    /// From when on wall time counts.
    pub started: Instant,
}

impl Settings<'_> {
    pub(super) fn control(&self) -> Control<'static> {
        Control {
            interrupt: self.interrupt.clone(),
            ..Control::default()
        }
    }

    /// The same, with a watcher who hears of every part of a run that is done.
    pub(super) fn counted<'b>(&self, done: &'b (dyn Fn(&Done) + Sync)) -> Control<'b> {
        Control {
            parts: Some(done),
            ..self.control()
        }
    }

    /// What the inputs say wrongly, as far as an extent goes.
    fn looked_for(&self, problem: &ProblemFile, extent: Extent) -> Vec<Mistake> {
        let steps = Steps::new(self.progress);
        steps.begin("looking for mistakes in the inputs");
        let done = |done: &Done| steps.done(done);
        check::mistakes(problem, &self.counted(&done), extent)
    }

    pub(super) fn say(&self, step: &str) {
        (self.progress)(step);
    }

    /// Mistakes in what the inputs say, before any work is done with them.
    ///
    /// # Errors
    /// Where they make every figure meaningless, unless the run goes on all the same.
    pub(super) fn mistakes(
        &self,
        problem: &ProblemFile,
        extent: Extent,
    ) -> Result<Vec<Mistake>, VerbError> {
        let mistakes = self.looked_for(problem, extent);
        let errors = mistakes.iter().filter(|m| m.severity == Severity::Error);
        self.refuse(errors.cloned().collect())?;
        Ok(mistakes)
    }

    /// The same for a verb that looks for missing physics: what a single recording of several shows may be that.
    ///
    /// # Errors
    /// Where mistakes that all recordings share make every figure meaningless, unless the run goes on all the same.
    pub(super) fn mistakes_beside_physics(
        &self,
        problem: &ProblemFile,
    ) -> Result<Vec<Mistake>, VerbError> {
        let mistakes = self.looked_for(problem, Extent::Everything);
        let errors: Vec<&Mistake> = mistakes
            .iter()
            .filter(|m| m.severity == Severity::Error)
            .collect();
        let recordings = inputs::by_recording(problem);
        let is_of = |files: &[String], error: &Mistake| {
            error.file.as_ref().is_some_and(|file| files.contains(file))
        };
        let stands = |error: &&&Mistake| {
            let alike =
                |other: &&&Mistake| (&other.code, &other.channel) == (&error.code, &error.channel);
            let shows = |files: &Vec<String>| errors.iter().filter(alike).any(|e| is_of(files, e));
            let of_one = recordings.iter().any(|files| is_of(files, error));
            check::is_no_physics(error) || !of_one || recordings.iter().all(shows)
        };
        let standing = errors.iter().filter(stands);
        self.refuse(standing.map(|error| (*error).clone()).collect())?;
        Ok(mistakes)
    }

    fn refuse(&self, errors: Vec<Mistake>) -> Result<(), VerbError> {
        match errors.is_empty() || self.on_mistakes != OnMistakes::Refuse {
            true => Ok(()),
            false => Err(VerbError::Mistakes(errors)),
        }
    }

    /// The common head of a result; files that cannot be read any more are left out.
    pub(super) fn record(&self, problem: &ProblemFile, files: &[PathBuf]) -> Record {
        // A problem that a program states in memory has no file.
        let stated = Input::of(&problem.path)
            .unwrap_or_else(|_| Input::of_text(&problem.path, &problem.json.to_string()));
        let memory = problem.recordings.as_ref().map(|r| &r.reading.memory);
        let input = |file: &PathBuf| match memory.and_then(|memory| memory.at(file)) {
            Some(arrays) => Some(Input {
                path: file.display().to_string(),
                sha256: arrays.sha256(),
            }),
            None => Input::of(file).ok(),
        };
        Record {
            version: VERSION.to_string(),
            seed: self.seed,
            problem: problem.json.clone(),
            inputs: std::iter::once(stated)
                .chain(files.iter().filter_map(input))
                .collect(),
            wall_s: self.started.elapsed().as_secs_f64(),
            provenance: Provenance::of_this_process(self.command.clone()),
        }
    }
}
