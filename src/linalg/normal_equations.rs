//! Normal equations `A x = b` whose directions may be dependent.

use nalgebra::{DMatrix, DVector};

/// Share of a direction that is not rounding.
pub const INDEPENDENT: f64 = 1e-8;

/// The solution over the directions of A that are not rounding.
#[derive(Debug, Clone)]
pub struct NormalSolution {
    /// `A⁻¹ b`.
    pub x: DVector<f64>,
    /// `bᵀ A⁻¹ b`, by which a sum of squares falls.
    pub gain: f64,
}

impl NormalSolution {
    /// Of a symmetric A with a positive diagonal, by the eigenvectors of A with a diagonal of ones.
    pub fn of(normal: &DMatrix<f64>, right: &DVector<f64>) -> Self {
        if right.is_empty() {
            return Self {
                x: DVector::zeros(0),
                gain: 0.0,
            };
        }
        let size = normal.diagonal().map(|d| 1.0 / d.sqrt());
        let scaled = DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| {
            normal[(i, j)] * size[i] * size[j]
        });
        let eigen = scaled.symmetric_eigen();
        let rotated = eigen.eigenvectors.tr_mul(&right.component_mul(&size));
        let over = |x: f64, value: f64| if value > INDEPENDENT { x / value } else { 0.0 };
        let solved = rotated.zip_map(&eigen.eigenvalues, over);
        Self {
            x: (&eigen.eigenvectors * &solved).component_mul(&size),
            gain: rotated.dot(&solved),
        }
    }
}
