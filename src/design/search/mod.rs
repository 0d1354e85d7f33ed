//! Global search by multistart: random starts, local optimisation, limits between samples, and a motion for validation.

pub mod inter_sample_limits;
pub mod multistart;
pub mod starts;
pub mod validation_motion;
