//! Errors in variables: maximum likelihood where motion and signal are both noisy, as a problem and as a fit.

pub mod fit;
pub(in crate::estimate) mod problem;
