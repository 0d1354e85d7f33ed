//! Works through a manifest on several threads, one item on each, and hands on what every item came to.
//!
//! Each thread has a pool of one for what is parallel within an item: a thread that waits for a part of one item would
//! otherwise begin another, and its time would count. Items and results pass one by one, so that memory does not grow with
//! the manifest.

use crate::fleet::attempt::{AttemptedItem, Looked, Running, Turn, Work, Worker};
use crate::fleet::error::FleetError;
use crate::fleet::item::{Item, ItemOutcome};
use crate::fleet::manifest::{Entry, Manifest};
use crate::fleet::settings::{Counts, Settings};
use crate::fleet::store::Store;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Results on their way for each thread: enough that none waits for the table.
const ON_THEIR_WAY: usize = 16;

/// How often the clock looks at the time of items: what a timeout may be late by.
const TICK: Duration = Duration::from_millis(20);

/// A fleet at work.
pub struct Driver<'a> {
    pub settings: &'a Settings,
    pub store: &'a Store<ItemOutcome>,
    pub interrupt: Arc<AtomicBool>,
}

/// When the item of a thread has to be done.
#[derive(Default)]
struct Clock {
    due: Mutex<Option<Instant>>,
    flag: Arc<AtomicBool>,
}

/// What threads share.
struct Shared<'a> {
    driver: &'a Driver<'a>,
    manifest: Mutex<Manifest>,
    folder: std::path::PathBuf,
    clocks: Vec<Clock>,
    later: Mutex<Vec<Entry>>,
    over: AtomicBool,
}

struct Sent {
    entry: Entry,
    worked: AttemptedItem,
}

/// Says that the run is over, however it ends.
struct Over<'a>(&'a AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A panic within an item is caught before it reaches a lock.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Counts what comes, and hands it on.
struct Tally<F> {
    counts: Counts,
    take: F,
}

impl<F: FnMut(Item, Counts) -> Result<(), FleetError>> Tally<F> {
    fn note(&mut self, sent: Sent) -> Result<(), FleetError> {
        self.counts.items += 1;
        self.counts.now += u64::from(sent.worked.work == Work::Now);
        self.counts.unready += u64::from(sent.worked.work == Work::Unready);
        self.counts.set_aside += u64::from(matches!(sent.worked.came_to, ItemOutcome::SetAside(_)));
        let item = Item {
            entry: sent.entry,
            came_to: sent.worked.came_to,
        };
        (self.take)(item, self.counts)
    }
}

impl Driver<'_> {
    /// Works on every item of the manifest, and gives `take` what each came to, in the order in which they are done.
    ///
    /// # Errors
    /// The first fault of the manifest or of the folder of items, or of `take`.
    pub fn run(
        &self,
        manifest: Manifest,
        take: impl FnMut(Item, Counts) -> Result<(), FleetError>,
    ) -> Result<Counts, FleetError> {
        let shared = Shared {
            driver: self,
            folder: manifest.folder().to_path_buf(),
            manifest: Mutex::new(manifest),
            clocks: (0..self.settings.threads)
                .map(|_| Clock::default())
                .collect(),
            later: Mutex::new(Vec::new()),
            over: AtomicBool::new(false),
        };
        let mut tally = Tally {
            counts: Counts::default(),
            take,
        };
        thread::scope(|scope| {
            scope.spawn(|| shared.watch());
            let _over = Over(&shared.over);
            self.drive(&shared, &mut tally)
        })?;
        Ok(tally.counts)
    }

    fn drive<F: FnMut(Item, Counts) -> Result<(), FleetError>>(
        &self,
        shared: &Shared<'_>,
        tally: &mut Tally<F>,
    ) -> Result<(), FleetError> {
        let (sender, receiver) = sync_channel(ON_THEIR_WAY * self.settings.threads);
        thread::scope(|scope| {
            for clock in &shared.clocks {
                let sender = sender.clone();
                scope.spawn(move || shared.work(clock, &sender));
            }
            drop(sender);
            for sent in receiver {
                let sent: Result<Sent, FleetError> = sent;
                let noted = sent.and_then(|sent| tally.note(sent));
                if noted.is_err() {
                    // The threads end with the items that they are at.
                    shared.over.store(true, Ordering::Relaxed);
                    return noted;
                }
            }
            Ok(())
        })?;
        let later = std::mem::take(&mut *locked(&shared.later));
        let pool = pool_of_one()?;
        for entry in later {
            if self.interrupt.load(Ordering::Relaxed) {
                break;
            }
            let clock = &shared.clocks[0];
            if let Some(sent) = pool.install(|| shared.look(clock, entry, Turn::Last))? {
                tally.note(sent)?;
            }
        }
        Ok(())
    }
}

/// Threads of its own for what is parallel within an item: one.
fn pool_of_one() -> Result<ThreadPool, FleetError> {
    let pool = ThreadPoolBuilder::new().num_threads(1).build();
    pool.map_err(|error| FleetError::not_sorted(&error))
}

impl Shared<'_> {
    /// Ends items whose time is over, and all of them when the run is interrupted.
    fn watch(&self) {
        while !self.over.load(Ordering::Relaxed) {
            let interrupted = self.driver.interrupt.load(Ordering::Relaxed);
            for clock in &self.clocks {
                let due = *locked(&clock.due);
                if interrupted || due.is_some_and(|due| Instant::now() >= due) {
                    clock.flag.store(true, Ordering::Relaxed);
                }
            }
            thread::sleep(TICK);
        }
    }

    /// Takes items from the manifest until there is none.
    fn work(&self, clock: &Clock, sender: &SyncSender<Result<Sent, FleetError>>) {
        let pool = match pool_of_one() {
            Ok(pool) => pool,
            Err(fault) => {
                // Nobody hears it where the run is over already.
                let _ = sender.send(Err(fault));
                return;
            }
        };
        let shard = self.driver.settings.shard;
        let is_ours = |entry: &Entry| shard.is_none_or(|shard| shard.holds(entry.position));
        while !self.over.load(Ordering::Relaxed) && !self.driver.interrupt.load(Ordering::Relaxed) {
            let Some(entry) = locked(&self.manifest).next() else {
                return;
            };
            let looked = match entry {
                Ok(entry) if !is_ours(&entry) => continue,
                Ok(entry) => pool.install(|| self.look(clock, entry, Turn::First)),
                Err(fault) => Err(fault),
            };
            let failed = looked.is_err();
            if let Some(result) = looked.transpose()
                && (sender.send(result).is_err() || failed)
            {
                return;
            }
        }
    }

    /// Looks at one item.
    fn look(&self, clock: &Clock, entry: Entry, turn: Turn) -> Result<Option<Sent>, FleetError> {
        let worker = Worker {
            settings: self.driver.settings,
            store: self.driver.store,
            folder: &self.folder,
            flag: Arc::clone(&clock.flag),
            interrupt: Arc::clone(&self.driver.interrupt),
        };
        let timeout = self.driver.settings.timeout;
        let running = |running: Running| {
            let mut due = locked(&clock.due);
            *due = match running {
                Running::Begins => Some(Instant::now() + timeout),
                Running::Ends => None,
            };
            clock.flag.store(false, Ordering::Relaxed);
        };
        match worker.look(&entry, turn, &running)? {
            Looked::AttemptedItem(worked) => Ok(Some(Sent { entry, worked })),
            Looked::Later => {
                locked(&self.later).push(entry);
                Ok(None)
            }
            Looked::Interrupted => Ok(None),
        }
    }
}
