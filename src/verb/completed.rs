//! A run that came to a result: the outcome, how it ended, and what else it found.

use crate::design::results::designed::Designed;
use crate::diagnose::task::DiagnoseRun;
use crate::estimate::task::FitRun;
use crate::motors::task::MotorRun;
use crate::outcome::Outcome;
use crate::rollout::Window;
use crate::simulate::Simulated;
use crate::verb::ending::Ending;

/// A run with its result.
#[derive(Debug)]
pub struct Completed {
    /// The result, as `result.json` has it.
    pub outcome: Outcome,
    /// How the run ended.
    pub ending: Ending,
    /// What the other files of the results folder are made of.
    pub found: Found,
}

/// What a verb found beside what the outcome holds, of which the other files are made.
#[derive(Debug)]
pub enum Found {
    /// A check has its findings alone.
    Findings,
    /// A motion.
    Design(Box<Designed>),
    /// A diagnosis with its recordings.
    Diagnosis(Box<DiagnoseRun>),
    /// A fit with its recordings.
    Fit(Box<FitRun>),
    /// Motor constants with predicted currents.
    Motors(Box<MotorRun>),
    /// Windows sample by sample.
    Rollout(Vec<Window>),
    /// Recordings with their truth.
    Simulation(Box<Simulated>),
}
