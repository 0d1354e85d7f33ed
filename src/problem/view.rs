//! Views of a problem: what a solver needs of it, checked once with an error written for people.

use crate::problem::Problem;
use crate::problem::error::{ProblemError, ProblemErrorKind};
use crate::problem::form::{Objective, Set, Structure};
use crate::problem::linear_rows::LinearRows;

/// Minimise 1/2 |r(x)|^2 subject to lower <= x <= upper.
#[derive(Clone, Copy)]
pub struct LeastSquares<'a> {
    problem: &'a dyn Problem,
}

/// Minimise f(x) subject to g_i(x) = 0, g_j(x) >= 0 and lower <= x <= upper; and, where given, to
/// constant rows that every iterate keeps.
#[derive(Clone, Copy)]
pub struct Nlp<'a> {
    problem: &'a dyn Problem,
    rows: Option<&'a LinearRows>,
}

/// Minimise 1/2 |A x + b|^2 or cᵀx subject to G x + h in K and lower <= x <= upper.
#[derive(Clone, Copy)]
pub struct ConeProgram<'a> {
    problem: &'a dyn Problem,
}

impl<'a> LeastSquares<'a> {
    /// The problem, which has passed the check of this view.
    pub fn problem(&self) -> &'a dyn Problem {
        self.problem
    }
}

impl<'a> Nlp<'a> {
    /// The problem, which has passed the check of this view.
    pub fn problem(&self) -> &'a dyn Problem {
        self.problem
    }

    /// The same problem within constant rows.
    pub fn within(self, rows: &'a LinearRows) -> Self {
        Self {
            rows: Some(rows),
            ..self
        }
    }

    /// The constant rows, if there are any.
    pub fn rows(&self) -> Option<&'a LinearRows> {
        self.rows
    }
}

impl<'a> ConeProgram<'a> {
    /// The problem, which has passed the check of this view.
    pub fn problem(&self) -> &'a dyn Problem {
        self.problem
    }
}

impl<'a> TryFrom<&'a dyn Problem> for LeastSquares<'a> {
    type Error = ProblemError;

    fn try_from(problem: &'a dyn Problem) -> Result<Self, ProblemError> {
        let view = "least squares";
        let form = problem.form();
        form.validate()?;
        if !matches!(form.objective, Objective::SumOfSquares { .. }) {
            return Err(ProblemError::whole(ProblemErrorKind::NotSumOfSquares {
                view,
            }));
        }
        match form.constraints.first() {
            Some(first) => Err(ProblemError::at(
                &first.name,
                ProblemErrorKind::Constrained {
                    view,
                    constraints: form.constraints.len(),
                },
            )),
            None => Ok(Self { problem }),
        }
    }
}

impl<'a> TryFrom<&'a dyn Problem> for Nlp<'a> {
    type Error = ProblemError;

    fn try_from(problem: &'a dyn Problem) -> Result<Self, ProblemError> {
        let view = "nonlinear programming";
        let form = problem.form();
        form.validate()?;
        let is_cone = |set: &Set| matches!(set, Set::Psd { .. });
        match form.constraints.iter().find(|c| is_cone(&c.set)) {
            Some(cone) => Err(ProblemError::at(
                &cone.name,
                ProblemErrorKind::HasCone { view },
            )),
            None => Ok(Self {
                problem,
                rows: None,
            }),
        }
    }
}

impl<'a> TryFrom<&'a dyn Problem> for ConeProgram<'a> {
    type Error = ProblemError;

    fn try_from(problem: &'a dyn Problem) -> Result<Self, ProblemError> {
        let view = "conic programming";
        let form = problem.form();
        form.validate()?;
        match form.structure {
            Structure::Affine => Ok(Self { problem }),
            Structure::Smooth => Err(ProblemError::whole(ProblemErrorKind::NotAffine { view })),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;
    use crate::problem::examples;

    #[test]
    fn rosenbrock_is_least_squares_and_nlp_but_no_cone_program() {
        let problem = examples::rosenbrock();
        assert!(LeastSquares::try_from(&problem as &dyn Problem).is_ok());
        assert!(Nlp::try_from(&problem as &dyn Problem).is_ok());
        let error = ConeProgram::try_from(&problem as &dyn Problem)
            .err()
            .unwrap();
        assert_eq!(error.describe().code, "not-affine");
    }

    #[test]
    fn a_cone_is_refused_by_name_where_it_cannot_be_kept() {
        let problem = examples::nearest_psd();
        assert!(ConeProgram::try_from(&problem as &dyn Problem).is_ok());
        let error = Nlp::try_from(&problem as &dyn Problem).err().unwrap();
        assert_eq!(error.place.key.as_deref(), Some("matrix"));
        let error = LeastSquares::try_from(&problem as &dyn Problem)
            .err()
            .unwrap();
        assert_eq!(error.describe().code, "constrained");
    }

    #[test]
    fn bounds_that_cross_are_refused_by_every_view() {
        for (lower, upper) in [(2.0, 1.0), (f64::NAN, 1.0), (f64::INFINITY, f64::INFINITY)] {
            let mut problem = examples::rosenbrock();
            problem.form.variables[1].lower = lower;
            problem.form.variables[1].upper = upper;
            let error = LeastSquares::try_from(&problem as &dyn Problem)
                .err()
                .unwrap();
            assert_eq!(error.describe().code, "bounds-cross");
            assert_eq!(error.place.key.as_deref(), Some("y"));
        }
    }
}
