//! What can be wrong with a problem file, each kind with its own code, message and remedy.

use std::fmt;

use crate::fault::{Description, Fault, Place, write_fault};

/// A fault in a problem file or in an override of one of its keys.
#[derive(Debug, Clone, PartialEq)]
pub struct ProblemFileError {
    place: Place,
    kind: Box<ProblemFileErrorKind>,
}

/// The kinds of faults. `found` is the value as written.
#[derive(Debug, Clone, PartialEq)]
pub enum ProblemFileErrorKind {
    FileMissing,
    FileIsDirectory,
    PermissionDenied,
    Unreadable {
        reason: String,
    },
    NotUtf8 {
        byte: u8,
    },
    EmptyFile,
    Syntax {
        reason: String,
    },
    /// A key that no table of this name has.
    UnknownKey {
        key: String,
        known: &'static [&'static str],
        /// The table that does have a key of this name.
        elsewhere: Option<&'static str>,
    },
    MissingKey {
        remedy: String,
    },
    Conflict {
        found: String,
        remedy: String,
    },
    WrongType {
        expected: &'static str,
        found: String,
    },
    WrongLength {
        expected: String,
        found: usize,
    },
    /// A word that is not in the list for its key, which has its own code.
    UnknownWord {
        noun: &'static str,
        code: &'static str,
        found: String,
        known: Vec<String>,
    },
    NotANumber,
    Infinite {
        found: f64,
    },
    NumberTooLarge {
        found: String,
    },
    NotPositive {
        found: f64,
    },
    Negative {
        found: f64,
    },
    Zero,
    OutOfRange {
        found: String,
        range: &'static str,
    },
    LowerAboveUpper {
        lower: f64,
        upper: f64,
    },
    CutoffAboveNyquist {
        cutoff: f64,
        rate: f64,
    },
    Duplicate {
        found: String,
    },
    EmptyText,
    EmptyList,
    NotAFolderName {
        found: String,
    },
    /// An override that is not `key=value`.
    OverrideForm {
        found: String,
    },
    OverrideValue {
        found: String,
        reason: String,
    },
    /// An override of a key below a value that is not a table.
    OverrideBelowValue {
        parent: String,
        found: &'static str,
    },
}

impl ProblemFileError {
    pub fn new(place: &Place, kind: ProblemFileErrorKind) -> Self {
        Self {
            place: place.clone(),
            kind: Box::new(kind),
        }
    }

    pub fn kind(&self) -> &ProblemFileErrorKind {
        &self.kind
    }
}

impl Fault for ProblemFileError {
    fn place(&self) -> &Place {
        &self.place
    }

    fn describe(&self) -> Description {
        self.kind
            .describe_file()
            .or_else(|| self.kind.describe_key())
            .or_else(|| self.kind.describe_number())
            .unwrap_or_else(|| self.kind.describe_text())
    }
}

impl fmt::Display for ProblemFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_fault(f, self)
    }
}

impl std::error::Error for ProblemFileError {}

impl ProblemFileErrorKind {
    /// Faults of the file as a whole.
    fn describe_file(&self) -> Option<Description> {
        Some(match self {
            Self::FileMissing => Description::new(
                "file-missing",
                "there is no such file",
                "check the path of the problem file",
            ),
            Self::FileIsDirectory => Description::new(
                "file-is-directory",
                "this is a directory, not a file",
                "name the problem file in it",
            ),
            Self::PermissionDenied => Description::new(
                "permission-denied",
                "no permission to read the file",
                "make the file readable",
            ),
            Self::Unreadable { reason } => Description::new(
                "unreadable",
                format!("the file cannot be read: {reason}"),
                "check the path and the disk",
            ),
            Self::NotUtf8 { byte } => Description::new(
                "not-utf8",
                format!("byte 0x{byte:02x} is not UTF-8 text"),
                "save the file as UTF-8; a problem file is TOML text",
            ),
            Self::EmptyFile => Description::new(
                "empty-file",
                "the file is empty",
                "state at least the robot, with a table [robot]",
            ),
            Self::Syntax { reason } => Description::new(
                "syntax",
                format!("not TOML: {reason}"),
                "correct the text at this place; texts need quotes, a key stands once in a table",
            ),
            _ => return None,
        })
    }

    /// Faults of keys, and of values against each other.
    fn describe_key(&self) -> Option<Description> {
        Some(match self {
            Self::UnknownKey {
                key,
                known,
                elsewhere,
            } => Description::new(
                "unknown-key",
                format!("unknown key \"{key}\""),
                unknown_key_remedy(key, known, *elsewhere),
            ),
            Self::MissingKey { remedy } => {
                Description::new("missing-key", "this is missing", remedy)
            }
            Self::Conflict { found, remedy } => Description::new("conflict", found, remedy),
            Self::Duplicate { found } => Description::new(
                "duplicate",
                format!("\"{found}\" stands here twice"),
                "remove one of the two",
            ),
            Self::LowerAboveUpper { lower, upper } => Description::new(
                "lower-above-upper",
                format!("lower {lower} is above upper {upper}"),
                "give the lower value first",
            ),
            Self::CutoffAboveNyquist { cutoff, rate } => Description::new(
                "cutoff-above-nyquist",
                format!(
                    "cut-off {cutoff} Hz is not below half the rate of {rate} Hz, {} Hz",
                    rate / 2.0
                ),
                "lower the cut-off, or correct recordings.rate",
            ),
            _ => return None,
        })
    }

    /// Faults of single numbers.
    fn describe_number(&self) -> Option<Description> {
        Some(match self {
            Self::NotANumber => {
                Description::new("not-a-number", "the value is NaN", "give a number")
            }
            Self::Infinite { found } => Description::new(
                "infinite",
                format!("the value {found} is infinite"),
                "give a finite number, or leave the key out where it is optional",
            ),
            Self::NumberTooLarge { found } => Description::new(
                "number-too-large",
                format!("{found} is beyond the numbers that can be represented"),
                "give a smaller number",
            ),
            Self::NotPositive { found } => Description::new(
                "not-positive",
                format!("{found} is not greater than zero"),
                "give a number greater than zero",
            ),
            Self::Negative { found } => Description::new(
                "negative",
                format!("{found} is negative"),
                "give zero or a number greater than zero",
            ),
            Self::Zero => Description::new(
                "zero",
                "the value is 0",
                "give a value other than zero, or leave the key out where it is optional",
            ),
            Self::OutOfRange { found, range } => Description::new(
                "out-of-range",
                format!("{found} is out of range"),
                format!("give a value {range}"),
            ),
            _ => return None,
        })
    }

    /// Faults of the remaining values, and of overrides.
    fn describe_text(&self) -> Description {
        match self {
            Self::WrongType { expected, found } => Description::new(
                "wrong-type",
                format!("found {found}, expected {expected}"),
                wrong_type_remedy(expected, found),
            ),
            Self::WrongLength { expected, found } => Description::new(
                "wrong-length",
                format!("{found} values, expected {expected}"),
                "give as many values as expected; where a single number is the same for all \
                 joints, write it without brackets",
            ),
            Self::UnknownWord {
                noun,
                code,
                found,
                known,
            } => Description::new(
                code,
                format!("unknown {noun} \"{found}\""),
                unknown_word_remedy(found, known),
            ),
            Self::EmptyText => Description::new("empty-text", "the text is empty", "give a name"),
            Self::EmptyList => Description::new(
                "empty-list",
                "the list is empty",
                "give at least one value, or leave the key out",
            ),
            Self::NotAFolderName { found } => Description::new(
                "not-a-folder-name",
                format!("\"{found}\" cannot be the name of the results folder"),
                "use letters, digits, spaces, \"-\", \"_\" and \".\" only, not a dot alone",
            ),
            Self::OverrideForm { found } => Description::new(
                "override-form",
                format!("\"{found}\" is not of the form key=value"),
                "write it such as fit.estimator=wls",
            ),
            Self::OverrideValue { found, reason } => Description::new(
                "override-value",
                format!("{found} is not a TOML value: {reason}"),
                "correct the value; quote it for the shell where it has brackets or quotes",
            ),
            Self::OverrideBelowValue { parent, found } => Description::new(
                "override-below-value",
                format!("\"{parent}\" is {found}, which has no keys"),
                format!("set {parent} as a whole"),
            ),
            // The kinds of the other three lists are described there.
            _ => Description::new("fault", format!("{self:?}"), "correct the problem file"),
        }
    }
}

fn wrong_type_remedy(expected: &str, found: &str) -> String {
    match found {
        "a table" => {
            format!("give {expected}; a name with dots is a key only in quotes: \"joint1.Fc\"")
        }
        _ => format!("give {expected}"),
    }
}

fn unknown_key_remedy(key: &str, known: &[&str], elsewhere: Option<&str>) -> String {
    let elsewhere = elsewhere.map(|table| format!("\"{key}\" is a key of [{table}]; "));
    format!(
        "{}did you mean \"{}\"? known keys: {}",
        elsewhere.unwrap_or_default(),
        nearest(key, known.iter().copied()),
        known.join(", ")
    )
}

fn unknown_word_remedy(found: &str, known: &[String]) -> String {
    if known.is_empty() {
        return "leave the list empty".into();
    }
    format!(
        "did you mean \"{}\"? known: {}",
        nearest(found, known.iter().map(String::as_str)),
        known.join(", ")
    )
}

/// The candidate most like the word; the first of equals.
fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> &'a str {
    let mut best = ("", -1.0);
    for candidate in candidates {
        // Jaro-Winkler favours a common beginning, which is how names are cut short.
        let likeness = strsim::jaro_winkler(word, candidate);
        if likeness > best.1 {
            best = (candidate, likeness);
        }
    }
    best.0
}
