//! What can be wrong with a problem file, each kind with its own code, message and remedy.

use std::fmt;

use crate::fault::{Description, Fault, Place, nearest, write_fault};
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
    /// The file as a whole.
    File(FileFault),
    /// A key is unknown, missing, or contradicts another.
    Key(KeyFault),
    /// The kind of a value.
    Value(ValueFault),
    /// The range of a number.
    Number(NumberFault),
    /// An override, or a key that a program sets.
    Override(OverrideFault),
}

/// The file as a whole cannot be used.
#[derive(Debug, Clone, PartialEq)]
pub enum FileFault {
    /// No file has the path.
    Missing,
    /// The path is a folder's.
    IsDirectory,
    /// The operating system refuses to read the file.
    PermissionDenied,
    /// Reading fails.
    Unreadable {
        /// What the system says.
        reason: String,
    },
    /// The file is larger than any problem.
    TooLarge {
        /// Its size, bytes.
        bytes: u64,
        /// The largest size that is read, bytes.
        limit: u64,
    },
    /// The text is not UTF-8.
    NotUtf8 {
        /// The first byte that is none of it.
        byte: u8,
        /// The file is named as a problem file is.
        is_named_toml: bool,
    },
    /// There is nothing in the file.
    Empty,
    /// The text is not TOML.
    Syntax {
        /// What the TOML reader says.
        reason: String,
        /// The file is named as a problem file is.
        is_named_toml: bool,
    },
}

/// What to do about a file that is another than a problem file, such as a recording or a robot.
const ANOTHER_FILE: &str = "name a problem file, whose name ends with .toml; `exid init` drafts one from recordings and the robot's file";

/// A key is unknown, missing, or contradicts another.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyFault {
    /// The table has no such key.
    Unknown {
        /// As written.
        found: String,
        /// The keys that it has.
        known: Vec<&'static str>,
        /// Another table that has a key of this name.
        elsewhere: Option<String>,
    },
    /// A required key is absent.
    Missing {
        /// What to write, in words.
        remedy: String,
    },
    /// Two statements contradict each other.
    Conflict {
        /// What was found, in words.
        found: String,
        /// What to do about it.
        remedy: String,
    },
}

/// A value is not of the kind that its key asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum ValueFault {
    /// The value is of another kind.
    WrongType {
        /// What would be right, in words.
        expected: &'static str,
        /// What stands there, in words.
        found: String,
    },
    /// A list has too many or too few entries.
    WrongLength {
        /// What would be right, in words.
        expected: String,
        /// How many it has.
        found: usize,
    },
    /// A table where TOML has split a name with dots that stands without quotes.
    UnquotedName {
        /// What the key asks for, in words.
        expected: &'static str,
    },
    /// A word that is not in the list for its key; each list has its own code.
    UnknownWord {
        /// What the word chooses, such as `estimator`.
        noun: &'static str,
        /// Code of the error.
        code: &'static str,
        /// As written.
        found: String,
        /// The words of the list.
        known: Vec<String>,
    },
    /// A name stands twice in a list.
    Duplicate {
        /// The name.
        found: String,
    },
    /// A text is blank.
    EmptyText,
    /// A list is empty.
    EmptyList,
    /// A text that cannot be the name of a folder.
    NotAFolderName {
        /// As written.
        found: String,
    },
}

/// A number is out of its range.
#[derive(Debug, Clone, PartialEq)]
pub enum NumberFault {
    /// NaN.
    NotANumber,
    /// Infinite where it may not be.
    Infinite {
        /// As written.
        found: f64,
    },
    /// Beyond the range of numbers of 64 bits.
    TooLarge {
        /// As written.
        found: String,
    },
    /// Not above zero.
    NotPositive {
        /// As written.
        found: f64,
    },
    /// Below zero.
    Negative {
        /// As written.
        found: f64,
    },
    /// Zero.
    Zero,
    /// Outside of another range.
    OutOfRange {
        /// As written.
        found: String,
        /// What is allowed, in words.
        range: &'static str,
    },
    /// A lower limit above the upper one.
    LowerAboveUpper {
        /// In the key's unit.
        lower: f64,
        /// In the key's unit.
        upper: f64,
    },
    /// A cut-off that is not below half of the rate.
    CutoffAboveNyquist {
        /// Hz.
        cutoff: f64,
        /// Samples per second, Hz.
        rate: f64,
    },
}

/// An override cannot be applied.
#[derive(Debug, Clone, PartialEq)]
pub enum OverrideFault {
    /// It is not `key=value`.
    Form {
        /// As given.
        found: String,
    },
    /// It is not the path of a key.
    Key {
        /// As given.
        found: String,
    },
    /// The key has more parts between dots than any key of the file.
    TooDeep {
        /// How many it has.
        parts: usize,
        /// The most that are read.
        limit: usize,
    },
    /// What follows the equals sign begins like a TOML value and is none.
    Value {
        /// As given.
        found: String,
        /// What the TOML reader says.
        reason: String,
    },
    /// The key lies below a value that is not a table.
    BelowValue {
        /// Path of that value.
        parent: String,
        /// What it is, in words.
        found: &'static str,
    },
}

impl ProblemFileError {
    /// At a place of the file.
    pub fn new(place: &Place, kind: impl Into<ProblemFileErrorKind>) -> Self {
        Self {
            place: place.clone(),
            kind: Box::new(kind.into()),
        }
    }

    /// What is at fault, for whoever tells faults apart in code.
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
            Self::NotUtf8 {
                byte,
                is_named_toml,
            } => (
                "not-utf8",
                format!("byte 0x{byte:02x} is not UTF-8 text"),
                match is_named_toml {
                    true => "save the file as UTF-8; a problem file is TOML text",
                    false => ANOTHER_FILE,
                },
            ),
            Self::Empty => (
                "empty-file",
                "the file is empty".to_owned(),
                "state at least the robot, with a table [robot]",
            ),
            Self::Syntax {
                reason,
                is_named_toml,
            } => (
                "syntax",
                format!("not TOML: {reason}"),
                match is_named_toml {
                    true => {
                        "correct the text here; texts need quotes, and a key stands once in a table"
                    }
                    false => ANOTHER_FILE,
                },
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
                        "{}{}known keys: {}",
                        elsewhere.unwrap_or_default(),
                        suggestion(found, known.iter().copied()),
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
                    "{}known: {}",
                    suggestion(found, known.iter().map(String::as_str)),
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
            Self::Key { found } => Description::new(
                "override-key",
                format!("\"{found}\" is not the path of a key"),
                "name a key of the problem file, such as fit.estimator",
            ),
            Self::TooDeep { parts, limit } => Description::new(
                "override-too-deep",
                format!("the key has {parts} parts between dots, more than {limit}"),
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

/// `did you mean "estimator"? ` where a known word is near, nothing where none is.
fn suggestion<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> String {
    let near = nearest(word, known);
    near.map_or(String::new(), |near| format!("did you mean \"{near}\"? "))
}
