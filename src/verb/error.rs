//! Why a run gives no result: what is wrong, where, what to do about it, and the exit code that says so.

use crate::design::error::DesignError;
use crate::diagnose::error::DiagnoseError;
use crate::estimate::task::FitError;
use crate::export::error::ExportError;
use crate::fault::{Description, Fault, Place};
use crate::motors::error::MotorsError;
use crate::outcome::check::Mistake;
use crate::outcome::error::OutcomeError;
use crate::problem_file::error::{KeyFault, NumberFault, OverrideFault, ValueFault};
use crate::problem_file::{ProblemFileError, ProblemFileErrorKind};
use crate::report::text;
use crate::rollout::error::RolloutError;
use crate::setup::error::SetupError;
use crate::simulate::error::SimulateError;
use crate::verb::ending::{DEFECT, INTERRUPTED, NO_SOLUTION, WRONG_DATA, WRONG_USE};
use thiserror::Error;

/// Why a run ends without a result.
#[derive(Debug, Error)]
pub enum VerbError {
    /// The problem file cannot be read, or states what cannot be.
    #[error(transparent)]
    Problem(#[from] ProblemFileError),
    /// No motion can be designed.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// No parameters can be estimated.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// No motor constants can be estimated.
    #[error(transparent)]
    Motors(#[from] MotorsError),
    /// The declared model cannot be fitted, so that nothing can be compared with it.
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    /// No recordings can be made.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// No motion can be simulated from the result.
    #[error(transparent)]
    Rollout(#[from] RolloutError),
    /// The results folder cannot be read or written.
    #[error(transparent)]
    Outcome(#[from] OutcomeError),
    /// The robot of the result does not go into the format.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// Mistakes in the inputs with which every figure would be meaningless.
    #[error("{}\n--force goes on all the same", in_lines(.0))]
    Mistakes(Vec<Mistake>),
    /// Files that have changed since a result was made from them, one line each.
    #[error("{}\nrestore them, or run the problem anew", .0.join("\n"))]
    ChangedInputs(Vec<String>),
    /// A result that names no problem file.
    #[error("the result names no problem file; only results of runs can be repeated")]
    NoProblem,
}

/// A fault for whoever handles it in code; what the underlying error does not tell apart is left out.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Account {
    /// File, line, column and key, as far as they are known; absent of a fault without a place.
    pub place: Option<Place>,
    /// Stable identifier in kebab-case.
    pub code: String,
    /// What is wrong, with the value found.
    pub message: String,
    /// The value itself, where one value is at fault.
    pub value: Option<String>,
    /// What to do about it; absent where the message says it.
    pub remedy: Option<String>,
}

impl VerbError {
    /// What the process returns to the shell.
    pub fn exit_code(&self) -> u8 {
        if self.is_interrupt() {
            return INTERRUPTED;
        }
        match self {
            Self::Design(DesignError::Solve(_)) => NO_SOLUTION,
            Self::Design(error) => of_files(error.concerns_data()),
            Self::Fit(FitError::Setup(error)) => of_files(error.concerns_data()),
            Self::Fit(FitError::Estimate { .. }) => NO_SOLUTION,
            Self::Motors(error) => of_files(error.concerns_data()),
            Self::Diagnose(DiagnoseError::Setup(error)) => of_files(error.concerns_data()),
            Self::Diagnose(DiagnoseError::Fit(_)) => NO_SOLUTION,
            Self::Diagnose(DiagnoseError::Defect(_)) | Self::Fit(FitError::Defect(_)) => DEFECT,
            Self::Simulate(error) => of_files(error.concerns_data()),
            Self::Rollout(error) => of_files(error.concerns_data()),
            Self::Mistakes(_) | Self::ChangedInputs(_) => WRONG_DATA,
            Self::Problem(_) | Self::Outcome(_) | Self::Export(_) | Self::NoProblem => WRONG_USE,
        }
    }

    /// Whether somebody interrupted the run before it had a result.
    pub fn is_interrupt(&self) -> bool {
        match self {
            Self::Simulate(error) => error.is_interrupt(),
            Self::Rollout(error) => error.is_interrupt(),
            _ => self.setup().is_some_and(SetupError::is_interrupt),
        }
    }

    /// Place, code, message and remedy apart from one another.
    pub fn account(&self) -> Account {
        match self {
            Self::Problem(error) => of_problem_file(error),
            Self::Design(error) => of_fault(error),
            Self::Simulate(error) => of_fault(error),
            Self::Outcome(error) => of_fault(error),
            Self::Mistakes(findings) => of_mistakes(findings, self),
            Self::ChangedInputs(_) => in_words("changed-inputs", self),
            Self::NoProblem => in_words("no-problem-in-result", self),
            Self::Export(error) => {
                let Description {
                    code,
                    message,
                    remedy,
                } = error.describe();
                Account {
                    place: None,
                    code: code.to_owned(),
                    message,
                    value: None,
                    remedy: Some(remedy),
                }
            }
            Self::Fit(FitError::Estimate { .. }) | Self::Diagnose(DiagnoseError::Fit(_)) => {
                in_words("no-estimate", self)
            }
            Self::Fit(FitError::Defect(_)) | Self::Diagnose(DiagnoseError::Defect(_)) => {
                in_words("defect", self)
            }
            Self::Motors(error) if error.setup().is_none() => in_words("no-motor-constants", self),
            Self::Rollout(error) if error.setup().is_none() => in_words("no-rollout", self),
            _ => match self.setup() {
                Some(SetupError::ProblemFile(error)) => of_problem_file(error),
                Some(error) => of_fault(error),
                None => Account::default(),
            },
        }
    }

    /// The fault of files behind an error that has one.
    fn setup(&self) -> Option<&SetupError> {
        match self {
            Self::Fit(FitError::Setup(error)) | Self::Diagnose(DiagnoseError::Setup(error)) => {
                Some(error)
            }
            Self::Motors(error) => error.setup(),
            Self::Rollout(error) => error.setup(),
            _ => None,
        }
    }
}

/// The account of an error of any layer.
pub fn of_fault(fault: &impl Fault) -> Account {
    let Description {
        code,
        message,
        remedy,
    } = fault.describe();
    Account {
        place: Some(fault.place().clone()),
        code: code.to_owned(),
        message,
        value: None,
        remedy: Some(remedy),
    }
}

/// The account of an error of a problem file.
pub fn of_problem_file(error: &ProblemFileError) -> Account {
    Account {
        value: value_of(error.kind()),
        ..of_fault(error)
    }
}

/// The value that a problem file should not have.
fn value_of(kind: &ProblemFileErrorKind) -> Option<String> {
    let found = match kind {
        ProblemFileErrorKind::Key(KeyFault::Unknown { found, .. })
        | ProblemFileErrorKind::Value(
            ValueFault::WrongType { found, .. }
            | ValueFault::UnknownWord { found, .. }
            | ValueFault::Duplicate { found }
            | ValueFault::NotAFolderName { found },
        )
        | ProblemFileErrorKind::Number(
            NumberFault::TooLarge { found } | NumberFault::OutOfRange { found, .. },
        )
        | ProblemFileErrorKind::Override(
            OverrideFault::Form { found } | OverrideFault::Value { found, .. },
        ) => found.clone(),
        ProblemFileErrorKind::Value(ValueFault::WrongLength { found, .. }) => found.to_string(),
        ProblemFileErrorKind::Number(
            NumberFault::Infinite { found }
            | NumberFault::NotPositive { found }
            | NumberFault::Negative { found },
        ) => found.to_string(),
        _ => return None,
    };
    Some(found)
}

fn in_words(code: &str, error: &VerbError) -> Account {
    let text = error.to_string();
    let (message, remedy) = match text.rsplit_once("; ") {
        Some((message, remedy)) => (message.to_owned(), Some(remedy.to_owned())),
        None => (text, None),
    };
    Account {
        place: None,
        code: code.to_owned(),
        message,
        value: None,
        remedy,
    }
}

fn of_mistakes(findings: &[Mistake], error: &VerbError) -> Account {
    let Some(first) = findings.first() else {
        return in_words("mistakes", error);
    };
    Account {
        place: first.file.as_ref().map(|file| Place {
            key: first.channel.clone(),
            ..Place::file(file)
        }),
        code: first.code.to_string(),
        message: first.message.clone(),
        value: None,
        remedy: Some(first.remedy.clone()),
    }
}

/// Mistakes with their remedies; the word that says what they are stands before them.
fn in_lines(mistakes: &[Mistake]) -> String {
    let lines = mistakes.iter().flat_map(text::finding_lines);
    let lines: Vec<String> = lines.collect();
    let text = lines.join("\n");
    text.strip_prefix("error: ").unwrap_or(&text).to_string()
}

/// Whether a recording or robot file is at fault, or the problem file.
fn of_files(concerns_data: bool) -> u8 {
    if concerns_data { WRONG_DATA } else { WRONG_USE }
}
