//! A motion in samples.

/// Position, velocity and acceleration `[joint][sample]`.
pub type Motion = [Vec<Vec<f64>>; 3];
