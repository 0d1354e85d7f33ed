//! Sampled series: differences, interpolation, splines, spectra, and zero-phase filters.

pub mod differences;
pub mod interpolation;
pub mod spectrum;
pub mod spline;
pub mod zero_phase;
