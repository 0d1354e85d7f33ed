//! Autocovariances of the differences of periods.

use realfft::num_complex::Complex;

use crate::recording::series::spectrum::{coefficients, synthesis};

/// Most lags of the autocovariance, rows; beyond it drift and noise cannot be told apart.
pub(super) const MOST_LAGS: usize = 500;

/// Σ_i e(i) e(i + l) / degrees for the lags 0..=lags, corrected for the products lost at the end.
pub(super) fn autocovariance(differences: &[f64], lags: usize, degrees: f64) -> Vec<f64> {
    let n = differences.len();
    // Zeros at the end keep the circular correlation of the transform from wrapping around.
    let padded = (n + lags).next_power_of_two();
    let mut series = differences.to_vec();
    series.resize(padded, 0.0);
    let power = coefficients(&series)
        .into_iter()
        .map(|c| Complex::from(c.norm_sqr()));
    let sums = synthesis(power.collect(), padded);
    (0..=lags.min(n - 1))
        .map(|l| sums[l] * padded as f64 / degrees * n as f64 / (n - l) as f64)
        .collect()
}
