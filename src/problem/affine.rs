//! Affine problems: a sum of squares over affine rows in cones.
//!
//! ```text
//! minimise ½ ‖M x + b‖²   subject to   G x + h in K
//! ```

use crate::problem::form::{Constraint, Form, Objective, Structure, Variable};
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
    /// G x + h.
    pub cones: AffineRows,
}

impl AffineProblem {
    /// Squares of rows, with the rows of constraints in their order.
    pub fn new(
        variables: Vec<Variable>,
        constraints: Vec<Constraint>,
        squares: AffineRows,
        cones: AffineRows,
    ) -> Self {
        Self {
            form: Form {
                variables,
                objective: Objective::SumOfSquares {
                    rows: squares.offset.len(),
                },
                constraints,
                structure: Structure::Affine,
            },
            squares,
            cones,
        }
    }
}

impl Problem for AffineProblem {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, x: &DVector<f64>) -> Result<Values, OutsideDomain> {
        Ok(Values {
            cost: 0.5 * self.squares.at(x).norm_squared(),
            constraints: self.cones.at(x),
        })
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        let root = SquareRoot {
            matrix: self.squares.matrix.clone(),
            residual: self.squares.at(x),
        };
        Ok(Linearization {
            cost: 0.5 * root.residual.norm_squared(),
            gradient: root.matrix.tr_mul(&root.residual),
            square_root: Some(root),
            constraints: self.cones.at(x),
            jacobian: self.cones.matrix.clone(),
        })
    }
}
