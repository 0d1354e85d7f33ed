//! What keeps a solver from starting, or shows a defect; a run that does not converge is a result instead.

use std::fmt;

use crate::fault::{Description, Fault, Place, write_fault};
use crate::problem::OutsideDomain;
use crate::problem::error::ProblemError;

/// The `file` of a fault that lies in what a solver was given in memory.
const SOLVER: &str = "solver";

/// A fault of a solver's input.
#[derive(Debug, Clone, PartialEq)]
pub struct SolveError {
    /// The variable or setting at fault, under the name of the solver or problem.
    pub place: Place,
    /// What is wrong with it.
    pub kind: SolveErrorKind,
}

/// The kinds of [`SolveError`].
#[derive(Debug, Clone, PartialEq)]
pub enum SolveErrorKind {
    /// The starting point has the wrong number of entries.
    StartLength {
        /// Entries of x.
        expected: usize,
        /// Entries of the start.
        found: usize,
    },
    /// A starting value is not a finite number.
    StartNotFinite {
        /// The value at the place.
        value: f64,
    },
    /// The problem has no value at the starting point.
    StartOutsideDomain {
        /// What the problem says of the point.
        reason: String,
    },
    /// Cost, gradient or constraints are not finite at the starting point.
    ModelNotFinite,
    /// A setting outside its range.
    Setting {
        /// What was given.
        value: f64,
        /// What is allowed, in words.
        range: &'static str,
    },
    /// The problem itself is at fault.
    Problem(Box<ProblemError>),
    /// The machinery failed in a way that no input explains.
    Defect {
        /// What failed.
        message: String,
    },
}

impl SolveError {
    /// A fault of the run as a whole.
    pub fn whole(kind: SolveErrorKind) -> Self {
        Self {
            place: Place::file(SOLVER),
            kind,
        }
    }

    /// A fault at a named setting or variable.
    pub fn at(name: &str, kind: SolveErrorKind) -> Self {
        Self {
            place: Place::file(SOLVER).key(name),
            kind,
        }
    }
}

/// Tolerances are at least zero and below one.
pub(super) fn check_tolerances(tolerances: &[(&'static str, f64)]) -> Result<(), SolveError> {
    for &(name, value) in tolerances {
        if !(0.0..1.0).contains(&value) {
            let range = "0 <= value < 1";
            return Err(SolveError::at(
                name,
                SolveErrorKind::Setting { value, range },
            ));
        }
    }
    Ok(())
}

impl From<ProblemError> for SolveError {
    fn from(error: ProblemError) -> Self {
        Self {
            place: error.place.clone(),
            kind: SolveErrorKind::Problem(Box::new(error)),
        }
    }
}

impl From<OutsideDomain> for SolveError {
    /// Of the starting point: at a trial step the error is not a fault.
    fn from(error: OutsideDomain) -> Self {
        Self::whole(SolveErrorKind::StartOutsideDomain {
            reason: error.reason,
        })
    }
}

impl Fault for SolveError {
    fn place(&self) -> &Place {
        &self.place
    }

    fn describe(&self) -> Description {
        use SolveErrorKind as K;
        match &self.kind {
            K::StartLength { expected, found } => Description::new(
                "start-length",
                format!("the start has {found} values, the problem {expected} variables"),
                "give one starting value per variable",
            ),
            K::StartNotFinite { value } => Description::new(
                "start-not-finite",
                format!("the starting value is {value}"),
                "give a finite starting value",
            ),
            K::StartOutsideDomain { reason } => Description::new(
                "start-outside-domain",
                format!("the problem has no value at the start: {reason}"),
                "start where every part of the problem is defined",
            ),
            K::ModelNotFinite => Description::new(
                "model-not-finite",
                "cost, gradient or constraints are not finite at the start",
                "check the data for missing or infinite values, or start elsewhere",
            ),
            K::Setting { value, range } => Description::new(
                "setting-out-of-range",
                format!("the value is {value}"),
                format!("give a value with {range}"),
            ),
            K::Problem(error) => error.describe(),
            K::Defect { message } => Description::new(
                "solver-defect",
                format!("the solver failed: {message}"),
                "report this as a defect with the problem that shows it",
            ),
        }
    }
}

impl fmt::Display for SolveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_fault(f, self)
    }
}

impl std::error::Error for SolveError {}
