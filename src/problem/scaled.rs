//! A problem in dimensionless variables y = x / scale, which is a problem again.

use nalgebra::{DMatrix, DVector};

use crate::problem::form::Form;
use crate::problem::{Linearization, OutsideDomain, Problem, SquareRoot, Values};

/// The inner problem at x = scale ∘ y, the scales taken from its form.
pub struct Scaled<'a> {
    inner: &'a dyn Problem,
    scale: DVector<f64>,
    form: Form,
}

impl<'a> Scaled<'a> {
    /// Scales every variable by its `scale` in the form; bounds are scaled with it, and units fall away.
    pub fn new(inner: &'a dyn Problem) -> Self {
        let mut form = inner.form().clone();
        let scale =
            DVector::from_iterator(form.variables.len(), form.variables.iter().map(|v| v.scale));
        for variable in &mut form.variables {
            variable.lower /= variable.scale;
            variable.upper /= variable.scale;
            variable.scale = 1.0;
            variable.unit = String::new();
        }
        Self { inner, scale, form }
    }

    /// x = scale ∘ y.
    pub fn outer_to_inner(&self, y: &DVector<f64>) -> DVector<f64> {
        y.component_mul(&self.scale)
    }

    /// y = x / scale.
    pub fn inner_to_outer(&self, x: &DVector<f64>) -> DVector<f64> {
        x.component_div(&self.scale)
    }

    fn scale_columns(&self, mut matrix: DMatrix<f64>) -> DMatrix<f64> {
        for (mut column, scale) in matrix.column_iter_mut().zip(self.scale.iter()) {
            column *= *scale;
        }
        matrix
    }
}

impl Problem for Scaled<'_> {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, y: &DVector<f64>) -> Result<Values, OutsideDomain> {
        self.inner.values(&self.outer_to_inner(y))
    }

    fn linearize(&self, y: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        let inner = self.inner.linearize(&self.outer_to_inner(y))?;
        Ok(Linearization {
            gradient: inner.gradient.component_mul(&self.scale),
            square_root: inner.square_root.map(|root| SquareRoot {
                matrix: self.scale_columns(root.matrix),
                residual: root.residual,
            }),
            jacobian: self.scale_columns(inner.jacobian),
            cost: inner.cost,
            constraints: inner.constraints,
        })
    }
}
