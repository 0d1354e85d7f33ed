//! The problem that a result keeps, with its inputs as they were.

use crate::chain::effect;
use crate::outcome::Outcome;
use crate::outcome::input::Input;
use crate::problem_file::ProblemFile;
use crate::verb::error::VerbError;
use std::path::{Path, PathBuf};

/// A problem that a result keeps.
#[derive(Debug)]
pub struct KeptProblem<'a> {
    outcome: &'a Outcome,
    problem: &'a Input,
    /// The folder in which the result was made, where its inputs are found from there and not from the working directory.
    pub elsewhere: Option<PathBuf>,
    /// What a reader of a repetition should know.
    pub notes: Vec<String>,
}

impl<'a> KeptProblem<'a> {
    /// Finds the inputs of a result, from the working directory or from where it was made.
    ///
    /// # Errors
    /// A result without a problem file, inputs that are gone or have changed.
    pub fn of(outcome: &'a Outcome) -> Result<Self, VerbError> {
        let Some((problem, inputs)) = outcome.run.inputs.split_first() else {
            return Err(VerbError::NoProblem);
        };
        let recorded = Path::new(&outcome.run.provenance.directory);
        let are_in = |folder: &Path| inputs.iter().all(|i| folder.join(&i.path).exists());
        let here = Path::new("");
        let elsewhere = (!are_in(here) && are_in(recorded)).then(|| recorded.to_path_buf());
        let folder = elsewhere.as_deref().unwrap_or(here);
        let changed: Vec<String> = inputs.iter().filter_map(|i| change(folder, i)).collect();
        if !changed.is_empty() {
            return Err(VerbError::ChangedInputs(changed));
        }
        let mut notes = Vec::new();
        if change(folder, problem).is_some() {
            let path = &problem.path;
            notes.push(format!(
                "{path} is not what it was, or gone; the problem kept in the result is run"
            ));
        }
        Ok(Self {
            outcome,
            problem,
            elsewhere,
            notes,
        })
    }

    /// The problem with overrides; its files are found from the working directory.
    ///
    /// # Errors
    /// An override that does not fit the problem.
    pub fn read(&self, overrides: &[String]) -> Result<ProblemFile, VerbError> {
        let folder = self.elsewhere.as_deref().unwrap_or(Path::new(""));
        let path = folder.join(&self.problem.path);
        let json = &self.outcome.run.problem;
        Ok(ProblemFile::kept(&path, json, overrides, &effect::ids())?)
    }
}

/// What has become of an input; nothing where it is the same.
fn change(folder: &Path, input: &Input) -> Option<String> {
    match Input::of(&folder.join(&input.path)) {
        Err(error) => Some(error.to_string()),
        Ok(now) if now.sha256 != input.sha256 => Some(format!(
            "{}: the file has changed since the result was made of it: its SHA-256 was {} and is {}",
            input.path, input.sha256, now.sha256
        )),
        Ok(_) => None,
    }
}
