//! How the items of a fleet are worked on, and how many there are.

use crate::fleet::shard::Shard;
use crate::problem_file::ProblemFile;
use std::path::PathBuf;
use std::time::Duration;

/// Name of the table in the results folder.
pub const TABLE_FILE: &str = "summary.parquet";

/// How items are worked on.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The part of the manifest; all of it where absent.
    pub shard: Option<Shard>,
    /// Overrides of every problem.
    pub set: Vec<String>,
    /// At least one.
    pub threads: usize,
    /// Of one attempt at one item.
    pub timeout: Duration,
    /// Attempts beyond the first at what may go otherwise: time that is over, defects.
    pub retries: u32,
    /// Items that were set aside are tried again.
    pub again: bool,
    /// Rate of false discoveries.
    pub rate: f64,
    /// Rows of a recording beyond which it is refused.
    pub max_rows: Option<usize>,
    /// Files that a problem reads.
    pub inputs: fn(&ProblemFile) -> Vec<PathBuf>,
}

/// How many items there are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Items of the manifest, or of the part of it.
    pub items: u64,
    /// Worked on by this run.
    pub now: u64,
    /// Whose problem or recordings cannot be read; all others were done by earlier runs.
    pub unready: u64,
    /// Items of which there is no result.
    pub set_aside: u64,
}
