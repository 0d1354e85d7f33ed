//! Coordinates y of a step d = B y in which the sum of squares is as simple as it can be:
//!
//! ```text
//! ½ ‖M d + r‖² = ½ ‖P (y + ρ)‖² + rest,   M = Q R,   B = R⁻¹,   ρ = Qᵀ r
//! ```
//!
//! P is one where the squares see a coordinate and zero where they do not. A weak pull has the size of everything
//! else in them; in MᵀM it is below the rounding of the rest.

use crate::linalg::triangular::Triangular;
use crate::problem::SquareRoot;
use crate::problem::form::Form;
use nalgebra::{DMatrix, DVector};

/// Share of a column below which what the columns before it leave of it is rounding.
const DEPENDENT: f64 = 1e-14;

pub(super) struct Coordinates {
    /// B.
    pub basis: DMatrix<f64>,
    /// Diagonal of P.
    pub seen: DVector<f64>,
    /// ρ, zero where nothing is seen.
    pub residual: DVector<f64>,
    /// ½ of the squares that no step reaches.
    pub rest: f64,
}

impl Coordinates {
    /// Every variable in units of its scale, no squares.
    pub fn of_scales(form: &Form) -> Self {
        let count = form.variables.len();
        let scales = form.variables.iter().map(|v| v.scale);
        Self {
            basis: DMatrix::from_diagonal(&DVector::from_iterator(count, scales)),
            seen: DVector::zeros(count),
            residual: DVector::zeros(count),
            rest: 0.0,
        }
    }

    /// `None` where a number is not finite.
    pub fn of_squares(form: &Form, root: &SquareRoot) -> Option<Self> {
        let whole = Triangular::of_system(&root.matrix, &root.residual).system()?;
        let count = whole.right.len();
        let columns = Triangular::of(&whole.matrix).independent_columns(DEPENDENT);
        let system =
            Triangular::of_system(&whole.matrix.select_columns(&columns.kept), &whole.right)
                .system()?;
        let rank = columns.kept.len();
        let inverse = system
            .matrix
            .solve_upper_triangular(&DMatrix::identity(rank, rank))?;
        let mut basis = DMatrix::zeros(count, count);
        for (row, &j) in columns.kept.iter().enumerate() {
            basis
                .view_mut((j, 0), (1, rank))
                .copy_from(&inverse.row(row));
            for k in 0..columns.dependent.len() {
                let scale = form.variables[columns.dependent[k]].scale;
                basis[(j, rank + k)] = -scale * columns.coefficients[(row, k)];
            }
        }
        for (k, &j) in columns.dependent.iter().enumerate() {
            basis[(j, rank + k)] = form.variables[j].scale;
        }
        let is_finite = basis
            .iter()
            .chain(system.right.iter())
            .all(|x| x.is_finite());
        is_finite.then(|| Self {
            basis,
            seen: DVector::from_fn(count, |j, _| f64::from(u8::from(j < rank))),
            residual: system.right.resize_vertically(count, 0.0),
            rest: 0.5 * (whole.rest.powi(2) + system.rest.powi(2)),
        })
    }

    /// The step of the variables.
    pub fn step(&self, y: &DVector<f64>) -> DVector<f64> {
        &self.basis * y
    }

    /// ½ ‖M d + r‖².
    pub fn squares(&self, y: &DVector<f64>) -> f64 {
        0.5 * self.gradient(y).norm_squared() + self.rest
    }

    /// Gradient of the squares with respect to y.
    pub fn gradient(&self, y: &DVector<f64>) -> DVector<f64> {
        (y + &self.residual).component_mul(&self.seen)
    }
}
