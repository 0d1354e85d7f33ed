//! One abstraction for every optimisation here: minimise f(x) subject to g(x) in K and
//! lower <= x <= upper, where K is a product of {0}, nonnegative rows and positive semidefinite matrices.
//!
//! A [`Problem`] states its [`Form`] (names, units, shapes, sets) apart from its numbers. Solvers take a
//! [`view`] of it, and making the view is the only check of what a problem can do.

use nalgebra::{DMatrix, DVector};

use crate::problem::form::Form;

pub mod affine;
pub mod bounds;
pub mod check;
pub mod count;
pub mod defect;
pub mod error;
pub mod form;
pub mod frozen;
pub mod linear_rows;
pub mod scaled;
pub mod solution;
pub mod view;

#[cfg(test)]
pub(crate) mod examples;

/// Minimise f(x) subject to g(x) in K and lower <= x <= upper.
pub trait Problem: Sync {
    /// Names, units, shapes and sets: what is known without numbers.
    fn form(&self) -> &Form;

    /// f(x) and g(x), for trial steps.
    fn values(&self, x: &DVector<f64>) -> Result<Values, OutsideDomain>;

    /// Values and first derivatives at x, for accepted steps.
    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, OutsideDomain>;
}

/// The values of a problem at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    /// f(x); half the sum of squares where the objective is one.
    pub cost: f64,
    /// g(x), the rows of all constraints in the order of the form.
    pub constraints: DVector<f64>,
}

/// The first-order model of a problem at one point x, with n variables and c constraint rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Linearization {
    /// f(x).
    pub cost: f64,
    /// Gradient of f, n entries.
    pub gradient: DVector<f64>,
    /// Gauss-Newton model; present where the objective is a sum of squares.
    pub square_root: Option<SquareRoot>,
    /// g(x), c rows.
    pub constraints: DVector<f64>,
    /// Jacobian of g, c x n.
    pub jacobian: DMatrix<f64>,
}

impl Linearization {
    /// Of half a sum of squares without constraints, from all rows of its residual.
    pub fn of_squares(root: SquareRoot) -> Self {
        Self {
            cost: 0.5 * root.residual.norm_squared(),
            gradient: root.matrix.tr_mul(&root.residual),
            constraints: DVector::zeros(0),
            jacobian: DMatrix::zeros(0, root.matrix.ncols()),
            square_root: Some(root),
        }
    }
}

/// f(x + d) ~ 1/2 |matrix d + residual|^2 + constant, constant = cost - 1/2 |residual|^2.
///
/// Any number of rows: a long residual arrives compressed by QR, which leaves the model unchanged up to
/// that constant. The gradient of f is matrixᵀ residual.
#[derive(Debug, Clone, PartialEq)]
pub struct SquareRoot {
    /// r x n.
    pub matrix: DMatrix<f64>,
    /// r entries.
    pub residual: DVector<f64>,
}

/// The point lies where the problem has no value, such as a negative argument of a logarithm.
///
/// Not a fault: a solver that meets it at a trial step rejects the step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutsideDomain {
    /// What has no value, in words.
    pub reason: String,
}

impl OutsideDomain {
    /// A point at which the problem has no value, for a reason in words.
    pub fn new(reason: impl Into<String>) -> Self {
        Self {
            reason: reason.into(),
        }
    }
}

impl std::fmt::Display for OutsideDomain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "outside the domain: {}", self.reason)
    }
}

impl std::error::Error for OutsideDomain {}
