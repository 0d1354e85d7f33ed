//! From recordings to parameters: `min ‖W (s − ŝ(θ))‖²` with its uncertainty, checked on other recordings.
//!
//! # Files in the order of the work
//!
//! | step | files |
//! |---|---|
//! | the task | `task` chooses the fit: `fit`, `noisy_fit`, `feasible/`, `difference` of a load |
//! | bandwidth of the motion | `bandwidth` |
//! | the problem that solvers take | `problem` over the `unknowns`, its rows from `rows` and `weights`, compressed by `compress` |
//! | where it starts | `start`, `reach`, `shapes` |
//! | the optimum | `coarse`, `minimise`, `optimum`, `rounded`; a single search is `least_squares` |
//! | weights from residuals | `reweight`, `noise`, `colour`, `gaps` |
//! | covariance and intervals | `covariance`, with `torque_constants` |
//! | what is reported | `physical`, `realization`, `load`, `reactions`, `figures`, `contest`, `remarks` |
//! | parameters that joints have in common | `sharing` |

pub mod bandwidth;
mod coarse;
mod colour;
pub mod compress;
pub mod contest;
pub mod covariance;
pub mod difference;
pub mod error;
pub mod estimator;
pub mod feasible;
pub mod figures;
pub mod fit;
mod gain_intervals;
mod gaps;
mod least_squares;
pub mod load;
pub mod minimise;
pub mod motion;
pub mod noise;
pub mod noisy_fit;
mod optimum;
pub mod physical;
pub mod problem;
pub(crate) mod ratios;
pub mod reach;
pub mod reactions;
pub mod realization;
pub mod remarks;
mod reweight;
mod rounded;
pub(crate) mod rows;
mod shapes;
pub mod sharing;
pub(crate) mod sines;
pub mod spectrum;
pub mod standstill;
mod start;
pub mod task;
pub mod torque_constants;
pub mod unknowns;
pub mod weights;

#[cfg(test)]
mod tests;
