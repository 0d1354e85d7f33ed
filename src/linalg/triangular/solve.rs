//! Equations with R: least squares, covariance (RᵀR)⁻¹ = R⁻¹ R⁻ᵀ, singular values and condition numbers.

use faer::MatRef;
use nalgebra::{DMatrix, DVector};

use crate::linalg::triangular::Triangular;

/// Scaling of the columns before singular values are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnScaling {
    /// The columns as they are.
    None,
    /// Every column of unit Euclidean norm; a zero column stays zero.
    UnitNorm,
}

/// The least squares problem min |R x - right|² + rest² that a factor of [A, b] holds.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// R of A, p x p.
    pub matrix: DMatrix<f64>,
    /// Qᵀb, p entries.
    pub right: DVector<f64>,
    /// Norm of the part of b that no x reaches.
    pub rest: f64,
}

impl Triangular {
    /// Reads the last column as the right-hand side; `None` without columns.
    pub fn system(&self) -> Option<System> {
        let count = self.columns().checked_sub(1)?;
        let whole = self.matrix();
        Some(System {
            matrix: whole.view((0, 0), (count, count)).into_owned(),
            right: whole.view((0, count), (count, 1)).column(0).into_owned(),
            rest: whole[(count, count)],
        })
    }

    /// Solves R x = right, R with a diagonal that is not negative; `None` where a diagonal entry is zero.
    pub fn solve(&self, right: &DVector<f64>) -> Option<DVector<f64>> {
        self.matrix().solve_upper_triangular(right)
    }

    /// R⁻¹; `None` where a diagonal entry is zero.
    pub fn inverse(&self) -> Option<DMatrix<f64>> {
        let identity = DMatrix::identity(self.columns(), self.columns());
        self.matrix().solve_upper_triangular(&identity)
    }

    /// (AᵀA)⁻¹ = R⁻¹ R⁻ᵀ, the covariance of the estimate for residuals of unit variance.
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        let inverse = self.inverse()?;
        Some(&inverse * inverse.transpose())
    }

    /// Singular values of A (or of A with scaled columns), descending. `None` if an entry is not finite.
    pub fn singular_values(&self, scaling: ColumnScaling) -> Option<DVector<f64>> {
        let mut matrix = self.matrix();
        if scaling == ColumnScaling::UnitNorm {
            for mut column in matrix.column_iter_mut() {
                let norm = column.norm();
                if norm > 0.0 {
                    column /= norm;
                }
            }
        }
        let count = self.columns();
        let view = MatRef::from_column_major_slice(matrix.as_slice(), count, count);
        let values = view.singular_values().ok()?;
        values
            .iter()
            .all(|v| v.is_finite())
            .then(|| DVector::from_vec(values))
    }

    /// Largest over smallest singular value; infinity where A is rank deficient or not finite.
    pub fn condition_number(&self, scaling: ColumnScaling) -> f64 {
        match self.singular_values(scaling) {
            Some(values) if values.is_empty() => 1.0,
            Some(values) if values[values.len() - 1] > 0.0 => values[0] / values[values.len() - 1],
            _ => f64::INFINITY,
        }
    }
}
