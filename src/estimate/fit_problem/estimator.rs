//! The estimators by name, and the training recordings and prior that they use.

use crate::chain::dataset::Prepared;
use crate::chain::prior::Prior;

/// How parameters follow from recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    /// Ordinary least squares: every channel counts the same.
    Ordinary,
    /// Weighted least squares: every channel by the deviation of its residual.
    Weighted,
    /// Weighted least squares, iterated with Tukey's biweight of every residual.
    Robust,
    /// Maximum likelihood with the covariance of the noise across channels and frequencies.
    MaximumLikelihood,
}

/// What parameters follow from.
#[derive(Debug, Clone, Copy)]
pub struct Training<'a> {
    /// The recordings that are fitted.
    pub recordings: &'a [&'a Prepared],
    /// What is known beforehand.
    pub prior: &'a Prior,
}
