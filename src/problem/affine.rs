//! Affine problems: a sum of squares and a linear cost over affine rows in cones.
//!
//! ```text
//! minimise ½ ‖M x + b‖² + cᵀ x   subject to   G x + h in K
//! ```

use crate::problem::form::{Form, Objective};
use crate::problem::{Linearization, OutsideDomain, Problem, SquareRoot, Values};
use nalgebra::{DMatrix, DVector};

/// `matrix x + offset`.
#[derive(Debug, Clone)]
pub struct AffineRows {
    /// Rows x unknowns.
    pub matrix: DMatrix<f64>,
    /// Of every row.
    pub offset: DVector<f64>,
}

impl AffineRows {
    /// The rows at x.
    pub fn at(&self, x: &DVector<f64>) -> DVector<f64> {
        &self.matrix * x + &self.offset
    }
}

/// An affine sum of squares with affine cones.
#[derive(Debug, Clone)]
pub struct AffineProblem {
    /// Variables, and the sets of the rows of the cones.
    pub form: Form,
    /// M x + b.
    pub squares: AffineRows,
    /// c.
    pub linear: DVector<f64>,
    /// G x + h.
    pub cones: AffineRows,
}

impl Problem for AffineProblem {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, x: &DVector<f64>) -> Result<Values, OutsideDomain> {
        Ok(Values {
            cost: 0.5 * self.squares.at(x).norm_squared() + self.linear.dot(x),
            constraints: self.cones.at(x),
        })
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        let residual = self.squares.at(x);
        let root = SquareRoot {
            matrix: self.squares.matrix.clone(),
            residual,
        };
        Ok(Linearization {
            cost: 0.5 * root.residual.norm_squared() + self.linear.dot(x),
            gradient: &self.linear + root.matrix.tr_mul(&root.residual),
            square_root: matches!(self.form.objective, Objective::SumOfSquares { .. })
                .then_some(root),
            constraints: self.cones.at(x),
            jacobian: self.cones.matrix.clone(),
        })
    }
}
