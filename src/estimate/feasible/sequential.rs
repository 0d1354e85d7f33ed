//! Sequential conic programming: the residual is linearised at the last point (Gauss and Newton), the cones are kept as they are,
//! and the cost is searched along the way to the answer. Every point of the way is possible, as the cones are convex; and
//! where residuals are large the linearised cost has too little curvature and its answer lies too far. A damping
//! `λ ‖diag(R) (β − β_0)‖²` (Levenberg and Marquardt) shortens steps that the search finds nothing along. What the
//! linearised program still promises at the end is part of the gap.

use crate::estimate::error::EstimateError;
use crate::estimate::feasible::compressed;
use crate::estimate::feasible::solve::{self, Compressed, Feasible, Setting};
use crate::estimate::fit_problem::problem::FitProblem;
use crate::problem::Problem;
use crate::problem::form::Structure;
use crate::problem::solution::{Control, Stop};
use crate::solve::interior::InteriorSolution;
use crate::stats::range::within;
use nalgebra::DVector;

/// Steps end where the linearised program promises no more than 0.03 standard deviations of one unknown: the cost counts
/// residuals in units of their deviation, and ½ n² of it is n standard deviations.
const PROMISE: f64 = 0.5 * 0.03 * 0.03;

/// Least damping, and its factors after a step that was taken, or not.
const LEAST_DAMPING: f64 = 1e-8;
const LESS: f64 = 0.01;
const MORE: f64 = 100.0;
/// Damping that changes a promise by less than this share of the squares that a step moves.
const NEARLY_UNDAMPED: f64 = 1e-3;
/// Damping at which no step is left to take.
const LARGEST_DAMPING: f64 = 1e8;
/// Damping that keeps the nonlinear unknowns where they are.
const HOLDING: f64 = 1e4;

/// Points that are tried along a step, and the shares of one that the next may be.
const TRIALS: usize = 6;
const SHORTER: [f64; 2] = [0.1, 0.7];

const STEPS: usize = 100;

impl Compressed {
    /// The same with a damping towards base unknowns, from a column on.
    fn damped(&self, damping: f64, first: usize, at: &DVector<f64>) -> Self {
        let rows = self.matrix.nrows();
        let mut matrix = self.matrix.clone().resize_vertically(rows + at.len(), 0.0);
        let mut offset = self.offset.clone().resize_vertically(rows + at.len(), 0.0);
        for k in first..at.len() {
            let weight = damping.sqrt() * self.matrix.column(k).norm();
            matrix[(rows + k, k)] = weight;
            offset[rows + k] = -weight * at[k];
        }
        Self { offset, matrix }
    }
}

/// A point that a line search has tried.
struct Trial {
    point: DVector<f64>,
    cost: f64,
}

/// A step from one possible point to another.
struct LineSearch<'a> {
    from: &'a DVector<f64>,
    to: &'a DVector<f64>,
    /// Cost where it begins, and its slope there per whole step.
    least: f64,
    slope: f64,
}

impl LineSearch<'_> {
    fn point(&self, share: f64) -> DVector<f64> {
        self.from + (self.to - self.from) * share
    }

    /// The lowest point met: the end, then minima of the parabola through the last one. `None` where none is lower
    /// than the beginning.
    fn lowest(&self, cost: impl Fn(&DVector<f64>) -> f64) -> Option<Trial> {
        let mut best: Option<Trial> = None;
        let mut share = 1.0;
        for _ in 0..TRIALS {
            let point = self.point(share);
            let found = cost(&point);
            let bar = best.as_ref().map_or(self.least, |b| b.cost);
            if found < bar {
                best = Some(Trial { point, cost: found });
            } else if best.is_some() {
                break;
            }
            let curvature = found - self.least - self.slope * share;
            let next = -0.5 * self.slope * share.powi(2) / curvature;
            let [shortest, longest] = SHORTER.map(|s| s * share);
            if best.is_some() && !(curvature > 0.0 && next < longest) {
                break;
            }
            share = if next.is_finite() {
                within(next, [shortest, longest])
            } else {
                shortest
            };
        }
        best
    }
}

/// The feasible optimum for the weights of a problem, from base unknowns.
pub(super) fn minimise(
    setting: Setting<'_>,
    problem: &FitProblem<'_>,
    first: &DVector<f64>,
    control: &Control<'_>,
) -> Result<Feasible, EstimateError> {
    let model = compressed(problem, first)?;
    if problem.form().structure == Structure::Affine {
        return Ok(solve::estimate(setting, &model, control)?);
    }
    let is_free = model.least_squares();
    let is_free = is_free.is_some_and(|b| model.cost(first) - model.cost(&b) <= PROMISE);
    if is_free && let Some(inactive) = solve::inactive(setting, &model, first) {
        return Ok(inactive);
    }
    // The first point is possible: the answer of the linearised fit with the nonlinear unknowns where they are.
    let nonlinear = problem.unknowns.base.base.len();
    let held = model.damped(HOLDING, nonlinear, first);
    let best = solve::constrained(setting, setting.constraints, &held, control)?;
    let mut search = Search {
        setting,
        problem,
        least: f64::INFINITY,
        iterations: best.solution.iterations,
        best,
        damping: LEAST_DAMPING,
    };
    search.least = search.cost(&search.best.solution.x);
    let mut stop = None;
    for _ in 0..STEPS {
        stop = search.step(control)?;
        if stop.is_some() {
            break;
        }
    }
    let mut best = search.best;
    best.solution.iterations = search.iterations;
    best.solution.stop = stop.unwrap_or(Stop::IterationLimit);
    let at = &setting.standard.to_base * &best.solution.x;
    Ok(solve::active(setting, &compressed(problem, &at)?, best))
}

/// A search between two of its steps.
struct Search<'a> {
    setting: Setting<'a>,
    problem: &'a FitProblem<'a>,
    /// The best point, and its cost.
    best: InteriorSolution,
    least: f64,
    damping: f64,
    iterations: usize,
}

impl Search<'_> {
    fn cost(&self, x: &DVector<f64>) -> f64 {
        let base = &self.setting.standard.to_base * x;
        let values = self.problem.values(&base);
        values.map_or(f64::INFINITY, |v| v.cost) + solve::prior_cost(self.setting, x)
    }

    /// One conic step; why it was the last, if it was.
    fn step(&mut self, control: &Control<'_>) -> Result<Option<Stop>, EstimateError> {
        if control.is_interrupted() {
            return Ok(Some(Stop::Interrupted));
        }
        let setting = self.setting;
        let at = &setting.standard.to_base * &self.best.solution.x;
        let model = compressed(self.problem, &at)?;
        let damped = model.damped(self.damping, 0, &at);
        let mut tried = solve::constrained(setting, setting.constraints, &damped, control)?;
        self.iterations += tried.solution.iterations;
        let x = &tried.solution.x;
        let base = &setting.standard.to_base * x;
        let promise = self.least - model.cost(&base) - solve::prior_cost(setting, x);
        let line = LineSearch {
            from: &self.best.solution.x,
            to: x,
            least: self.least,
            slope: -promise - 0.5 * (&model.matrix * (&base - &at)).norm_squared(),
        };
        let is_near = promise <= PROMISE + tried.gap
            && tried.solution.stop.converged()
            && self.damping <= NEARLY_UNDAMPED;
        let gap = promise.max(0.0) + tried.gap;
        match line.lowest(|x| self.cost(x)) {
            Some(Trial { point, cost }) => {
                tried.solution.x = point;
                self.least = cost;
                self.best = tried;
                self.damping = (self.damping * LESS).max(LEAST_DAMPING);
            }
            None => self.damping *= MORE,
        }
        self.best.gap = gap;
        Ok(if is_near {
            Some(Stop::CostTolerance)
        } else {
            (self.damping > LARGEST_DAMPING).then_some(Stop::Stalled)
        })
    }
}
