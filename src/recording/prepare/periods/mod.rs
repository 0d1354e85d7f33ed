//! Periodic motion: its period, the average over periods and the scatter about it, and derivatives by Fourier series.

pub mod clock_drift;
mod fourier;
pub mod period;
mod period_average;
pub mod periodic;
mod row_noise;
pub mod sample_by_sample;
pub mod scatter;
mod shrinkage;
pub mod successive_periods;
