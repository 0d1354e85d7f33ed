//! A run that came to a result: the outcome, how it ended, and what else it found.

use crate::design::designed::Designed;
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
    pub outcome: Outcome,
    pub ending: Ending,
    pub found: Found,
}

/// What a verb found beside what the outcome holds, of which the other files are made.
#[derive(Debug)]
pub enum Found {
    /// A check has its findings alone.
    Findings,
    Design(Box<Designed>),
    Diagnosis(Box<DiagnoseRun>),
    Fit(Box<FitRun>),
    Motors(Box<MotorRun>),
    Rollout(Vec<Window>),
    Simulation(Box<Simulated>),
}
