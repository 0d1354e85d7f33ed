//! Functions of eigenvalues: `∂φ(λ(M))/∂M = V diag(∂φ/∂λ) Vᵀ`.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Least eigenvalue as a share of the largest that is not rounding.
const POSITIVE: f64 = 1e-15;

/// Iterations per matrix; a few per row are usual, and only NaN needs more.
const ITERATIONS: usize = 10_000;

/// Eigenvalues of a positive definite matrix; `None` where it is not.
pub(in crate::design) fn eigenvalues(m: &DMatrix<f64>) -> Option<DVector<f64>> {
    positive(m.clone().symmetric_eigenvalues())
}

/// The eigendecomposition of a symmetric matrix.
pub(super) struct Eigen {
    pub values: DVector<f64>,
    pub vectors: DMatrix<f64>,
}

/// Eigenvalues and vectors of a positive definite matrix; `None` where it is not.
pub(super) fn decompose(m: &DMatrix<f64>) -> Option<Eigen> {
    let eigen = SymmetricEigen::try_new(m.clone(), f64::EPSILON, ITERATIONS)?;
    Some(Eigen {
        values: positive(eigen.eigenvalues)?,
        vectors: eigen.eigenvectors,
    })
}

fn positive(values: DVector<f64>) -> Option<DVector<f64>> {
    (values.min() > POSITIVE * values.max()).then_some(values)
}

/// `V diag(slopes) Vᵀ`.
pub(in crate::design) fn assemble(vectors: &DMatrix<f64>, slopes: &DVector<f64>) -> DMatrix<f64> {
    let mut scaled = vectors.clone();
    for (mut column, slope) in scaled.column_iter_mut().zip(slopes.iter()) {
        column *= *slope;
    }
    scaled * vectors.transpose()
}

/// A mean of logarithms.
pub(super) struct LogMean {
    pub value: f64,
    /// Its derivatives by the values.
    pub slopes: DVector<f64>,
}

/// `(1/ρ) log Σ λ^ρ`, at most `log(p)/ρ` above the largest log λ (below the negated least, for negative
/// ρ), and its slopes with respect to λ.
pub(super) fn log_mean(values: &DVector<f64>, rho: f64) -> LogMean {
    let powers = values.map(|l| rho * l.ln());
    let largest = powers.max();
    let shares = powers.map(|p| (p - largest).exp());
    let sum = shares.sum();
    LogMean {
        value: (largest + sum.ln()) / rho,
        slopes: shares.zip_map(values, |s, l| s / (sum * l)),
    }
}
