//! What `check` adds: what is wrong with the inputs, and what to do about it.

use serde::{Deserialize, Serialize};

use crate::fault::{Description, Fault};

/// The part of `check`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// What was found, the worst first.
    pub findings: Vec<Mistake>,
}

/// How much a finding matters; the worst comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// There can be no result, or it would be wrong.
    Error,
    /// A result may be wrong because of it.
    Warning,
    /// Worth knowing; nothing has to be done.
    Note,
}

impl Severity {
    /// The word that stands in the result.
    pub fn as_str(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        }
    }
}

/// Something about an input that is wrong or worth knowing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mistake {
    /// Stable identifier in kebab-case.
    pub code: String,
    /// How much it matters.
    pub severity: Severity,
    /// The file it is about.
    pub file: Option<String>,
    /// Channel, key or element; absent where the file as a whole is meant.
    pub channel: Option<String>,
    /// What is wrong, with the value found.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
    /// Line in the file, from 1.
    #[serde(default)]
    pub line: Option<usize>,
}

impl Mistake {
    /// The finding that says what a fault says.
    pub fn from_fault(fault: &impl Fault, severity: Severity) -> Self {
        let Description {
            code,
            message,
            remedy,
        } = fault.describe();
        let place = fault.place();
        Self {
            code: code.to_string(),
            severity,
            file: Some(place.file.display().to_string()).filter(|file| !file.is_empty()),
            channel: place.key.clone(),
            message,
            remedy,
            line: place.line,
        }
    }
}
