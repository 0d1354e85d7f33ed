//! The task behind `exid fleet`: items, then the table and what changed.

use crate::fault::Place;
use crate::fleet::driver::Driver;
use crate::fleet::error::{FleetError, FleetErrorKind};
use crate::fleet::manifest::Manifest;
use crate::fleet::scratch::Scratch;
pub use crate::fleet::settings::{Counts, Settings, TABLE_FILE};
use crate::fleet::store::Store;
use crate::fleet::{summary, table};
use crate::outcome::fleet::Fleet;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A fleet whose items are done.
pub struct FinishedFleet {
    /// How many items were done and set aside.
    pub counts: Counts,
    /// Absent of a part of a manifest, and of a run that was interrupted.
    pub results: Option<Results>,
}

/// Sorted results of all items.
pub struct Results {
    scratch: Scratch,
    /// What is said of the fleet.
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

/// Works through a manifest; `on_progress` hears how far it is.
///
/// # Errors
/// Faults of the manifest, of the folder of items, or of the temporary database. Faults of items are results.
pub fn run(
    manifest: &Path,
    items: &Path,
    settings: &Settings,
    interrupt: Arc<AtomicBool>,
    on_progress: impl Fn(Counts),
) -> Result<FinishedFleet, FleetError> {
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
        on_progress(counts);
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
    Ok(FinishedFleet { counts, results })
}
