//! The fit as an optimisation problem: its estimator and recordings, its unknowns, and the weighted residual over them.

pub mod estimator;
pub mod problem;
pub mod unknowns;
