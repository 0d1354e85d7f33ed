//! A primal-dual interior-point method for many small cones and dense least squares:
//!
//! ```text
//! minimise ½ ‖M x + b‖² + cᵀ x − Σ_k γ_k log det S_k(x)   subject to   S_k(x) = C_k + Σ_j x_j A_kj ⪰ 0
//! ```
//!
//! S_k symmetric of order one to four (order one: rows that are not negative, and bounds), γ_k >= 0. Optimal
//! where `Mᵀ(M x + b) + c = Σ A_kᵀ Z_k` and `S_k Z_k = γ_k·1`. Newton steps in the scaling of Nesterov and
//! Todd (1997) with Mehrotra's corrector (as in Vandenberghe 2010, "The CVXOPT linear and quadratic cone
//! program solvers"). Steps are least squares in coordinates in which `½ ‖M x + b‖²` is `½ ‖y‖²`, by QR: bodies of tonnes
//! at the edge of what is possible and a pull of 1e-6 have no digits in common in a normal matrix. Every answer is
//! strictly inside its cones, or misses them by less than the shortfall that is allowed: S follows from x.
//!
//! Z bounds the optimal cost from below by the least of the Lagrangian, which in these coordinates is `½ ‖its gradient‖²`
//! below its value: the gap is `Σ ⟨S_k, Z_k⟩` and that.

use crate::problem::bounds;
use crate::problem::solution::{Control, Solution, Stop, Trace, TraceRow};
use crate::problem::view::ConeProgram;
use crate::solve::error::{SolveError, SolveErrorKind};
use crate::solve::finite_model;
use crate::solve::interior::iterate::{Iterate, Run};
use crate::solve::interior::program::{Origin, Program};
use nalgebra::DVector;
use std::time::Instant;

mod block;
mod coordinates;
mod iterate;
mod newton;
mod program;
mod settings;
mod small;

pub use crate::solve::interior::program::Terms;
pub use crate::solve::interior::settings::Settings;

/// A solution with its certificate.
#[derive(Debug, Clone)]
pub struct InteriorSolution {
    /// Its cost is the problem's, without the added terms.
    pub solution: Solution,
    /// Bound on the cost above the optimum, in units of the cost.
    pub gap: f64,
    /// Largest |gradient − Σ A_kᵀ Z_k| of a variable, as a share of the slope at which a change that matters
    /// costs one unit: `‖M_j‖ sqrt(2 unit) + |c_j| + Σ_k ‖A_kj‖ (‖Z_k‖ + unit/‖S_k‖)`.
    pub stationarity: f64,
    /// svec of Z of every constraint, in the order of the rows of the form.
    pub multipliers: DVector<f64>,
}

/// Solves from a start, which may miss the constraints; steps are relative to it.
pub fn solve(
    view: ConeProgram,
    start: &DVector<f64>,
    settings: &Settings,
    terms: &Terms,
    control: &Control,
) -> Result<InteriorSolution, SolveError> {
    if !(settings.tolerance > 0.0 && settings.tolerance < 1.0) {
        let range = "0 < value < 1";
        let value = settings.tolerance;
        let kind = SolveErrorKind::Setting { value, range };
        return Err(SolveError::at("tolerance", kind));
    }
    let problem = view.problem();
    let form = problem.form();
    let (start, model) = finite_model(problem, start)?;
    let rows = model.constraints.len();
    let program = Program::new(form, &start, model, terms)?;
    let run = run(&program, settings, control)?;
    let x = bounds::project(form, &(&start + &run.step));
    let mut multipliers = DVector::zeros(rows);
    for (origin, z) in program.origins.iter().zip(&run.multipliers) {
        if let Origin::Rows(first) = origin {
            let z = &z[..z.len().min(rows - first)];
            multipliers.as_mut_slice()[*first..first + z.len()].copy_from_slice(z);
        }
    }
    let values = problem.values(&x)?;
    Ok(InteriorSolution {
        gap: run.measure.gap,
        stationarity: run.measure.stationarity,
        multipliers,
        solution: Solution {
            active_bounds: bounds::active(form, &x),
            x,
            cost: values.cost,
            stop: run.stop,
            iterations: run.trace.rows.len(),
            evaluations: 2,
            trace: run.trace,
        },
    })
}

/// Iterations over which a gap is halved where there is progress.
const PATIENCE: usize = 6;

fn stagnates(trace: &Trace, gap: f64) -> bool {
    let earlier = trace.rows.iter().rev().nth(PATIENCE - 1);
    earlier.is_some_and(|row| gap > 0.5 * row.regularization)
}

fn run(program: &Program, settings: &Settings, control: &Control) -> Result<Run, SolveError> {
    let begun = Instant::now();
    let mut iterate = Iterate::start(program, settings.shortfall)
        .ok_or_else(|| SolveError::whole(SolveErrorKind::ModelNotFinite))?;
    let mut trace = Trace::default();
    let stop = loop {
        let Some(measure) = iterate.measure() else {
            break Stop::Stalled;
        };
        if measure.is_optimal(settings.tolerance)
            || measure.is_optimal(settings.reduced_tolerance) && stagnates(&trace, measure.gap)
        {
            break Stop::Optimal;
        }
        if trace.rows.len() >= settings.max_iterations {
            break Stop::IterationLimit;
        }
        if control.is_interrupted() {
            break Stop::Interrupted;
        }
        if control
            .time_limit
            .is_some_and(|limit| begun.elapsed() >= limit)
        {
            break Stop::TimeLimit;
        }
        let Some(length) = iterate.advance() else {
            break Stop::Stalled;
        };
        let row = TraceRow {
            iteration: trace.rows.len() + 1,
            cost: measure.cost,
            step: length,
            stationarity: measure.stationarity,
            regularization: measure.gap,
        };
        control.report(&row);
        trace.rows.push(row);
    };
    Ok(iterate.finish(stop, trace, settings))
}

#[cfg(test)]
mod tests;
