//! Accuracy and limits of the interior-point method.

/// Accuracy and limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Optimal when the duality gap <= tolerance · unit, unit = max(|cost|, 1e-5 · ½‖b‖²), and the stationarity
    /// <= sqrt(tolerance), which leaves a share of the unit of the order of the tolerance.
    pub tolerance: f64,
    /// Where the tolerance is out of reach, as with an infimum that no point attains, optimal when gap <= this ·
    /// unit and the last iterations have not halved it.
    pub reduced_tolerance: f64,
    /// Iterations after which it stops with [`Stop::IterationLimit`](crate::problem::solution::Stop).
    pub max_iterations: usize,
    /// Largest shortfall of the smallest eigenvalue of a semidefinite block that an answer may have. Where blocks grow
    /// without bound the rounding of S is worth more cost than the tolerance: who asks for a margin that is larger than
    /// needed by this has answers that keep the margin needed.
    pub shortfall: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            tolerance: 1e-10,
            reduced_tolerance: 1e-6,
            max_iterations: 100,
            shortfall: 0.0,
        }
    }
}
