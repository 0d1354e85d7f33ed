//! From a problem file to what tasks work on: robot, model, recordings, priors.

pub mod error;
pub mod model;
pub mod names;
pub mod prior;
pub mod recordings;
pub mod robot;
