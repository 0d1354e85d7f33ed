//! Inter-sample limits: where the dense grid shows that torque or workspace limits are violated between the samples of the
//! design, they are tightened by the violation and the motion is optimised again.

use std::time::Instant;

use crate::design::problem::Experiment;
use crate::design::search::multistart::{Improvement, Search, SearchResult, Settings};
use crate::design::verify::{self, Margin};
use crate::problem::solution::{Control, Stop};
use crate::solve::error::SolveError;

/// Violation between samples that is rounding, and the room that is added when limits are tightened.
const TOLERATED: f64 = 1e-9;
const ROOM: f64 = 2e-4;

/// Times that the limits of torque and workspace are tightened.
const MOST_TIGHTENINGS: usize = 8;

/// Share of a time limit that the search gets where limits may have to be tightened after it.
const SEARCHING: f64 = 0.85;

/// Shares of the amplitudes that are tried where tightening has not helped, or where no time was left for it.
const AMPLITUDE_SHARES: [f64; 15] = [
    0.9995, 0.999, 0.998, 0.995, 0.99, 0.97, 0.94, 0.9, 0.8, 0.65, 0.5, 0.35, 0.2, 0.1, 0.05,
];

/// Halvings of the step between the share that holds and the next larger one: to a hundredth of it.
const HALVINGS: usize = 6;

/// A motion with the margins of all limits on the dense grid.
#[derive(Debug, Clone)]
pub struct VerifiedMotion {
    /// The motion and how the search ended.
    pub found: SearchResult,
    /// The least of every limit.
    pub margins: Vec<Margin>,
    /// Share of the amplitudes that the search came to: below 1 where only smaller ones keep the limits.
    pub amplitude_share: f64,
}

impl VerifiedMotion {
    fn new(experiment: &Experiment<'_>, found: SearchResult) -> Self {
        let margins = verify::margins(experiment, &found.x);
        Self {
            found,
            margins,
            amplitude_share: 1.0,
        }
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
                stop: match before.stop {
                    Stop::CostTolerance => next.stop,
                    other => other,
                },
                starts: before.starts,
                history: before.history.clone(),
                iterations: before.iterations + next.iterations,
                evaluations: before.evaluations + next.evaluations,
                runners_up: before.runners_up.clone(),
                ..next
            },
        )
    }

    /// The same motion with smaller amplitudes about the same mean positions, where limits then hold: nearly the largest that do.
    fn scaled_down(&self, experiment: &Experiment<'_>) -> Option<Self> {
        let shares = &AMPLITUDE_SHARES;
        let holding = |share: f64| Some(self.scaled(experiment, share)).filter(Self::holds);
        let (k, mut best) = shares
            .iter()
            .enumerate()
            .find_map(|(k, &share)| Some((k, holding(share)?)))?;
        let mut fails = if k == 0 { 1.0 } else { shares[k - 1] };
        for _ in 0..HALVINGS {
            let middle = 0.5 * (fails + best.amplitude_share);
            match holding(middle) {
                Some(larger) => best = larger,
                None => fails = middle,
            }
        }
        Some(best)
    }

    fn scaled(&self, experiment: &Experiment<'_>, share: f64) -> Self {
        let width = experiment.joints.series.width();
        let mut x = self.found.x.clone();
        for k in (0..x.len()).filter(|k| k % width != 0) {
            x[k] *= share;
        }
        // No search came to the smaller motion.
        let stop = match self.found.stop {
            Stop::Infeasible | Stop::CostTolerance => Stop::IterationLimit,
            other => other,
        };
        let found = SearchResult {
            value: experiment.value(&x),
            x,
            stop,
            infeasibility: 0.0,
            ..self.found.clone()
        };
        Self {
            amplitude_share: share,
            ..Self::new(experiment, found)
        }
    }

    /// The best of the other motions of the search that keeps every limit on the dense grid.
    fn runner_up(&self, experiment: &Experiment<'_>) -> Option<Self> {
        self.found.runners_up.iter().find_map(|x| {
            let found = SearchResult {
                value: experiment.value(x),
                x: x.clone(),
                infeasibility: 0.0,
                ..self.found.clone()
            };
            Some(Self::new(experiment, found)).filter(Self::holds)
        })
    }

    /// This motion where it holds, or else the better of the same with smaller amplitudes and of the others that were found.
    fn or_one_that_holds(self, experiment: &Experiment<'_>) -> Self {
        if self.holds() {
            return self;
        }
        let others = [self.scaled_down(experiment), self.runner_up(experiment)];
        let others = others.into_iter().flatten();
        let best = others.min_by(|a, b| a.found.value.total_cmp(&b.found.value));
        best.unwrap_or(self)
    }
}

/// Runs the search and tightens until every limit holds on the dense grid. Of the motions on the way the one with the
/// least violation there is kept: a motion that misses a tightened limit may well keep the limit itself. Where none holds, as when
/// time ran out, smaller amplitudes or another motion that was found do.
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
        return Ok(best.or_one_that_holds(experiment));
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
    Ok(best.or_one_that_holds(experiment))
}
