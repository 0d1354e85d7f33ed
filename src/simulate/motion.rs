//! A sampled motion.

/// Position, velocity and acceleration `[joint][sample]`.
pub type Motion = [Vec<Vec<f64>>; 3];

/// Even instants.
#[derive(Debug, Clone, Copy)]
pub struct Instants {
    /// The first, s.
    pub start: f64,
    /// Hz.
    pub rate: f64,
    /// How many.
    pub count: usize,
}
