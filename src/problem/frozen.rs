//! A problem with some variables held at fixed values, which is a problem again in the others.

use nalgebra::DVector;

use crate::problem::error::{ProblemError, ProblemErrorKind};
use crate::problem::form::Form;
use crate::problem::{Linearization, OutsideDomain, Problem, SquareRoot, Values};

/// The inner problem restricted to the variables that are not frozen, in their order.
pub struct Frozen<'a> {
    inner: &'a dyn Problem,
    /// Indices of the free variables in the inner problem.
    free: Vec<usize>,
    /// The frozen values; entries of free variables are overwritten.
    base: DVector<f64>,
    form: Form,
}

impl<'a> Frozen<'a> {
    /// Holds each listed variable (index, value) at its value, which must lie within its bounds.
    pub fn new(inner: &'a dyn Problem, fixed: &[(usize, f64)]) -> Result<Self, ProblemError> {
        let mut form = inner.form().clone();
        let count = form.variables.len();
        let mut base = DVector::zeros(count);
        let mut is_free = vec![true; count];
        for &(index, value) in fixed {
            let Some(variable) = form.variables.get(index) else {
                return Err(ProblemError::whole(ProblemErrorKind::NoSuchVariable {
                    index,
                    variables: count,
                }));
            };
            if !(variable.lower <= value && value <= variable.upper) {
                return Err(ProblemError::at(
                    &variable.name,
                    ProblemErrorKind::FrozenOutsideBounds {
                        value,
                        lower: variable.lower,
                        upper: variable.upper,
                    },
                ));
            }
            base[index] = value;
            is_free[index] = false;
        }
        let free: Vec<usize> = (0..count).filter(|i| is_free[*i]).collect();
        form.variables = free.iter().map(|i| form.variables[*i].clone()).collect();
        Ok(Self {
            inner,
            free,
            base,
            form,
        })
    }

    /// All variables of the inner problem, from the free ones.
    pub fn expand(&self, free: &DVector<f64>) -> DVector<f64> {
        let mut x = self.base.clone();
        for (index, value) in self.free.iter().zip(free.iter()) {
            x[*index] = *value;
        }
        x
    }

    /// The free variables, from all variables of the inner problem.
    pub fn restrict(&self, x: &DVector<f64>) -> DVector<f64> {
        x.select_rows(&self.free)
    }
}

impl Problem for Frozen<'_> {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, x: &DVector<f64>) -> Result<Values, OutsideDomain> {
        self.inner.values(&self.expand(x))
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        let inner = self.inner.linearize(&self.expand(x))?;
        Ok(Linearization {
            gradient: inner.gradient.select_rows(&self.free),
            square_root: inner.square_root.map(|root| SquareRoot {
                matrix: root.matrix.select_columns(&self.free),
                residual: root.residual,
            }),
            jacobian: inner.jacobian.select_columns(&self.free),
            cost: inner.cost,
            constraints: inner.constraints,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;
    use crate::problem::check::{DERIVATIVE_TOLERANCE, derivative_check};
    use crate::problem::examples;
    use crate::problem::scaled::Scaled;

    #[test]
    fn invariant_wrapped_problems_keep_values_and_derivatives() {
        for example in examples::all() {
            let problem = example.problem.as_ref();
            let x = &example.start;
            let inner = problem.values(x).unwrap();
            let scaled = Scaled::new(problem);
            let y = scaled.inner_to_outer(x);
            assert!(
                (scaled.values(&y).unwrap().cost - inner.cost).abs() <= 1e-12 * inner.cost.abs()
            );
            let report = derivative_check(&scaled, &y).unwrap();
            assert!(report.holds(DERIVATIVE_TOLERANCE), "{report:?}");

            let frozen = Frozen::new(problem, &[(0, x[0])]).unwrap();
            let free = frozen.restrict(x);
            assert_eq!(free.len() + 1, x.len());
            assert_eq!(frozen.values(&free).unwrap(), inner);
            let report = derivative_check(&frozen, &free).unwrap();
            assert!(report.holds(DERIVATIVE_TOLERANCE), "{report:?}");
        }
    }

    #[test]
    fn refuses_to_freeze_what_does_not_exist_or_lies_outside() {
        let mut problem = examples::rosenbrock();
        problem.form.variables[0].upper = 1.0;
        let code = |fixed: &[(usize, f64)]| {
            let error = Frozen::new(&problem, fixed).err().unwrap();
            error.describe().code
        };
        assert_eq!(code(&[(2, 0.0)]), "no-such-variable");
        assert_eq!(code(&[(0, 1.5)]), "frozen-outside-bounds");
        assert_eq!(code(&[(0, f64::NAN)]), "frozen-outside-bounds");
    }
}
