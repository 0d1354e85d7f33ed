//! From recordings to parameters: `min ‖W (s − ŝ(θ))‖²` with its uncertainty, checked on other recordings.
//!
//! # Files in the order of the work
//!
//! | step | files |
//! |---|---|
//! | the task | `task` chooses the fit: `fit`, `errors_in_variables_fit` (by `errors_in_variables`), `feasible/`, `load_by_difference` |
//! | bandwidth of the motion | `bandwidth` |
//! | the problem that solvers take | `problem` over the `unknowns`, its rows from `rows` and `weights`, compressed by `compress` |
//! | initial values | `start`, by local searches from a `start_grid` within a `search_range` |
//! | the optimum | `minimise` for each estimator, from a `warm_start`; `optimum` of one problem by `least_squares`, or by the `smoothing_method` where the model has kinks |
//! | weights from residuals | `reweight`, `noise`, `coloured_noise`, `cross_spectra` |
//! | covariance and intervals | `covariance`, with `torque_constants` |
//! | what is reported | `physical`, `realization`, `load`, `reactions`, `goodness_of_fit`, `model_comparison`, `remarks` |
//! | parameters that joints have in common | `sharing` |

pub mod bandwidth;
pub(crate) mod canonical_sines;
mod coloured_noise;
pub mod compress;
pub mod covariance;
mod cross_spectra;
pub mod error;
pub mod errors_in_variables;
pub mod errors_in_variables_fit;
pub mod estimator;
pub mod feasible;
pub mod fit;
mod fit_setup;
mod gain_intervals;
pub mod goodness_of_fit;
mod least_squares;
pub mod load;
pub mod load_by_difference;
pub mod minimise;
pub mod model_comparison;
pub mod noise;
mod optimum;
pub mod physical;
pub mod problem;
pub(crate) mod ratios;
pub mod reactions;
pub mod realization;
pub mod remarks;
mod reweight;
pub(crate) mod rows;
pub mod search_range;
pub mod sharing;
mod smoothing_method;
pub mod spectrum;
pub mod standstill;
mod start;
mod start_grid;
pub mod task;
pub mod torque_constants;
pub mod unknowns;
mod warm_start;
pub mod weights;

#[cfg(test)]
mod tests;
