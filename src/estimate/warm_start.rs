//! Warm start: a fit of many rows begins where a fit of a few of them ended.
//!
//! Most iterations of a nonlinear fit are spent far from the optimum, where every n-th row shows the way as well as
//! all of them. The end of a search over an n-th of the rows lies about √n standard deviations of the whole fit from
//! its optimum, which takes an iteration or two. Estimate, weights and intervals are those of all rows.

use crate::chain::dataset::Prepared;
use crate::chain::model::Model;
use crate::estimate::canonical_sines;
use crate::estimate::error::EstimateError;
use crate::estimate::estimator::{Estimator, Training};
use crate::estimate::minimise::Search;
use crate::estimate::noise::counting_rows;
use crate::estimate::problem::FitProblem;
use crate::estimate::rows::needs_all;
use crate::estimate::unknowns::Unknowns;
use crate::problem::solution::{Control, Solution};

/// Rows below which a search takes them all at once: a hundred for each unknown of an arm with every effect.
const FEW_ROWS: usize = 20_000;

/// The search before takes every n-th row.
const EVERY: usize = 8;

/// The optimum of an estimator, begun from that of a few of the rows where there are many.
pub(crate) fn minimise<'a>(
    model: &'a Model,
    unknowns: &'a Unknowns,
    training: Training<'a>,
    (estimator, control): (Estimator, &Control<'_>),
) -> Result<(Solution, FitProblem<'a>), EstimateError> {
    let begun = end(model, unknowns, training, (estimator, control));
    let search = Search {
        model,
        unknowns,
        training,
        estimator,
        control,
    };
    let (solution, problem) = search.from(begun)?;
    Ok((canonical_sines::canonical(&problem, solution), problem))
}

/// Where the search over fewer rows ends; `None` for few rows, for what one solution of linear equations settles,
/// and for models and filters that need every row.
fn end(
    model: &Model,
    unknowns: &Unknowns,
    (recordings, prior): Training<'_>,
    (estimator, control): (Estimator, &Control<'_>),
) -> Option<Solution> {
    let linear = unknowns.nonlinear.is_empty() && model.is_affine();
    let whole = recordings.iter().any(|r| needs_all(model, r));
    if linear || whole || counting_rows(recordings) < FEW_ROWS {
        return None;
    }
    let thinned: Vec<Prepared> = recordings.iter().map(|r| r.thinned(EVERY)).collect();
    let fewer: Vec<&Prepared> = thinned.iter().collect();
    let found = minimise(model, unknowns, (&fewer, prior), (estimator, control));
    // Rows that do not suffice for a start leave it to the whole.
    found.ok().map(|(solution, _)| solution)
}
