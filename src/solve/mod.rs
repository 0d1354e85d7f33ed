//! Solvers of [`crate::problem`]. They know no robot: a view of a problem in, a solution out.

pub mod bounded;
pub mod error;
pub mod levenberg_marquardt;
