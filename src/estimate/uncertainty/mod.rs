//! Covariance of the estimate by a sandwich estimator for coloured residuals, what uncertain torque constants add to it, and
//! what is known of parameters that are determined in ratios only.

pub mod coloured_noise;
mod counted_residuals;
pub mod covariance;
pub mod cross_spectra;
pub mod gain_intervals;
pub mod ratios;
mod segments;
pub mod spectrum;
pub mod torque_constants;
