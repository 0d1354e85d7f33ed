//! How a run ended, and the exit codes that say so.

use crate::problem::defect::Defect;

/// The command line or the problem file is wrong, or the results folder cannot be written.
pub const WRONG_USE: u8 = 2;
/// A recording or robot file is wrong.
pub const WRONG_DATA: u8 = 3;
/// No solution.
pub const NO_SOLUTION: u8 = 4;
/// A defect of exid.
pub const DEFECT: u8 = 70;
/// Somebody interrupted the run: 128 and the number of the signal SIGINT.
pub const INTERRUPTED: u8 = 130;

/// How a run with a result ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// To its end.
    Done,
    /// A check found the problem file to be at fault.
    WrongProblem,
    /// A check found a recording or robot file to be at fault.
    WrongData,
    /// What was reached is no solution.
    NoSolution,
    /// The result is what was reached before the interrupt.
    Interrupted,
    /// The result is what was found before a defect of the program.
    Defect(Defect),
}

impl Ending {
    /// What the process returns to the shell.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Done => 0,
            Self::WrongProblem => WRONG_USE,
            Self::WrongData => WRONG_DATA,
            Self::NoSolution => NO_SOLUTION,
            Self::Interrupted => INTERRUPTED,
            Self::Defect(_) => DEFECT,
        }
    }
}
