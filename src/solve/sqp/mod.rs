//! Sequential quadratic programming for min f(x) subject to g(x) = 0 or g(x) >= 0 row by row,
//! lower <= x <= upper, and constant rows l <= A x <= u that every iterate keeps.
//!
//! A step d minimises `½ dᵀB d + ∇fᵀd + ν Σ s` subject to `g + J d + s >= 0`, s >= 0 and the constant
//! rows (an elastic quadratic programme, solved by Clarabel's interior point method); B is a damped
//! BFGS estimate of the Lagrangian's Hessian (Powell 1978). The step is shortened until the exact
//! penalty `f + ν Σ max(0, −g)` falls (Han 1977; Nocedal and Wright 2006, algorithm 18.3). Only rows near
//! their bound enter the quadratic programme; those that its step violates are added and it is solved again.

use nalgebra::DVector;

use crate::problem::bounds;
use crate::problem::solution::{Control, Solution, Stop};
use crate::problem::view::Nlp;
use crate::solve::admissible_start;
use crate::solve::error::SolveError;
use crate::solve::sqp::iteration::Iteration;

mod hessian;
mod iteration;
mod quadratic;
mod settings;
mod working_set;

pub use crate::solve::sqp::settings::Settings;

#[cfg(test)]
mod tests;

/// A solution and what the constraints say of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Constrained {
    /// The point and why it is the last one.
    pub solution: Solution,
    /// Σ max(0, −g) over the rows of the problem at the solution; zero where it is feasible.
    pub infeasibility: f64,
}

/// Minimises from a start that keeps the constant rows (projected on the bounds first).
///
/// # Errors
/// A start of the wrong length or without a value; a setting out of range.
pub fn minimize(
    view: Nlp,
    start: &DVector<f64>,
    settings: &Settings,
    control: &Control,
) -> Result<Constrained, SolveError> {
    settings.validate()?;
    let form = view.problem().form();
    let x = admissible_start(form, start)?;
    let mut iteration = Iteration::at(view, x, settings)?;
    let started = std::time::Instant::now();
    let stop = loop {
        if control.is_interrupted() {
            break Stop::Interrupted;
        }
        if control.time_limit.is_some_and(|t| started.elapsed() >= t) {
            break Stop::TimeLimit;
        }
        if iteration.count() >= settings.max_iterations {
            break Stop::IterationLimit;
        }
        if let Some(stop) = iteration.advance(control)? {
            break stop;
        }
    };
    let end = iteration.finish();
    Ok(Constrained {
        infeasibility: end.infeasibility,
        solution: Solution {
            active_bounds: bounds::active(form, &end.x),
            x: end.x,
            cost: end.cost,
            stop,
            iterations: end.iterations,
            evaluations: end.evaluations,
            trace: end.trace,
        },
    })
}
