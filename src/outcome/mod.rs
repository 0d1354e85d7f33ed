//! What a run found: the data model of `result.json`, and the results folder it is written to.
//!
//! Every verb of the command line produces one [`Outcome`]: what was run, what was estimated, and
//! the part of its verb. The keys and their order in the file are the fields in the order in which
//! they stand here; a number that is not finite is written as `null` and read back as not a number.

pub mod check;
pub mod compare;
pub mod design;
pub mod diagnose;
pub mod difference;
pub mod error;
pub mod estimate;
pub mod feasibility;
pub mod finding;
pub mod fit;
pub mod fleet;
pub mod folder;
pub mod formula;
pub mod input;
pub mod joint;
pub mod load;
pub mod machine;
pub mod model_comparison;
pub mod motors;
pub mod number;
pub mod parameter;
pub mod predictions;
pub mod provenance;
pub mod rollout;
pub mod run;
pub mod sharing;
pub mod simulation;
pub mod simulator;
pub mod skeleton;
pub mod trials;

pub mod document;

use serde::Serialize;

use crate::outcome::check::{Check, Mistake};
use crate::outcome::design::Design;
use crate::outcome::diagnose::Diagnosis;
use crate::outcome::estimate::Estimate;
use crate::outcome::fit::Fit;
use crate::outcome::fleet::Fleet;
use crate::outcome::rollout::Rollout;
use crate::outcome::run::Run;
use crate::outcome::simulation::Simulation;
use crate::outcome::trials::Trials;

/// Name of the result in its folder.
pub const RESULT_FILE: &str = "result.json";

/// Name of the table of recorded and predicted signals in the results folder.
pub const PREDICTIONS_FILE: &str = "predictions.csv";

/// Name of the table of windows, sample by sample, in the folder of a rollout.
pub const WINDOWS_FILE: &str = "rollouts.csv";

/// Name of the rendered report in the results folder.
pub const REPORT_FILE: &str = "report.html";

/// Name of the rendered report of a fleet.
pub const FLEET_REPORT_FILE: &str = "fleet.html";

/// Name of the problem file for the recording that would tell rivals apart.
pub const NEXT_FILE: &str = "next_experiment.toml";

/// Laws that a diagnosis proposes for what has no name, as `laws` of a problem file takes them.
pub const FORMULAS_FILE: &str = "formulas.toml";

/// The result of one run: the common head and the part of the verb.
///
/// In JSON all parts lie flat beside each other: `name`, `verb`, the keys of [`Run`], of
/// [`Estimate`] and of the [`Part`].
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Name of the problem.
    pub name: String,
    /// What was run, on what.
    pub run: Run,
    /// What the inputs say wrongly, the worst first; `check` has it as its findings.
    pub mistakes: Vec<Mistake>,
    /// What was estimated; empty for verbs that estimate nothing.
    pub estimate: Estimate,
    /// What only this verb gives.
    pub part: Part,
}

/// What a verb adds to the common head.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
#[allow(clippy::large_enum_variant)] // one per run
pub enum Part {
    /// Parameters with base parameters, identifiability and comparisons.
    Fit(Fit),
    /// Mistakes in the inputs.
    Check(Check),
    /// Recordings that were made.
    Simulate(Simulation),
    /// A motion for an experiment.
    Design(Design),
    /// Missing physics.
    Diagnose(Box<Diagnosis>),
    /// How often the diagnosis is right where the truth is known.
    Trials(Trials),
    /// Forward simulation beside recordings.
    Rollout(Box<Rollout>),
    /// Robots that have changed.
    Fleet(Box<Fleet>),
}

impl Outcome {
    /// The robot that the run identified, if it identified one.
    pub fn machine(&self) -> Option<&machine::Machine> {
        match &self.part {
            Part::Fit(fit) => fit.machine.as_ref(),
            Part::Diagnose(diagnosis) => diagnosis.fit.as_ref()?.machine.as_ref(),
            _ => None,
        }
    }
}

impl Outcome {
    /// The nearest possible robot, where the identified one is not possible.
    pub fn possible_machine(&self) -> Option<&machine::Machine> {
        match &self.part {
            Part::Fit(fit) => fit.possible_machine.as_ref(),
            Part::Diagnose(diagnosis) => diagnosis.fit.as_ref()?.possible_machine.as_ref(),
            _ => None,
        }
    }
}

impl Part {
    /// The verb as it stands on the command line and in the file.
    pub fn verb(&self) -> &'static str {
        match self {
            Part::Fit(_) => "fit",
            Part::Check(_) => "check",
            Part::Simulate(_) => "simulate",
            Part::Design(_) => "design",
            Part::Diagnose(_) => "diagnose",
            Part::Trials(_) => "trials",
            Part::Rollout(_) => "rollout",
            Part::Fleet(_) => "fleet",
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
