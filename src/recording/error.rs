//! What can be wrong with a recording: its file, its table, its channels, its time base, or what is
//! asked of it.

use std::fmt;

use crate::fault::{Description, Fault, Place, write_fault};
use crate::recording::row_faults::{SharedRows, describe_held_apart};

/// A fault of a recording, with the file, line and column or channel where it lies.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingError {
    /// File, and line, column or channel where they are known.
    pub place: Place,
    /// What is wrong there.
    pub kind: RecordingErrorKind,
}

/// The kinds of fault, each with what was found.
#[derive(Debug, Clone, PartialEq)]
pub enum RecordingErrorKind {
    /// No file has the path.
    NotFound,
    /// The path is a folder's.
    IsDirectory,
    /// The path is that of a pipe or a device, of which every byte is read once.
    IsPipe,
    /// The operating system refuses to read the file.
    NoPermission,
    /// Reading fails in the middle.
    Unreadable {
        /// What the system says.
        reason: String,
    },
    /// The file's name ends like no known format.
    UnknownExtension {
        /// What the name ends in.
        found: String,
        /// The extensions that are known.
        known: &'static str,
    },
    /// Compressed data end before their end mark.
    TruncatedGzip,
    /// Compressed data are damaged, or no gzip.
    CorruptGzip {
        /// What the unpacker says.
        reason: String,
    },
    /// A binary format is damaged, or the file is another format.
    Corrupt {
        /// The format that the name promises, in words.
        format: &'static str,
        /// What its reader says.
        reason: Box<str>,
    },
    /// A valid file that uses something of its format that is not read.
    Unsupported {
        /// What it uses.
        what: Box<str>,
        /// What to do instead.
        remedy: &'static str,
    },
    /// Channels of one recording differ in length.
    UnequalLengths {
        /// Samples of this one.
        found: usize,
        /// Name of the first channel.
        other: Box<str>,
        /// Samples of that one.
        expected: usize,
    },
    /// A bag without joint states.
    NoJointState {
        /// Types of the messages that it has.
        present: Vec<String>,
    },
    /// A joint state that cannot be used.
    BadMessage {
        /// What is wrong with it.
        reason: String,
    },
    /// Columns that were asked for come from topics without common samples.
    TwoTopics {
        /// Names of the topics.
        topics: Vec<String>,
    },
    /// Reading was interrupted.
    Interrupted,
    /// More rows than may be read.
    TooManyRows {
        /// The most rows.
        most: usize,
    },
    /// More bytes, unpacked, than may be read.
    TooManyBytes {
        /// The most bytes.
        most: u64,
    },
    /// There is nothing in the file.
    EmptyFile,
    /// The first line is numbers where names of columns are needed.
    NoHeader,
    /// A text with a NUL byte is binary, or was cut off.
    NulByte,
    /// A line longer than any row of numbers.
    LineTooLong {
        /// The longest line that is read, bytes.
        limit: usize,
    },
    /// Two columns have one name.
    DuplicateColumn {
        /// The name.
        name: String,
    },
    /// A row has another number of fields than the header.
    WrongFieldCount {
        /// Fields of the row.
        found: usize,
        /// Fields of the header.
        expected: usize,
    },
    /// A cell is no number.
    NotANumber {
        /// What stands there, cut to a few characters.
        found: String,
    },
    /// A number is infinite, or so large that its products are.
    NotFinite {
        /// As written.
        found: String,
    },
    /// Too few samples to differentiate.
    TooFewRows {
        /// Rows of the table.
        found: usize,
        /// Rows at least.
        least: usize,
    },
    /// A column whose cells are all empty.
    EmptyColumn {
        /// Rows of the table.
        rows: usize,
    },
    /// Rows that lack a value, and cells that the worst column lacks.
    TooManyMissing {
        /// Rows that lack a value.
        rows: usize,
        /// Rows of the table.
        of: usize,
        /// Cells that the worst column lacks.
        cells: usize,
    },
    /// A channel has no column.
    MissingColumn(Box<MissingColumn>),
    /// One column is named for two channels.
    ColumnUsedTwice {
        /// Name of the column.
        name: String,
    },
    /// A pattern names the same column for every joint.
    PatternNotPerJoint {
        /// As the problem has it, with its placeholders.
        pattern: String,
        /// Joints of the robot.
        joints: usize,
    },
    /// A list has not one column per joint.
    TooFewColumns {
        /// Columns of the list.
        given: usize,
        /// Joints of the robot.
        joints: usize,
    },
    /// A pattern has something in braces that stands for nothing.
    UnknownPlaceholder {
        /// As written, with its braces.
        found: String,
    },
    /// A time stamp does not come after the one before.
    TimeNotIncreasing {
        /// The stamp before, s.
        before: f64,
        /// The stamp at fault, s.
        found: f64,
    },
    /// More samples are missing than straight lines may bridge.
    GapTooLong {
        /// The gap in the stamps, s.
        seconds: f64,
    },
    /// Neither stamps nor a rate.
    NoTimeBase,
    /// A file that is to be joined with others has no time stamps.
    JoinWithoutTime,
    /// Stamps of a date beside stamps that say no date.
    ClocksDiffer,
    /// Files that are to be joined, one from when to when, and the others, s.
    NoCommonTime {
        /// First and last stamp of this file, s.
        span: [f64; 2],
        /// First and last stamp that the files before it have in common, s.
        others: [f64; 2],
    },
    /// The rate that is given is not that of the stamps.
    RateContradictsTime {
        /// Hz.
        given: f64,
        /// Rate of the stamps, Hz.
        found: f64,
    },
    /// A setting is out of its range.
    InvalidSetting {
        /// What was given.
        value: f64,
        /// What it must be, in words.
        requirement: String,
    },
    /// The recording ends before its motion can repeat.
    ShorterThanPeriod {
        /// Its length, s.
        duration: f64,
        /// The period that is given, s.
        period: f64,
    },
    /// A Fourier series is asked for, and the motion has no period.
    FourierWithoutPeriod,
    /// The filter's edges take all samples.
    TooShortForFilter {
        /// Samples of the recording.
        samples: usize,
        /// Samples that it would need.
        least: usize,
    },
    /// The mask leaves too few samples.
    NothingUnmasked,
    /// Rows that are those of another recording of the same problem.
    SharedRows(Box<SharedRows>),
    /// Channels that repeat samples of different instants, each so many times.
    HeldApart {
        /// Rows of the file per sample of either channel.
        factors: [f64; 2],
    },
    /// A recorded position at which the loops of the mechanism stay open, or are not held.
    NoMotion {
        /// What the mechanism says.
        reason: String,
    },
}

impl RecordingErrorKind {
    /// Whether what is asked of the recording is at fault, whatever the recording holds.
    pub fn concerns_request(&self) -> bool {
        matches!(
            self,
            Self::ColumnUsedTwice { .. }
                | Self::PatternNotPerJoint { .. }
                | Self::TooFewColumns { .. }
                | Self::TwoTopics { .. }
                | Self::UnknownPlaceholder { .. }
                | Self::InvalidSetting { .. }
                | Self::FourierWithoutPeriod
        )
    }
}

/// A column that is needed and absent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingColumn {
    /// What the column would hold, e.g. `position of joint a2`.
    pub purpose: String,
    /// The names that would be accepted, the most usual one first.
    pub accepted: Vec<String>,
    /// The present column whose name is nearest to the first accepted one.
    pub nearest: Option<String>,
    /// Names of all columns of the file.
    pub present: Vec<String>,
}

/// Column names listed in a message: more than this would hide the sentence.
const LISTED_NAMES: usize = 40;

/// Characters of a wrong field that are shown.
const SHOWN_CHARACTERS: usize = 40;

impl RecordingError {
    pub(super) fn new(place: Place, kind: RecordingErrorKind) -> Self {
        Self { place, kind }
    }
}

/// The start of a text, as much as belongs in a message.
pub(super) fn excerpt(text: &str) -> String {
    let mut shown: String = text.chars().take(SHOWN_CHARACTERS).collect();
    if shown.len() < text.len() {
        shown.push_str("...");
    }
    shown
}

fn list(names: &[String]) -> String {
    let mut shown = names[..names.len().min(LISTED_NAMES)].join(", ");
    if names.len() > LISTED_NAMES {
        shown.push_str(&format!(", and {} more", names.len() - LISTED_NAMES));
    }
    shown
}

impl fmt::Display for RecordingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_fault(f, self)
    }
}

impl std::error::Error for RecordingError {}

impl Fault for RecordingError {
    fn place(&self) -> &Place {
        &self.place
    }

    fn describe(&self) -> Description {
        describe_file(&self.kind)
            .or_else(|| describe_content(&self.kind))
            .or_else(|| describe_table(&self.kind))
            .or_else(|| describe_time(&self.kind))
            .unwrap_or_else(|| describe_use(&self.kind))
    }
}

fn describe_file(kind: &RecordingErrorKind) -> Option<Description> {
    use RecordingErrorKind as Kind;
    let words = match kind {
        Kind::NotFound => Description::new(
            "recording-not-found",
            "there is no such file",
            "check the path; paths of a problem file are relative to that file",
        ),
        Kind::IsDirectory => Description::new(
            "recording-is-directory",
            "this is a directory",
            "name a recording inside it",
        ),
        Kind::IsPipe => Description::new(
            "recording-is-pipe",
            "this is a pipe or a device, which gives every byte once, and recordings are read more than once",
            "write what it gives to a file and name that",
        ),
        Kind::NoPermission => Description::new(
            "recording-no-permission",
            "the file may not be read",
            "give the reading user permission",
        ),
        Kind::Unreadable { reason } => Description::new(
            "recording-unreadable",
            format!("reading fails: {reason}"),
            "check the medium and copy the file again",
        ),
        Kind::UnknownExtension { found, known } => Description::new(
            "unknown-extension",
            format!("the extension {found:?} is not that of a known recording format"),
            format!("convert the recording to one of {known}"),
        ),
        Kind::Interrupted => {
            Description::new("interrupted", "reading was interrupted", "run it again")
        }
        Kind::TooManyRows { most } => Description::new(
            "too-many-rows",
            format!("the file has more than {most} rows"),
            "cut it into recordings, or raise the limit with --max-rows",
        ),
        Kind::TooManyBytes { most } => Description::new(
            "too-many-bytes",
            format!("the file has more than {most} bytes, unpacked"),
            "cut it into recordings, or check that it is what its name says",
        ),
        Kind::TruncatedGzip => Description::new(
            "truncated-gzip",
            "the compressed data end before their end mark",
            "copy or compress the file again",
        ),
        Kind::CorruptGzip { reason } => Description::new(
            "corrupt-gzip",
            format!("the file is not a valid gzip file: {reason}"),
            "compress it again, or drop .gz from its name if it is plain text",
        ),
        _ => return None,
    };
    Some(words)
}

/// Faults of the formats that are not text.
fn describe_content(kind: &RecordingErrorKind) -> Option<Description> {
    use RecordingErrorKind as Kind;
    let words = match kind {
        Kind::Corrupt { format, reason } => Description::new(
            "corrupt-file",
            format!("this is not a valid {format}: {reason}"),
            "export or copy the recording again, and check that its extension is right",
        ),
        Kind::Unsupported { what, remedy } => {
            Description::new("unsupported-content", what.as_ref(), *remedy)
        }
        Kind::UnequalLengths {
            found,
            other,
            expected,
        } => Description::new(
            "unequal-lengths",
            format!("it has {found} samples and {other} has {expected}"),
            "store all channels with the same number of samples",
        ),
        Kind::NoJointState { present } => Description::new(
            "no-joint-state",
            "the bag holds no message of type sensor_msgs/JointState",
            match present.is_empty() {
                true => "record the topic of the joint states; the bag is empty".to_string(),
                false => format!(
                    "record the topic of the joint states; the bag holds {}",
                    list(present)
                ),
            },
        ),
        Kind::BadMessage { reason } => Description::new(
            "bad-message",
            format!("the joint state with this number cannot be used: {reason}"),
            "record the bag again, with all joints in one message",
        ),
        Kind::TwoTopics { topics } => Description::new(
            "two-topics",
            format!(
                "columns of the topics {} have no common samples",
                topics.join(" and ")
            ),
            "name columns of one topic under [recordings.columns]",
        ),
        _ => return None,
    };
    Some(words)
}

fn describe_table(kind: &RecordingErrorKind) -> Option<Description> {
    use RecordingErrorKind as Kind;
    let words = match kind {
        Kind::EmptyFile => Description::new(
            "empty-file",
            "the file is empty",
            "give a header line with column names and at least 20 rows",
        ),
        Kind::NoHeader => Description::new(
            "no-header",
            "the first line holds numbers, not column names",
            "put a line with the name of every column first, such as t,q1,q2,i1,i2, or say where columns stand: \
             recordings.columns.position = { column = [2, 3] }",
        ),
        Kind::NulByte => Description::new(
            "nul-byte",
            "the line holds a NUL byte: the file is binary, or was cut off while written",
            "export the recording again, as text in UTF-8, or in UTF-16 with a byte-order mark",
        ),
        Kind::LineTooLong { limit } => Description::new(
            "line-too-long",
            format!("the line is longer than {limit} bytes: this is not a table of numbers"),
            "check that the file is what its name says",
        ),
        Kind::DuplicateColumn { name } => Description::new(
            "duplicate-column",
            format!("two columns are named {name:?}"),
            "give every column its own name",
        ),
        Kind::WrongFieldCount { found, expected } => Description::new(
            "wrong-field-count",
            format!("the row has {found} fields and the header {expected}"),
            "complete the row or remove it",
        ),
        Kind::NotANumber { found } => Description::new(
            "not-a-number",
            format!("{found:?} is not a number"),
            "write numbers with a decimal point, or dates as 2026-01-31T10:00:00.5, or remove the row",
        ),
        Kind::NotFinite { found } => Description::new(
            "not-finite",
            format!("the value is {found}"),
            "leave the cell empty, and the row is left out",
        ),
        Kind::EmptyColumn { rows } => Description::new(
            "empty-column",
            format!("none of its {rows} rows has a number"),
            "name another column under [recordings.columns], or leave the channel out where it may be absent",
        ),
        Kind::TooManyMissing { rows, of, cells } => Description::new(
            "too-many-missing",
            format!(
                "{rows} of {of} rows lack a value, this column alone {cells}: more would be invented than was measured"
            ),
            "record or export every channel in every row; where channels come at different instants, give them as files \
             of their own (recordings.train = [{ files = [...] }]) and exid joins them by time",
        ),
        Kind::TooFewRows { found, least } => Description::new(
            "too-few-rows",
            format!("the table has {found} rows"),
            format!("record at least {least} samples"),
        ),
        Kind::MissingColumn(missing) => describe_missing(missing),
        _ => return None,
    };
    Some(words)
}

fn describe_missing(missing: &MissingColumn) -> Description {
    let first = missing.accepted.first().map_or("", String::as_str);
    let accepted = match missing.accepted.len() {
        0 | 1 => format!("column {first:?}"),
        _ => format!("column (any of {})", missing.accepted.join(", ")),
    };
    let nearest = match &missing.nearest {
        Some(name) => format!("did you mean {name:?}? "),
        None => String::new(),
    };
    Description::new(
        "missing-column",
        format!("there is no {accepted} for the {}", missing.purpose),
        format!(
            "{nearest}name it under [recordings.columns]; present are {}",
            list(&missing.present)
        ),
    )
}

fn describe_time(kind: &RecordingErrorKind) -> Option<Description> {
    use RecordingErrorKind as Kind;
    let words = match kind {
        Kind::TimeNotIncreasing { before, found } => Description::new(
            "time-not-increasing",
            format!("the time stamp {found} s does not come after {before} s"),
            "sort or remove the rows, or leave the time column out and give a rate",
        ),
        Kind::GapTooLong { seconds } => Description::new(
            "gap-too-long",
            format!(
                "before this sample {seconds} s are missing, and more samples in all than there are"
            ),
            "split the recording at its gaps, or check the time column",
        ),
        Kind::NoTimeBase => Description::new(
            "no-time-base",
            "there is neither a time column nor a rate",
            "give recordings.rate in Hz, or name the time column",
        ),
        Kind::JoinWithoutTime => Description::new(
            "join-without-time",
            "files are joined by time, and this one has no time column",
            "name its time column: { file = ..., columns = { time = ... } }",
        ),
        Kind::ClocksDiffer => Description::new(
            "clocks-differ",
            "its stamps and those of the first file do not count from one instant: one has dates, the other seconds",
            "give all files stamps of one clock",
        ),
        Kind::NoCommonTime { span, others } => Description::new(
            "no-common-time",
            format!(
                "it lasts from {:.4} to {:.4} s, and the files before it from {:.4} to {:.4} s: they have no common time",
                span[0], span[1], others[0], others[1]
            ),
            "give all files stamps of one clock, in their units (columns = { time = { column = ..., unit = \"ms\" } })",
        ),
        Kind::RateContradictsTime { given, found } => Description::new(
            "rate-contradicts-time",
            format!("the time stamps give {found:.6} Hz and the rate given is {given} Hz"),
            "remove the rate, or check that time is in seconds",
        ),
        _ => return None,
    };
    Some(words)
}

fn describe_use(kind: &RecordingErrorKind) -> Description {
    use RecordingErrorKind as Kind;
    match kind {
        Kind::PatternNotPerJoint { pattern, joints } => Description::new(
            "pattern-not-per-joint",
            format!("the pattern {pattern:?} names one column for {joints} joints"),
            "put {joint} (the joint's name) or {n} (its number from 1) into it",
        ),
        Kind::TooFewColumns { given, joints } => Description::new(
            "too-few-columns",
            format!("the list has {given} of the columns of {joints} joints"),
            "list one column for each joint, in the order of the problem's joints",
        ),
        Kind::ColumnUsedTwice { name } => Description::new(
            "column-used-twice",
            format!("column {name:?} is asked for in two roles"),
            "name another column for one of them under [recordings.columns]",
        ),
        Kind::UnknownPlaceholder { found } => Description::new(
            "unknown-placeholder",
            format!("the pattern has the placeholder {found}"),
            "use {joint} (the joint's name) or {n} (its number from 1)",
        ),
        Kind::InvalidSetting { value, requirement } => Description::new(
            "invalid-setting",
            format!("the value is {value}"),
            format!("it must be {requirement}"),
        ),
        Kind::ShorterThanPeriod { duration, period } => Description::new(
            "shorter-than-period",
            format!("the recording lasts {duration:.4} s, less than one period of {period} s"),
            "record at least one whole period, or remove the period",
        ),
        Kind::FourierWithoutPeriod => Description::new(
            "fourier-without-period",
            "no period is given for the Fourier series, and the motion does not repeat",
            "give recordings.period, or use the method \"lowpass\"",
        ),
        Kind::TooShortForFilter { samples, least } => Description::new(
            "too-short-for-filter",
            format!("{samples} samples leave nothing between the edges of the filter"),
            format!("record at least {least} samples, or raise the cut-off"),
        ),
        Kind::NoMotion { reason } => Description::new(
            "no-motion",
            reason.as_str(),
            "check the order, units, signs and zero of the recorded positions against the mechanism",
        ),
        Kind::SharedRows(shared) => shared.describe(),
        Kind::HeldApart { factors } => describe_held_apart(*factors),
        _ => Description::new(
            "nothing-unmasked",
            "the mask leaves out too many samples",
            "check the mask column: samples with 0 are left out, all others kept",
        ),
    }
}
