//! Solvers of [`crate::problem`]. They know no robot: a view of a problem in, a solution out.

use nalgebra::DVector;

use crate::problem::bounds;
use crate::problem::form::Form;
use crate::problem::{Linearization, Problem};
use crate::solve::error::{SolveError, SolveErrorKind};

pub mod bounded;
pub mod error;
pub mod interior;
pub mod levenberg_marquardt;
pub mod linear;
pub mod sqp;

/// The start projected on the bounds, or what is wrong with it.
fn admissible_start(form: &Form, start: &DVector<f64>) -> Result<DVector<f64>, SolveError> {
    let (expected, found) = (form.variables.len(), start.len());
    if expected != found {
        return Err(SolveError::whole(SolveErrorKind::StartLength {
            expected,
            found,
        }));
    }
    for (variable, value) in form.variables.iter().zip(start.iter()) {
        if !value.is_finite() {
            let kind = SolveErrorKind::StartNotFinite { value: *value };
            return Err(SolveError::at(&variable.name, kind));
        }
    }
    Ok(bounds::project(form, start))
}

/// The admissible start and the first-order model there, or what is wrong with them.
fn finite_model(
    problem: &dyn Problem,
    start: &DVector<f64>,
) -> Result<(DVector<f64>, Linearization), SolveError> {
    let start = admissible_start(problem.form(), start)?;
    let model = problem.linearize(&start)?;
    let numbers = model.gradient.iter().chain(model.constraints.iter());
    if !numbers.chain(model.jacobian.iter()).all(|v| v.is_finite()) {
        return Err(SolveError::whole(SolveErrorKind::ModelNotFinite));
    }
    Ok((start, model))
}
