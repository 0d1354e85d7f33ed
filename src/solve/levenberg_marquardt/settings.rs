//! Tolerances and limits of the method of Levenberg and Marquardt.

use crate::solve::error::{SolveError, SolveErrorKind, check_tolerances};

/// When to stop, and how to start.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Iterations after which it stops with [`Stop::IterationLimit`](crate::problem::solution::Stop).
    pub max_iterations: usize,
    /// Stop when the undamped Gauss-Newton step promises a decrease <= cost_tolerance · cost: the point is
    /// then within sqrt(2 cost_tolerance · rows) standard deviations of the optimum. No unit.
    pub cost_tolerance: f64,
    /// Stop when that step moves every variable by <= step_tolerance · (|x| + scale). No unit.
    pub step_tolerance: f64,
    /// Stop when |g_j| <= gradient_tolerance · |J_j| sqrt(2 cost) for every variable that no bound holds. No unit.
    pub gradient_tolerance: f64,
    /// First lambda, > 0: the weight of |D d|² against |J d + r|². No unit.
    pub initial_damping: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            max_iterations: 200,
            cost_tolerance: 1e-16,
            step_tolerance: 1e-12,
            gradient_tolerance: 1e-12,
            initial_damping: 1e-3,
        }
    }
}

impl Settings {
    pub(super) fn validate(&self) -> Result<(), SolveError> {
        check_tolerances(&[
            ("cost_tolerance", self.cost_tolerance),
            ("step_tolerance", self.step_tolerance),
            ("gradient_tolerance", self.gradient_tolerance),
        ])?;
        let value = self.initial_damping;
        if !(value > 0.0 && value.is_finite()) {
            let kind = SolveErrorKind::Setting {
                value,
                range: "value > 0",
            };
            return Err(SolveError::at("initial_damping", kind));
        }
        Ok(())
    }
}
