//! Sequential conic steps: the residual is linearised at the last point (Gauss and Newton), the cones are
//! kept as they are, and a damping `λ ‖diag(R) (β − β_0)‖²` (Levenberg and Marquardt) keeps steps where the
//! linearisation holds. A step is taken only where the cost itself falls.

use crate::estimate::error::EstimateError;
use crate::estimate::feasible::compressed;
use crate::estimate::feasible::solve::{self, Compressed, Feasible, Setting};
use crate::estimate::problem::FitProblem;
use crate::problem::Problem;
use crate::problem::form::Structure;
use crate::problem::solution::{Control, Stop};
use nalgebra::{DMatrix, DVector};

/// Steps end when the cost falls by less than this share of it.
const COST_TOLERANCE: f64 = 1e-10;

/// First damping and its factors after a step that was taken, or not.
const FIRST_DAMPING: f64 = 1e-4;
const LESS: f64 = 0.1;
const MORE: f64 = 10.0;
/// Damping at which no step is left to take.
const LARGEST_DAMPING: f64 = 1e10;

const STEPS: usize = 100;

impl Compressed {
    /// The same with a damping towards base unknowns.
    fn damped(&self, damping: f64, at: &DVector<f64>) -> Self {
        let norms = self.matrix.column_iter().map(|c| damping.sqrt() * c.norm());
        let diagonal = DVector::from_iterator(at.len(), norms);
        let rows = self.matrix.nrows();
        let mut matrix = DMatrix::zeros(rows + at.len(), at.len());
        matrix.rows_mut(0, rows).copy_from(&self.matrix);
        for k in 0..at.len() {
            matrix[(rows + k, k)] = diagonal[k];
        }
        let pulled = -diagonal.component_mul(at);
        let offset = self.offset.iter().chain(pulled.iter()).copied();
        Self {
            offset: DVector::from_iterator(rows + at.len(), offset),
            matrix,
        }
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
    let cost = |x: &DVector<f64>| {
        let base = &setting.standard.to_base * x;
        let values = problem.values(&base).map_or(f64::INFINITY, |v| v.cost);
        values + solve::prior_cost(setting, x)
    };
    // The first point is possible: the answer of the linearised fit.
    let mut best = solve::estimate(setting, &model, control)?;
    let mut least = cost(&best.x);
    let mut damping = FIRST_DAMPING;
    let mut stop = Stop::IterationLimit;
    for _ in 0..STEPS {
        if control.is_interrupted() {
            stop = Stop::Interrupted;
            break;
        }
        let at = &setting.standard.to_base * &best.x;
        let model = compressed(problem, &at)?.damped(damping, &at);
        let tried = solve::estimate(setting, &model, control)?;
        let iterations = best.iterations + tried.iterations;
        let found = cost(&tried.x);
        if found < least {
            let fall = least - found;
            best = tried;
            least = found;
            damping *= LESS;
            if fall <= COST_TOLERANCE * least {
                stop = Stop::CostTolerance;
            }
        } else if found <= least * (1.0 + COST_TOLERANCE) {
            stop = Stop::CostTolerance;
        } else {
            damping *= MORE;
            if damping > LARGEST_DAMPING {
                stop = Stop::Stalled;
            }
        }
        best.iterations = iterations;
        if stop != Stop::IterationLimit {
            break;
        }
    }
    let at = &setting.standard.to_base * &best.x;
    let model = compressed(problem, &at)?;
    best.cost = model.cost(&at);
    best.unconstrained = model.least_squares().map_or(0.0, |b| model.cost(&b));
    best.stop = stop;
    Ok(best)
}
