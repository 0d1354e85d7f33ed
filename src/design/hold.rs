//! A search whose result keeps torque and workspace limits between its samples too: where the dense grid shows a
//! violation, the limits are tightened by it and the motion is improved again.

use std::time::Instant;

use nalgebra::DVector;

use crate::design::problem::Experiment;
use crate::design::search::{Found, Improvement, Search, Settings};
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
const DRAWN_BACK: [f64; 6] = [0.999, 0.995, 0.99, 0.97, 0.94, 0.9];

/// A motion with the margins of all limits on the dense grid.
pub type Held = (Found, Vec<Margin>);

/// Runs the search and tightens until every limit holds on the dense grid.
///
/// # Errors
/// Those of the solver.
pub fn run(
    search: &Search<'_>,
    control: &Control,
    watch: impl Fn(&Improvement) + Sync,
) -> Result<Held, SolveError> {
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
    let mut found = first.run(control, watch)?;
    let mut margins = verify::margins(experiment, &found.x);
    let mut shrink = 1.0;
    for _ in 0..MOST_TIGHTENINGS {
        let violation = verify::violation(&margins);
        let left = budget.map(|b| b.saturating_sub(began.elapsed()));
        let out_of_time = left.is_some_and(|l| l.is_zero()) || control.is_interrupted();
        if violation <= TOLERATED || !found.is_feasible() || out_of_time {
            break;
        }
        shrink -= violation + ROOM;
        let tighter = Search { shrink, ..*search };
        let next = tighter.continued(&found.x, (control, left))?;
        margins = verify::margins(experiment, &next.x);
        found = Found {
            stop: found.stop,
            starts: found.starts,
            history: found.history,
            iterations: found.iterations + next.iterations,
            evaluations: found.evaluations + next.evaluations,
            ..next
        };
    }
    if found.is_feasible() && verify::violation(&margins) > TOLERATED {
        draw_back(experiment, (&mut found, &mut margins));
    }
    Ok((found, margins))
}

/// Smaller amplitudes about the same mean positions, until the limits hold.
fn draw_back(experiment: &Experiment<'_>, (found, margins): (&mut Found, &mut Vec<Margin>)) {
    let width = experiment.joints.series.width();
    for share in DRAWN_BACK {
        let scaled = |(k, value): (usize, &f64)| {
            if k % width == 0 {
                *value
            } else {
                share * value
            }
        };
        let x = DVector::from_iterator(found.x.len(), found.x.iter().enumerate().map(scaled));
        let all = verify::margins(experiment, &x);
        if verify::violation(&all) <= TOLERATED {
            found.value = experiment.value(&x);
            (found.x, *margins) = (x, all);
            return;
        }
    }
}
