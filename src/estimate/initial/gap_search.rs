//! Search for the gaps of gears with play.
//!
//! ```text
//! min over g of ½ ‖ r ‖²  or  min over g of Σ_c ln s_c²,   all else fitted beside g
//! ```
//!
//! with the weighted residual r, and the deviation s_c of that of channel c. A gap decides at which row a link strikes a
//! flank. Either has an optimum about every gap that brings strikes to other rows, and steps by derivatives end at the
//! nearest. So a gap is held at each value of its grid while some iterations fit all else, and the steps about the best
//! value are halved until strikes move by about a row. Which value looks best before it is quite right depends on the
//! weights: in the squares the largest torques count, in the likelihood every joint that is shaken. Where the noise of the
//! channels is not known, a search follows each, and the likelihood of what they come to decides.

use crate::chain::effect::Search;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::solve::least_squares::{covariance_at, solve};
use crate::problem::solution::{Control, Solution};
use nalgebra::DVector;
use rayon::prelude::*;

/// Iterations that fit all else beside every value of the grid, and beside the foremost of them.
const ITERATIONS: [usize; 2] = [8, 40];

/// The foremost values.
const FOREMOST: usize = 4;

/// Times that the steps about the best value are halved: strikes move by a row within them, and a search does not see past that.
pub const HALVINGS: usize = 2;

/// What says how well a gap does: the less, the better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// ½ ‖ r ‖².
    Squares,
    /// Σ ln s² over channels.
    Likelihood,
}

impl Measure {
    pub const ALL: [Self; 2] = [Self::Squares, Self::Likelihood];

    /// The measure of a solution.
    pub fn of(self, problem: &FitProblem<'_>, found: &Solution) -> f64 {
        match self {
            Self::Squares => found.cost,
            Self::Likelihood => {
                let variances = covariance_at(problem, &found.x).diagonal();
                let positive = variances.iter().filter(|v| **v > 0.0);
                positive.map(|v| v.ln()).sum()
            }
        }
    }
}

/// Whether a gap is among the unknowns.
pub fn is_needed(problem: &FitProblem<'_>) -> bool {
    (0..problem.unknowns.positions().len()).any(|unknown| grid(problem, unknown).is_some())
}

/// The unknowns with every gap at the best value of its grid and all else fitted beside it; as they are where no play is
/// searched for.
pub fn refined(
    problem: &FitProblem<'_>,
    x: DVector<f64>,
    measure: Measure,
    control: &Control<'_>,
) -> DVector<f64> {
    let quiet = Control {
        progress: None,
        parts: None,
        ..control.clone()
    };
    let gaps = (0..x.len()).filter_map(|gap| {
        let values = grid(problem, gap)?;
        let search = GapSearch {
            problem,
            gap,
            measure,
            control: &quiet,
        };
        Some((search, values))
    });
    gaps.fold(x, |x, (search, values)| search.best(x, values))
}

/// The values at which an unknown is tried; `None` of one that is no gap.
fn grid(problem: &FitProblem<'_>, unknown: usize) -> Option<&'static [f64]> {
    let position = problem.unknowns.positions()[unknown];
    match problem.model.effect_parameter(position)?.info.search {
        Search::Rising(values) => Some(values),
        _ => None,
    }
}

/// The search for one gap.
struct GapSearch<'a> {
    problem: &'a FitProblem<'a>,
    /// Which of the unknowns it is.
    gap: usize,
    measure: Measure,
    control: &'a Control<'a>,
}

/// All unknowns, fitted beside a gap that is held.
#[derive(Debug, Clone)]
struct Held {
    x: DVector<f64>,
    measured: f64,
}

impl GapSearch<'_> {
    fn best(&self, x: DVector<f64>, values: &[f64]) -> DVector<f64> {
        let [few, many] = ITERATIONS;
        let all = values.iter().copied().chain([x[self.gap]]);
        let mut tried = self.fitted(all.map(|gap| self.with(&x, gap)).collect(), few);
        best_first(&mut tried);
        let foremost = tried.drain(..FOREMOST.min(tried.len())).map(|one| one.x);
        let foremost = foremost.collect();
        tried.extend(self.fitted(foremost, many));
        for _ in 0..HALVINGS {
            best_first(&mut tried);
            tried.extend(self.fitted(self.beside_best(&tried), many));
        }
        best_first(&mut tried);
        tried.into_iter().next().map_or(x, |best| best.x)
    }

    fn with(&self, x: &DVector<f64>, gap: f64) -> DVector<f64> {
        let mut moved = x.clone();
        moved[self.gap] = gap;
        moved
    }

    /// The best of what was tried, which comes first, with gaps half the way to those next to its own.
    fn beside_best(&self, tried: &[Held]) -> Vec<DVector<f64>> {
        let Some((best, others)) = tried.split_first() else {
            return Vec::new();
        };
        let others: Vec<f64> = others.iter().map(|other| other.x[self.gap]).collect();
        let halfway = halfway(best.x[self.gap], &others).into_iter();
        halfway.map(|gap| self.with(&best.x, gap)).collect()
    }

    /// What fits best beside the gap of each start after some iterations, of those within limits for which there is such a fit.
    fn fitted(&self, starts: Vec<DVector<f64>>, iterations: usize) -> Vec<Held> {
        let fitted = starts
            .into_par_iter()
            .filter_map(|x| self.beside(x, iterations));
        fitted.collect()
    }

    fn beside(&self, mut x: DVector<f64>, iterations: usize) -> Option<Held> {
        let unknowns = &self.problem.unknowns;
        let position = unknowns.positions()[self.gap];
        let mut model = self.problem.model.clone();
        if !model.parameters()[position].is_within_limits(x[self.gap]) {
            return None;
        }
        model.start(position, x[self.gap]);
        let others = unknowns.without(&[self.gap]);
        let held = self.problem.with_unknowns(&model, &others);
        let start = x.clone().remove_row(self.gap);
        let found = solve(&held, &start, iterations, self.control).ok()?;
        let measured = self.measure.of(&held, &found);
        let rows = (0..x.len()).filter(|row| *row != self.gap);
        rows.zip(found.x.iter())
            .for_each(|(row, value)| x[row] = *value);
        Some(Held { x, measured })
    }
}

fn best_first(tried: &mut [Held]) {
    tried.sort_by(|a, b| a.measured.total_cmp(&b.measured));
}

/// Half the ways from the best of some values to the nearest of the others below and above it.
pub fn halfway(best: f64, others: &[f64]) -> Vec<f64> {
    let below = others.iter().copied().filter(|x| *x < best);
    let above = others.iter().copied().filter(|x| *x > best);
    let nearest = [below.max_by(f64::total_cmp), above.min_by(f64::total_cmp)];
    let nearest = nearest.into_iter().flatten();
    nearest.map(|x| best + 0.5 * (x - best)).collect()
}
