//! Smooth corrections in the place of what has no name, chosen and tested by different rows.

use crate::diagnose::bench::Bench;
use crate::diagnose::benches::Benches;
use crate::diagnose::conclude;
use crate::diagnose::floor::Floor;
use crate::diagnose::refit::Refit;
use crate::diagnose::search::Rules;
use crate::diagnose::smooth::{self, Smooth};
use crate::outcome::diagnose::Finding;

/// Smooth corrections that one half of the held-out rows asks for, and the other half confirms.
pub struct Corrections {
    /// Over the rows that confirm them.
    confirmed: Vec<Smooth>,
    /// Number of those that were tested.
    tested: usize,
    /// The final model over the same rows.
    full: Refit,
}

impl Corrections {
    /// Of a model that a search has come to.
    pub fn of(benches: &Benches<'_>, full: &Refit, rules: Rules<'_>) -> Self {
        let mut wanted = smooth::of_all(&benches.selection, full);
        let tried = wanted.len();
        let choice = rules.of_choice().significance;
        wanted.retain(|smooth| conclude::is_needed(smooth, (choice, tried)));
        let tested = wanted.len();
        let full = full.on(&benches.test);
        let tests = wanted.iter().map(|s| s.on(&benches.test, &full));
        let is_confirmed = |test: &Smooth| {
            test.evidence.p_value * (tested as f64) < rules.significance && test.relief > 0.0
        };
        Self {
            confirmed: tests.filter(is_confirmed).collect(),
            tested,
            full,
        }
    }

    /// The same over the rows of another bench.
    pub fn on(&self, bench: &Bench<'_>, full: &Refit) -> Vec<Smooth> {
        let confirmed = self.confirmed.iter();
        confirmed.map(|smooth| smooth.on(bench, full)).collect()
    }

    /// What they stand for has no name.
    pub fn findings(&self, floor: &Floor, cut_short: bool) -> Vec<Finding> {
        let confirmed = self.confirmed.iter();
        confirmed
            .map(|test| conclude::unnamed(test, &self.full, floor, self.tested, cut_short))
            .collect()
    }
}
