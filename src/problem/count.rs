//! The parts of a run that are done, counted for whoever waits for it.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// How far a run of many alike parts has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Done {
    /// Parts that are done.
    pub parts: usize,
    /// All of them.
    pub all: usize,
    /// Since the first began.
    pub elapsed: Duration,
}

/// Counts parts from any thread.
pub struct Count<'a> {
    told: Option<&'a (dyn Fn(&Done) + Sync)>,
    parts: AtomicUsize,
    all: usize,
    began: Instant,
}

impl<'a> Count<'a> {
    /// Of so many parts; `told` hears of each that is done where there are several.
    pub fn new(told: Option<&'a (dyn Fn(&Done) + Sync)>, all: usize) -> Self {
        Self {
            told: told.filter(|_| all > 1),
            parts: AtomicUsize::new(0),
            all,
            began: Instant::now(),
        }
    }

    /// One more is done.
    pub fn one(&self) {
        let parts = 1 + self.parts.fetch_add(1, Ordering::Relaxed);
        if let Some(told) = self.told {
            told(&Done {
                parts,
                all: self.all,
                elapsed: self.began.elapsed(),
            });
        }
    }
}
