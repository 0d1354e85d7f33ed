//! The task behind `exid fleet`: items, then the table and what changed.

use crate::fault::Place;
use crate::fleet::driver::Driver;
use crate::fleet::error::{FleetError, FleetErrorKind};
use crate::fleet::manifest::Manifest;
use crate::fleet::scratch::Scratch;
use crate::fleet::shard::Shard;
use crate::fleet::store::Store;
use crate::fleet::{summary, table};
use crate::outcome::fleet::Fleet;
use crate::problem_file::ProblemFile;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
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
    pub items: u64,
    /// Worked on by this run; the others were done by earlier ones.
    pub now: u64,
    pub set_aside: u64,
}

/// A fleet whose items are done.
pub struct Ran {
    pub counts: Counts,
    /// Absent of a part of a manifest, and of a run that was interrupted.
    pub results: Option<Results>,
}

/// Sorted results of all items.
pub struct Results {
    scratch: Scratch,
    pub fleet: Fleet,
}

impl Results {
    /// Writes the table.
    ///
    /// # Errors
    /// The database or the file fails.
    pub fn write_table<W: Write + Send>(&self, out: W) -> Result<(), FleetError> {
        table::write(&self.scratch, out)
    }
}

/// Works through a manifest; `watch` hears how far it is.
///
/// # Errors
/// Faults of the manifest, of the folder of items, or of the temporary database. Faults of items are results.
pub fn run(
    manifest: &Path,
    items: &Path,
    settings: &Settings,
    interrupt: Arc<AtomicBool>,
    watch: impl Fn(Counts),
) -> Result<Ran, FleetError> {
    let opened = Manifest::open(manifest)?;
    let store = Store::open(items)?;
    let scratch = match settings.shard {
        Some(_) => None,
        None => Some(Scratch::new()?),
    };
    let driver = Driver {
        settings,
        store: &store,
        interrupt: Arc::clone(&interrupt),
    };
    let counts = driver.run(opened, |item, counts| {
        watch(counts);
        scratch
            .as_ref()
            .map_or(Ok(()), |scratch| scratch.add(&item))
    })?;
    let results = match scratch {
        Some(scratch) if !interrupt.load(Ordering::Relaxed) => {
            if counts.items == 0 {
                let place = Place::file(manifest);
                return Err(FleetError::new(place, FleetErrorKind::Empty));
            }
            let fleet = summary::summarise(&scratch, counts, settings.rate)?;
            Some(Results { scratch, fleet })
        }
        _ => None,
    };
    Ok(Ran { counts, results })
}
