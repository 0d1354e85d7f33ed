//! The state of a feasible fit: problem, constraints, prior and solution.

use crate::estimate::feasible::prior::InertialPrior;
use crate::estimate::feasible::program::Constraints;
use crate::estimate::feasible::regularisation_weight::ChosenWeight;
use crate::estimate::feasible::solve::{Feasible, Setting};
use crate::estimate::feasible::standard::StandardParameters;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::problem_file::choices::FeasibleBy;
use nalgebra::DVector;

/// Smallest eigenvalue of a scaled pseudo-inertia, kg: five micrograms, whose price on the best fit is below a
/// hundred-millionth of the squared torques.
pub const MARGIN: f64 = 5e-9;

/// A feasible fit before it is reported.
pub(super) struct FeasibleFit<'a> {
    pub(super) problem: FitProblem<'a>,
    pub(super) standard: &'a StandardParameters<'a>,
    pub(super) constraints: &'a Constraints,
    pub(super) prior: Option<(&'a InertialPrior, ChosenWeight)>,
    pub(super) by: FeasibleBy,
    pub(super) feasible: Feasible,
    /// Base unknowns of least squares with the same weights.
    pub(super) free: DVector<f64>,
}

impl FeasibleFit<'_> {
    pub(super) fn setting(&self) -> Setting<'_> {
        Setting {
            standard: self.standard,
            constraints: self.constraints,
            margin: MARGIN,
            prior: self.prior.as_ref().map(|(p, chosen)| (*p, chosen.weight)),
        }
    }
}
