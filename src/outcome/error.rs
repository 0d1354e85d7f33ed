//! What can be wrong with a results folder: on the way out, or when it is read again.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::fault::{Description, Fault, Place, write_fault};

/// An error of the outcome layer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutcomeError {
    /// The file or folder.
    pub place: Place,
    /// What happened there.
    pub kind: OutcomeErrorKind,
}

/// What happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum OutcomeErrorKind {
    /// The results folder is to be where a file is.
    FileInTheWay,
    /// The folder holds something that is not a result; one of the names found in it.
    ForeignFolder {
        /// The first such name.
        found: String,
    },
    /// The folder is the working directory, or the working directory lies in it.
    WorkingFolder {
        /// The working directory.
        working: PathBuf,
    },
    /// The system refused an action for lack of permission.
    NotPermitted {
        /// What was being done.
        action: Action,
    },
    /// The system failed at an action, in its words.
    Failed {
        /// What was being done.
        action: Action,
        /// The system's words.
        reason: String,
    },
    /// The folder has no result, and folders in it have.
    ResultsWithin {
        /// These folders.
        folders: Vec<PathBuf>,
    },
    /// The text is not the result of a run.
    NotAResult(String),
    /// The predictions do not follow their layout.
    NotPredictions(String),
    /// The result cannot be written as JSON.
    NotEncodable(String),
}

/// What was being done with a file or folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// A file that a run names among its inputs is read for its hash.
    ReadInput,
    /// `result.json` is read.
    ReadResult,
    /// `predictions.csv` is read.
    ReadPredictions,
    /// The folder is looked into, whether it holds a result.
    InspectFolder,
    /// A folder is made.
    CreateFolder,
    /// A file is written into it.
    WriteFile,
    /// The new folder takes the place of the old one.
    ReplaceFolder,
}

impl Action {
    fn as_str(self) -> &'static str {
        match self {
            Action::ReadInput => "read the input",
            Action::ReadResult => "read the result",
            Action::ReadPredictions => "read the predictions",
            Action::InspectFolder => "look into the results folder",
            Action::CreateFolder => "create the results folder",
            Action::WriteFile => "write into the results folder",
            Action::ReplaceFolder => "put the results folder in place",
        }
    }

    /// Whether the action belongs to writing a result, so that `--out` is at fault.
    fn writes(self) -> bool {
        !matches!(
            self,
            Action::ReadInput | Action::ReadResult | Action::ReadPredictions
        )
    }
}

impl OutcomeError {
    /// A fault of the file or folder at a path.
    pub fn new(file: &Path, kind: OutcomeErrorKind) -> Self {
        Self {
            place: Place::file(file),
            kind,
        }
    }

    /// What the system said while `action` was under way on `file`.
    pub fn io(file: &Path, action: Action, error: &io::Error) -> Self {
        let kind = match error.kind() {
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                OutcomeErrorKind::NotPermitted { action }
            }
            _ => OutcomeErrorKind::Failed {
                action,
                reason: error.to_string(),
            },
        };
        Self::new(file, kind)
    }

    /// Whether the folder to write to is at fault, not something that was read.
    pub fn concerns_output(&self) -> bool {
        match &self.kind {
            OutcomeErrorKind::FileInTheWay
            | OutcomeErrorKind::ForeignFolder { .. }
            | OutcomeErrorKind::WorkingFolder { .. }
            | OutcomeErrorKind::NotEncodable(_) => true,
            OutcomeErrorKind::NotPermitted { action } | OutcomeErrorKind::Failed { action, .. } => {
                action.writes()
            }
            OutcomeErrorKind::ResultsWithin { .. }
            | OutcomeErrorKind::NotAResult(_)
            | OutcomeErrorKind::NotPredictions(_) => false,
        }
    }
}

impl Fault for OutcomeError {
    fn place(&self) -> &Place {
        &self.place
    }

    fn describe(&self) -> Description {
        const ANOTHER: &str = "give another folder with --out";
        match &self.kind {
            OutcomeErrorKind::FileInTheWay => Description::new(
                "out-is-a-file",
                "a file is where the results folder should be",
                format!("move it away, or {ANOTHER}"),
            ),
            OutcomeErrorKind::ForeignFolder { found } => Description::new(
                "out-is-not-a-result",
                format!(
                    "the folder is not empty (it holds `{found}`) and is not the result of an earlier run, so it is not replaced"
                ),
                format!("{ANOTHER}, or empty this one"),
            ),
            OutcomeErrorKind::WorkingFolder { working } => Description::new(
                "out-is-the-working-folder",
                format!(
                    "the results folder would replace the working directory {}",
                    working.display()
                ),
                "give a folder inside it with --out, or run from elsewhere",
            ),
            OutcomeErrorKind::NotPermitted { action } => describe_refusal(*action),
            OutcomeErrorKind::Failed { action, reason } => describe_failure(*action, reason),
            OutcomeErrorKind::ResultsWithin { folders } => {
                let names: Vec<String> = folders.iter().map(|f| f.display().to_string()).collect();
                Description::new(
                    "results-within",
                    "the folder is not the result of a run, but holds results",
                    format!("name one of {}", names.join(", ")),
                )
            }
            OutcomeErrorKind::NotAResult(reason) => Description::new(
                "not-a-result",
                format!("not the result of a run: {reason}"),
                "give the folder that a run wrote, or run it again",
            ),
            OutcomeErrorKind::NotPredictions(reason) => Description::new(
                "not-predictions",
                reason.clone(),
                "leave predictions.csv as the run wrote it, or run it again",
            ),
            OutcomeErrorKind::NotEncodable(reason) => Description::new(
                "not-encodable",
                format!("the result cannot be written as JSON: {reason}"),
                "report this as a defect of the program",
            ),
        }
    }
}

fn describe_refusal(action: Action) -> Description {
    let message = format!("no permission to {}", action.as_str());
    if action.writes() {
        Description::new(
            "out-not-permitted",
            message,
            "give a folder you may write to with --out, or change the permissions",
        )
    } else {
        Description::new("not-readable", message, "change its permissions")
    }
}

fn describe_failure(action: Action, reason: &str) -> Description {
    let message = format!("could not {}: {reason}", action.as_str());
    if action.writes() {
        Description::new(
            "out-not-written",
            message,
            "check the path and the free space, or give another folder with --out",
        )
    } else {
        Description::new("not-readable", message, "check the path")
    }
}

impl fmt::Display for OutcomeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_fault(f, self)
    }
}

impl std::error::Error for OutcomeError {}
