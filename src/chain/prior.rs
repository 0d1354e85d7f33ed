//! What is known before the data: `A θ ~ N(μ, Σ)` as rows `Σ^(−1/2) (A θ − μ)` of the residual.

use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

/// Linear combinations of parameters with a Gaussian distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Prior {
    /// Whitened rows over all parameters of the model.
    rows: DMatrix<f64>,
    mean: DVector<f64>,
}

/// Eigenvalues of a covariance below this share of the largest are rounding: the prior says nothing more
/// there than its leading directions do.
const RANK: f64 = 1e-12;

impl Prior {
    /// Nothing is known.
    pub fn none(parameters: usize) -> Self {
        Self {
            rows: DMatrix::zeros(0, parameters),
            mean: DVector::zeros(0),
        }
    }

    /// `combinations · θ` has mean `mean` and covariance `covariance`.
    pub fn new(
        combinations: &DMatrix<f64>,
        mean: &DVector<f64>,
        covariance: &DMatrix<f64>,
    ) -> Self {
        let whiten = match Cholesky::new(covariance.clone()) {
            Some(factor) => factor.inverse_root(),
            None => pseudo_root(covariance),
        };
        Self {
            rows: &whiten * combinations,
            mean: whiten * mean,
        }
    }

    /// This and another, independent of it.
    pub fn and(self, other: Self) -> Self {
        let stack = |a: &DMatrix<f64>, b: &DMatrix<f64>| {
            let mut all = DMatrix::zeros(a.nrows() + b.nrows(), a.ncols());
            all.rows_mut(0, a.nrows()).copy_from(a);
            all.rows_mut(a.nrows(), b.nrows()).copy_from(b);
            all
        };
        let mean = self.mean.iter().chain(other.mean.iter()).copied();
        Self {
            mean: DVector::from_iterator(self.mean.len() + other.mean.len(), mean),
            rows: stack(&self.rows, &other.rows),
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.nrows()
    }

    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Rows over all parameters of the model.
    pub fn rows(&self) -> &DMatrix<f64> {
        &self.rows
    }

    /// Whether something is known of a parameter.
    pub fn speaks_of(&self, parameter: usize) -> bool {
        let column = self.rows.column(parameter);
        column.iter().any(|entry| *entry != 0.0)
    }

    /// Whitened deviation at parameter values.
    pub fn residual(&self, values: &DVector<f64>) -> DVector<f64> {
        &self.rows * values - &self.mean
    }

    /// Rows over the parameters at `columns`, over `others` that nothing is known of, and the deviation at parameter
    /// values in the last column.
    pub fn system(&self, columns: &[usize], others: usize, values: &DVector<f64>) -> DMatrix<f64> {
        let of_columns = self.rows.select_columns(columns);
        let last = columns.len() + others;
        let mut system = of_columns.insert_columns(columns.len(), others + 1, 0.0);
        system.set_column(last, &self.residual(values));
        system
    }
}

trait InverseRoot {
    fn inverse_root(&self) -> DMatrix<f64>;
}

impl InverseRoot for Cholesky<f64, nalgebra::Dyn> {
    /// `L⁻¹` with `Σ = L Lᵀ`.
    fn inverse_root(&self) -> DMatrix<f64> {
        let n = self.l_dirty().nrows();
        let identity = DMatrix::identity(n, n);
        self.l()
            .solve_lower_triangular(&identity)
            .unwrap_or(identity)
    }
}

fn pseudo_root(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(covariance.clone());
    let largest = eigen.eigenvalues.amax();
    let kept: Vec<usize> = (0..covariance.nrows())
        .filter(|&k| eigen.eigenvalues[k] > RANK * largest)
        .collect();
    DMatrix::from_fn(kept.len(), covariance.nrows(), |i, j| {
        eigen.eigenvectors[(j, kept[i])] / eigen.eigenvalues[kept[i]].sqrt()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_whitened_rows_carry_the_information_of_the_covariance() {
        let covariance = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 9.0]);
        let combinations = DMatrix::from_row_slice(2, 3, &[1.0, 0.0, 2.0, 0.0, 1.0, 0.0]);
        let prior = Prior::new(
            &combinations,
            &DVector::from_vec(vec![1.0, 2.0]),
            &covariance,
        );
        let information = prior.rows().transpose() * prior.rows();
        let expected = combinations.transpose() * covariance.try_inverse().unwrap() * &combinations;
        assert!((information - expected).amax() < 1e-14);
        let at_mean = prior.residual(&DVector::from_vec(vec![1.0, 2.0, 0.0]));
        assert!(at_mean.amax() < 1e-14);
    }

    #[test]
    fn a_singular_covariance_keeps_its_leading_directions() {
        let covariance = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
        let prior = Prior::new(&DMatrix::identity(2, 2), &DVector::zeros(2), &covariance);
        assert_eq!(prior.len(), 1);
    }
}
