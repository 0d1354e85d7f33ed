//! Inter-sample limits: where the dense grid shows that torque or workspace limits are violated between the samples of the
//! design, they are tightened by the violation and the motion is optimised again.

use std::time::Instant;

use nalgebra::DVector;

use crate::design::problem::Experiment;
use crate::design::search::multistart::{Improvement, Search, SearchResult, Settings};
use crate::design::verify::{self, Margin};
use crate::problem::solution::Control;
use crate::solve::error::SolveError;

/// Violation between samples that is rounding, and the room that is added when limits are tightened.
const TOLERATED: f64 = 1e-9;
const ROOM: f64 = 2e-4;

/// Times that the limits of torque and workspace are tightened.
const MOST_TIGHTENINGS: usize = 8;

/// Share of a time limit that the search gets where limits may have to be tightened after it.
const SEARCHING: f64 = 0.85;

/// Shares of the amplitudes that are tried where tightening has not helped.
const AMPLITUDE_SHARES: [f64; 8] = [0.9995, 0.999, 0.998, 0.995, 0.99, 0.97, 0.94, 0.9];

/// A motion with the margins of all limits on the dense grid.
#[derive(Debug, Clone)]
pub struct VerifiedMotion {
    /// The motion and how the search ended.
    pub found: SearchResult,
    /// The least of every limit.
    pub margins: Vec<Margin>,
}

impl VerifiedMotion {
    fn new(experiment: &Experiment<'_>, found: SearchResult) -> Self {
        let margins = verify::margins(experiment, &found.x);
        Self { found, margins }
    }

    /// Largest violation on the dense grid, as a share of its limit.
    pub fn violation(&self) -> f64 {
        verify::violation(&self.margins)
    }

    fn holds(&self) -> bool {
        self.violation() <= TOLERATED
    }

    /// The same search, ended at another motion.
    fn moved_to(&self, experiment: &Experiment<'_>, next: SearchResult) -> Self {
        let before = &self.found;
        Self::new(
            experiment,
            SearchResult {
                stop: before.stop,
                starts: before.starts,
                history: before.history.clone(),
                iterations: before.iterations + next.iterations,
                evaluations: before.evaluations + next.evaluations,
                ..next
            },
        )
    }

    /// The same motion with smaller amplitudes about the same mean positions, where limits then hold.
    fn scaled_down(&self, experiment: &Experiment<'_>) -> Option<Self> {
        let width = experiment.joints.series.width();
        AMPLITUDE_SHARES.iter().find_map(|share| {
            let scaled = |(k, value): (usize, &f64)| {
                if k % width == 0 {
                    *value
                } else {
                    share * value
                }
            };
            let (n, x) = (self.found.x.len(), &self.found.x);
            let x = DVector::from_iterator(n, x.iter().enumerate().map(scaled));
            let value = experiment.value(&x);
            let found = SearchResult {
                x,
                value,
                ..self.found.clone()
            };
            Some(Self::new(experiment, found)).filter(Self::holds)
        })
    }
}

/// Runs the search and tightens until every limit holds on the dense grid. Of the motions on the way the one with the
/// least violation there is kept: a motion that misses a tightened limit may well keep the limit itself.
///
/// # Errors
/// Those of the solver.
pub fn run(
    search: &Search<'_>,
    control: &Control,
    on_improvement: impl Fn(&Improvement) + Sync,
) -> Result<VerifiedMotion, SolveError> {
    let began = Instant::now();
    let experiment = search.experiment;
    let is_curved =
        !experiment.torques.limited.is_empty() || !experiment.workspace.rules.is_empty();
    let budget = search.settings.budget;
    let settings = Settings {
        budget: budget.map(|b| if is_curved { b.mul_f64(SEARCHING) } else { b }),
        ..search.settings.clone()
    };
    let first = Search {
        settings: &settings,
        ..*search
    };
    let mut current = VerifiedMotion::new(experiment, first.run(control, on_improvement)?);
    let mut best = current.clone();
    if !best.found.is_feasible() {
        return Ok(best);
    }
    let mut shrink = 1.0;
    for _ in 0..MOST_TIGHTENINGS {
        let left = budget.map(|b| b.saturating_sub(began.elapsed()));
        let out_of_time = left.is_some_and(|l| l.is_zero()) || control.is_interrupted();
        if best.holds() || out_of_time {
            break;
        }
        shrink -= current.violation() + ROOM;
        let tighter = Search { shrink, ..*search };
        let next = tighter.continued(&current.found.x, control, left)?;
        current = current.moved_to(experiment, next);
        if current.violation() < best.violation() {
            best = current.clone();
        }
    }
    if !best.holds() {
        best = best.scaled_down(experiment).unwrap_or(best);
    }
    Ok(best)
}
