//! From recordings to parameters: `min ‖W (s − ŝ(θ))‖²` with its uncertainty, checked on other recordings.
//!
//! # Files in the order of the work
//!
//! | step | files |
//! |---|---|
//! | the task | `task` chooses the fit: `fit`, `errors_in_variables/`, `feasible/`, `load_by_difference` |
//! | the residual and its weights | `residual/` |
//! | the problem that solvers take | `fit_problem/` |
//! | one solution of it | `solve/` |
//! | initial values | `initial/` |
//! | the optimum of each estimator, and the bandwidth of the motion | `minimisation/` |
//! | covariance and intervals | `uncertainty/` |
//! | what is reported | `derived/` |
//! | parameters that joints have in common | `sharing` |
//! | intervals of friction that motions do not show | `unshown_friction` |
//!
//! Imports follow this order upwards, from `residual/` to `derived/`; the fits use them all, `sharing`,
//! `unshown_friction` and `task` the fits.

mod derived;
pub mod error;
pub mod errors_in_variables;
pub mod feasible;
pub mod fit;
mod fit_problem;
mod initial;
pub mod load_by_difference;
mod minimisation;
mod residual;
pub mod sharing;
mod solve;
pub mod task;
mod uncertainty;
mod unshown_friction;

pub use crate::estimate::derived::{goodness_of_fit, load, reactions, remarks};
pub use crate::estimate::fit_problem::{estimator, problem, unknowns};
pub use crate::estimate::initial::search_range;
pub use crate::estimate::minimisation::bandwidth;
pub use crate::estimate::residual::{compress, standstill, weights};
pub use crate::estimate::uncertainty::{covariance, spectrum};

pub(crate) use crate::estimate::initial::gap_search;
pub(crate) use crate::estimate::residual::{noise, rows};
pub(crate) use crate::estimate::solve::canonical_sines;

#[cfg(test)]
mod tests;
