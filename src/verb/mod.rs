//! Runs of the verbs: from a problem to its outcome and the files beside it, for the program and for other languages.

pub mod check;
pub mod completed;
pub mod design;
pub mod diagnose;
pub mod ending;
pub mod error;
pub mod fit;
pub mod folder;
pub mod inputs;
pub mod kept;
mod motors;
mod predictions;
pub mod remaining;
pub mod rollout;
pub mod settings;
pub mod simulate;
pub mod steps;
mod written;

use crate::problem_file::ProblemFile;
use crate::verb::completed::Completed;
use crate::verb::error::VerbError;
use crate::verb::settings::Settings;

/// The verbs that run a problem file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verb {
    /// Mistakes in the inputs.
    Check,
    /// A motion for an experiment.
    Design,
    /// Missing physics.
    Diagnose,
    /// Parameters from recordings.
    Fit,
    /// Recordings from a model.
    Simulate,
}

impl Verb {
    /// All of them, in the order of the alphabet.
    pub const ALL: [Self; 5] = [
        Self::Check,
        Self::Design,
        Self::Diagnose,
        Self::Fit,
        Self::Simulate,
    ];

    /// The verb as it stands on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Check => "check",
            Self::Design => "design",
            Self::Diagnose => "diagnose",
            Self::Fit => "fit",
            Self::Simulate => "simulate",
        }
    }

    /// Runs a problem; nothing is written.
    ///
    /// # Errors
    /// What keeps the run from any result: files that cannot be read or do not fit together, mistakes that are not to be
    /// passed over, an interrupt before anything is found.
    pub fn run(self, problem: &ProblemFile, settings: &Settings) -> Result<Completed, VerbError> {
        match self {
            Self::Check => Ok(check::run(problem, settings)),
            Self::Design => design::run(problem, settings),
            Self::Diagnose => diagnose::run(problem, settings),
            Self::Fit => fit::run(problem, settings),
            Self::Simulate => simulate::run(problem, settings),
        }
    }
}
