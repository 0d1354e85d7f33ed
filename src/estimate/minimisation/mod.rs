//! The optimum of each estimator: weights that follow from residuals, iterated (reweighted least squares), begun by a fit of
//! fewer rows where there are many, repeated without laws that a search has carried away, and for the bandwidth of the motion.

pub mod bandwidth;
pub mod fit_setup;
pub mod minimise;
pub mod optimum;
pub mod reweight;
pub mod run_away;
pub mod warm_start;
