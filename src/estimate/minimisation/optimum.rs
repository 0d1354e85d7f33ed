//! The least-squares optimum of one problem, from a warm start or from its initial values.

use crate::estimate::error::EstimateError;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::initial::start;
use crate::estimate::solve::least_squares::ITERATION_LIMIT;
use crate::estimate::solve::smoothing_method::{accumulate, search};
use crate::problem::solution::{Control, Solution};

/// A solution and the problem that it solves, with the weights that go with it.
pub(crate) struct Optimum<'a> {
    pub solution: Solution,
    pub problem: FitProblem<'a>,
}

/// The optimum from where another search ended, or else from the start that the recordings suggest.
pub(in crate::estimate) fn searched(
    problem: &FitProblem<'_>,
    begun: Option<&Solution>,
    control: &Control<'_>,
) -> Result<Solution, EstimateError> {
    match begun {
        Some(begun) => {
            let next = search(problem, &begun.x, ITERATION_LIMIT, control)?;
            Ok(accumulate(begun.clone(), next))
        }
        None => {
            let start = start::find(problem, control)?;
            search(problem, &start, ITERATION_LIMIT, control)
        }
    }
}
