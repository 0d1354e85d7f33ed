//! What can be wrong with a problem file, each kind with its own code, message and remedy.

use std::fmt;

use crate::fault::{Description, Fault, Place, write_fault};
use crate::problem_file::key::{Key, sections};

/// A fault in a problem file or in an override of one of its keys.
#[derive(Debug, Clone, PartialEq)]
pub struct ProblemFileError {
    place: Place,
    // Boxed, so that every result of this layer stays small.
    kind: Box<ProblemFileErrorKind>,
}

/// What is at fault.
#[derive(Debug, Clone, PartialEq)]
pub enum ProblemFileErrorKind {
    File(FileFault),
    Key(KeyFault),
    Value(ValueFault),
    Number(NumberFault),
    Override(OverrideFault),
}

/// The file as a whole cannot be used.
#[derive(Debug, Clone, PartialEq)]
pub enum FileFault {
    Missing,
    IsDirectory,
    PermissionDenied,
    Unreadable { reason: String },
    TooLarge { bytes: u64, limit: u64 },
    NotUtf8 { byte: u8 },
    Empty,
    Syntax { reason: String },
}

/// A key is unknown, missing, or contradicts another.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyFault {
    Unknown {
        found: String,
        known: Vec<&'static str>,
        /// Another table that has a key of this name.
        elsewhere: Option<String>,
    },
    Missing {
        remedy: String,
    },
    Conflict {
        found: String,
        remedy: String,
    },
}

/// A value is not of the kind that its key asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum ValueFault {
    WrongType {
        expected: &'static str,
        found: String,
    },
    WrongLength {
        expected: String,
        found: usize,
    },
    /// A table where TOML has split a name with dots that stands without quotes.
    UnquotedName {
        expected: &'static str,
    },
    /// A word that is not in the list for its key; each list has its own code.
    UnknownWord {
        noun: &'static str,
        code: &'static str,
        found: String,
        known: Vec<String>,
    },
    Duplicate {
        found: String,
    },
    EmptyText,
    EmptyList,
    NotAFolderName {
        found: String,
    },
}

/// A number is out of its range.
#[derive(Debug, Clone, PartialEq)]
pub enum NumberFault {
    NotANumber,
    Infinite { found: f64 },
    TooLarge { found: String },
    NotPositive { found: f64 },
    Negative { found: f64 },
    Zero,
    OutOfRange { found: String, range: &'static str },
    LowerAboveUpper { lower: f64, upper: f64 },
    CutoffAboveNyquist { cutoff: f64, rate: f64 },
}

/// An override cannot be applied.
#[derive(Debug, Clone, PartialEq)]
pub enum OverrideFault {
    /// It is not `key=value`.
    Form { found: String },
    /// The key has more parts between dots than any key of the file.
    TooDeep { parts: usize, limit: usize },
    /// What follows the equals sign begins like a TOML value and is none.
    Value { found: String, reason: String },
    /// The key lies below a value that is not a table.
    BelowValue { parent: String, found: &'static str },
}

impl ProblemFileError {
    pub fn new(place: &Place, kind: impl Into<ProblemFileErrorKind>) -> Self {
        Self {
            place: place.clone(),
            kind: Box::new(kind.into()),
        }
    }

    pub fn kind(&self) -> &ProblemFileErrorKind {
        &self.kind
    }

    /// The same; of an unknown key with the name of another table among these `keys` that has it.
    pub(super) fn naming_table_among(mut self, keys: &'static [Key]) -> Self {
        if let ProblemFileErrorKind::Key(KeyFault::Unknown {
            found, elsewhere, ..
        }) = self.kind.as_mut()
        {
            let mut tables = sections(keys).into_iter().skip(1);
            let table = tables.find(|table| table.keys.iter().any(|key| key.name == found));
            *elsewhere = table.map(|table| table.path.join("."));
        }
        self
    }
}

impl Fault for ProblemFileError {
    fn place(&self) -> &Place {
        &self.place
    }

    fn describe(&self) -> Description {
        match self.kind.as_ref() {
            ProblemFileErrorKind::File(fault) => fault.describe(),
            ProblemFileErrorKind::Key(fault) => fault.describe(),
            ProblemFileErrorKind::Value(fault) => fault.describe(),
            ProblemFileErrorKind::Number(fault) => fault.describe(),
            ProblemFileErrorKind::Override(fault) => fault.describe(),
        }
    }
}

impl fmt::Display for ProblemFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_fault(f, self)
    }
}

impl std::error::Error for ProblemFileError {}

impl From<FileFault> for ProblemFileErrorKind {
    fn from(fault: FileFault) -> Self {
        Self::File(fault)
    }
}

impl From<KeyFault> for ProblemFileErrorKind {
    fn from(fault: KeyFault) -> Self {
        Self::Key(fault)
    }
}

impl From<ValueFault> for ProblemFileErrorKind {
    fn from(fault: ValueFault) -> Self {
        Self::Value(fault)
    }
}

impl From<NumberFault> for ProblemFileErrorKind {
    fn from(fault: NumberFault) -> Self {
        Self::Number(fault)
    }
}

impl From<OverrideFault> for ProblemFileErrorKind {
    fn from(fault: OverrideFault) -> Self {
        Self::Override(fault)
    }
}

impl FileFault {
    fn describe(&self) -> Description {
        let (code, message, remedy) = match self {
            Self::Missing => (
                "file-missing",
                "there is no such file".to_owned(),
                "check the path of the problem file",
            ),
            Self::IsDirectory => (
                "file-is-directory",
                "this is a directory, not a file".to_owned(),
                "name the problem file in it",
            ),
            Self::PermissionDenied => (
                "permission-denied",
                "no permission to read the file".to_owned(),
                "make the file readable",
            ),
            Self::Unreadable { reason } => (
                "unreadable",
                format!("the file cannot be read: {reason}"),
                "check the path and the disk",
            ),
            Self::TooLarge { bytes, limit } => (
                "file-too-large",
                format!("the file has {bytes} bytes or more, above the limit of {limit}"),
                "name the problem file, not a recording",
            ),
            Self::NotUtf8 { byte } => (
                "not-utf8",
                format!("byte 0x{byte:02x} is not UTF-8 text"),
                "save the file as UTF-8; a problem file is TOML text",
            ),
            Self::Empty => (
                "empty-file",
                "the file is empty".to_owned(),
                "state at least the robot, with a table [robot]",
            ),
            Self::Syntax { reason } => (
                "syntax",
                format!("not TOML: {reason}"),
                "correct the text here; texts need quotes, and a key stands once in a table",
            ),
        };
        Description::new(code, message, remedy)
    }
}

impl KeyFault {
    fn describe(&self) -> Description {
        match self {
            Self::Unknown {
                found,
                known,
                elsewhere,
            } => {
                let elsewhere = elsewhere
                    .as_ref()
                    .map(|table| format!("\"{found}\" is a key of [{table}]; "));
                Description::new(
                    "unknown-key",
                    format!("unknown key \"{found}\""),
                    format!(
                        "{}did you mean \"{}\"? known keys: {}",
                        elsewhere.unwrap_or_default(),
                        nearest(found, known.iter().copied()),
                        known.join(", ")
                    ),
                )
            }
            Self::Missing { remedy } => {
                Description::new("missing-key", "this key is required and missing", remedy)
            }
            Self::Conflict { found, remedy } => Description::new("conflict", found, remedy),
        }
    }
}

impl ValueFault {
    fn describe(&self) -> Description {
        let (code, message, remedy) = match self {
            Self::WrongType { expected, found } => (
                "wrong-type",
                format!("found {found}"),
                format!("give {expected}"),
            ),
            Self::WrongLength { expected, found } => (
                "wrong-length",
                format!("the number of values is {found}"),
                format!("give {expected}"),
            ),
            Self::UnquotedName { expected } => (
                "unquoted-name",
                "found a table, which is how TOML reads a name with dots and no quotes".to_owned(),
                format!("put the name in quotes, \"joint1.Fc\" = ..., and give {expected}"),
            ),
            Self::UnknownWord {
                noun,
                code,
                found,
                known,
            } => (
                *code,
                format!("unknown {noun} \"{found}\""),
                format!(
                    "did you mean \"{}\"? known: {}",
                    nearest(found, known.iter().map(String::as_str)),
                    known.join(", ")
                ),
            ),
            Self::Duplicate { found } => (
                "duplicate",
                format!("\"{found}\" stands here twice"),
                "remove one of the two".to_owned(),
            ),
            Self::EmptyText => (
                "empty-text",
                "the text is empty".to_owned(),
                "give a name".to_owned(),
            ),
            Self::EmptyList => (
                "empty-list",
                "the list is empty".to_owned(),
                "give at least one value, or leave the key out where it is optional".to_owned(),
            ),
            Self::NotAFolderName { found } => (
                "not-a-folder-name",
                format!("\"{found}\" cannot be the name of the results folder"),
                "use letters, digits, spaces, \"-\", \"_\" and \".\", but not dots alone"
                    .to_owned(),
            ),
        };
        Description::new(code, message, remedy)
    }
}

impl NumberFault {
    fn describe(&self) -> Description {
        const OTHER: &str = "or leave the key out where it is optional";
        let (code, message, remedy) = match self {
            Self::NotANumber => (
                "not-a-number",
                "the value is NaN".to_owned(),
                format!("give a number, {OTHER}"),
            ),
            Self::Infinite { found } => (
                "infinite",
                format!("the value {found} is infinite"),
                format!("give a finite number, {OTHER}"),
            ),
            Self::TooLarge { found } => (
                "number-too-large",
                format!("{found} is beyond the numbers that can be represented"),
                format!("give a smaller number, {OTHER}"),
            ),
            Self::NotPositive { found } => (
                "not-positive",
                format!("{found} is not greater than zero"),
                format!("give a number greater than zero, {OTHER}"),
            ),
            Self::Negative { found } => (
                "negative",
                format!("{found} is negative"),
                format!("give zero or a number greater than zero, {OTHER}"),
            ),
            Self::Zero => (
                "zero",
                "the value is 0".to_owned(),
                format!("give a value other than zero, {OTHER}"),
            ),
            Self::OutOfRange { found, range } => (
                "out-of-range",
                format!("{found} is out of range"),
                format!("give a value {range}"),
            ),
            Self::LowerAboveUpper { lower, upper } => (
                "lower-above-upper",
                format!("lower {lower} is above upper {upper}"),
                "give the lower value first".to_owned(),
            ),
            Self::CutoffAboveNyquist { cutoff, rate } => (
                "cutoff-above-nyquist",
                format!("the cut-off {cutoff} Hz is not below half the rate of {rate} Hz"),
                "lower the cut-off, or correct recordings.rate".to_owned(),
            ),
        };
        Description::new(code, message, remedy)
    }
}

impl OverrideFault {
    fn describe(&self) -> Description {
        match self {
            Self::Form { found } => Description::new(
                "override-form",
                format!("\"{found}\" is not of the form key=value"),
                "write it such as fit.estimator=wls",
            ),
            Self::TooDeep { parts, limit } => Description::new(
                "override-too-deep",
                format!("the key of --set has {parts} parts between dots, more than {limit}"),
                "name a key of the problem file, such as fit.estimator",
            ),
            Self::Value { found, reason } => Description::new(
                "override-value",
                format!("{found} is not a TOML value: {reason}"),
                "correct the value; quote it for the shell where it has brackets or quotes",
            ),
            Self::BelowValue { parent, found } => Description::new(
                "override-below-value",
                format!("\"{parent}\" is {found}, which has no keys"),
                format!("set {parent} as a whole"),
            ),
        }
    }
}

/// The candidate most like the word; the first of equals.
fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> &'a str {
    let mut best = ("", -1.0);
    for candidate in candidates {
        // Jaro-Winkler favours a common beginning, which is how names are cut short; edits count
        // where a short word has letters exchanged.
        let word = word.to_lowercase();
        let likeness = strsim::jaro_winkler(&word, candidate)
            .max(strsim::normalized_damerau_levenshtein(&word, candidate));
        if likeness > best.1 {
            best = (candidate, likeness);
        }
    }
    best.0
}
