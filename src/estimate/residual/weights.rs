//! Weights of the residuals: `W` with `‖W e‖²` minimised, constant over the rows, and factors per row.

use crate::estimate::error::EstimateError;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Weights that change by less than this share move an estimate by a share of its deviation that is smaller still.
const NEAR: f64 = 1e-3;

/// How the channels of one row are weighted against each other.
#[derive(Debug, Clone, PartialEq)]
pub enum Weights {
    /// W diagonal: one factor per channel.
    PerChannel(DVector<f64>),
    /// W any matrix, such as `WᵀW = Σ⁻¹` for the covariance Σ of a row.
    Full(DMatrix<f64>),
}

impl Weights {
    /// Every channel by the inverse of its standard deviation.
    pub fn by_deviation(deviations: &[f64]) -> Self {
        let inverse = |s: &f64| if *s > 0.0 { 1.0 / s } else { 1.0 };
        Self::PerChannel(DVector::from_iterator(
            deviations.len(),
            deviations.iter().map(inverse),
        ))
    }

    /// `W = Lᵀ` with `Σ⁻¹ = L Lᵀ`: an upper triangle, so that a row mixes a joint's channel only with those of joints
    /// behind it, which on a serial arm depend on fewer parameters. Channels that are not active have unit
    /// variance in Σ.
    pub fn by_covariance(covariance: &DMatrix<f64>) -> Result<Self, EstimateError> {
        let inverse = Cholesky::new(covariance.clone()).map(|factor| factor.inverse());
        let factor = inverse.and_then(Cholesky::new);
        let factor = factor.ok_or(EstimateError::SingularResiduals)?;
        Ok(Self::Full(factor.l().transpose()))
    }

    /// The same weights times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::PerChannel(factors) => Self::PerChannel(factors * factor),
            Self::Full(matrix) => Self::Full(matrix * factor),
        }
    }

    /// Whether residuals weigh the same within a thousandth: `|W W₀⁻¹ − 1| <= 1e-3` in every entry.
    pub fn is_near(&self, other: &Self) -> bool {
        let Some(inverse) = other.matrix().try_inverse() else {
            return false;
        };
        let ratio = self.matrix() * inverse;
        let identity = DMatrix::identity(ratio.nrows(), ratio.ncols());
        (ratio - identity).amax() <= NEAR
    }

    /// W as a matrix.
    pub fn matrix(&self) -> DMatrix<f64> {
        match self {
            Self::PerChannel(factors) => DMatrix::from_diagonal(factors),
            Self::Full(matrix) => matrix.clone(),
        }
    }
}

/// Factors of the residuals of single rows: `[recording][channel][row]`, empty where all are 1.
pub type RowFactors = Vec<Vec<Vec<f64>>>;

#[cfg(test)]
mod tests {
    use super::*;

    /// Weighted residuals have unit variance, which is what they are held against the rows of a prior by.
    #[test]
    fn invariant_weighted_rows_have_unit_variance() {
        let weights = Weights::by_deviation(&[0.5, 0.0, 4.0]);
        assert_eq!(weights.matrix().diagonal().as_slice(), [2.0, 1.0, 0.25]);
        let covariance = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 2.0]);
        let weights = Weights::by_covariance(&covariance).unwrap().matrix();
        let white = &weights * covariance * weights.transpose();
        assert!((white - DMatrix::identity(2, 2)).amax() < 1e-14);
        assert_eq!(weights[(1, 0)], 0.0);
    }

    #[test]
    fn weights_are_near_within_a_thousandth() {
        let weights = Weights::by_deviation(&[0.5, 4.0]);
        assert!(weights.is_near(&weights.scaled(1.0009)));
        assert!(!weights.is_near(&weights.scaled(1.0011)));
    }
}
