//! From recordings to parameters: `min ‖W (s − ŝ(θ))‖²` with its uncertainty, checked on other recordings.

pub mod compress;
pub mod covariance;
pub mod error;
pub mod figures;
pub mod fit;
pub mod noise;
pub mod physical;
pub mod problem;
pub mod realization;
mod rows;
mod spectrum;
pub mod standstill;
pub mod task;
pub mod unknowns;
pub mod weights;
