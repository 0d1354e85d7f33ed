//! Warm start: a fit of many rows begins where a fit of a few of them ended.
//!
//! Most iterations of a nonlinear fit are spent far from the optimum, where every n-th row shows the way as well as
//! all of them. The end of a search over an n-th of the rows lies about √n standard deviations of the whole fit from
//! its optimum, which takes an iteration or two. Estimate, weights and intervals are those of all rows.

use crate::chain::dataset::Prepared;
use crate::estimate::error::EstimateError;
use crate::estimate::fit_problem::estimator::Training;
use crate::estimate::minimisation::minimise::Minimisation;
use crate::estimate::minimisation::optimum::Optimum;
use crate::estimate::residual::noise::counting_rows;
use crate::estimate::residual::rows::needs_all;
use crate::estimate::solve::canonical_sines;
use crate::problem::solution::Solution;
use nalgebra::DVector;

/// Rows below which a search takes them all at once: a hundred for each unknown of an arm with every effect.
const FEW_ROWS: usize = 20_000;

/// The search before takes every n-th row.
const EVERY: usize = 8;

impl<'a> Minimisation<'a, '_> {
    /// The optimum of the estimator, begun from that of a few of the rows where there are many.
    pub fn run(&self) -> Result<Optimum<'a>, EstimateError> {
        self.canonical_from(self.optimum_of_fewer_rows())
    }

    /// The optimum of the estimator, begun from unknowns that are near it.
    pub fn near(&self, x: DVector<f64>) -> Result<Optimum<'a>, EstimateError> {
        self.canonical_from(Some(Solution::untried(x)))
    }

    fn canonical_from(&self, begun: Option<Solution>) -> Result<Optimum<'a>, EstimateError> {
        let Optimum { solution, problem } = self.from(begun)?;
        Ok(Optimum {
            solution: canonical_sines::canonical(&problem, solution),
            problem,
        })
    }

    /// Where the search over fewer rows ends; `None` for few rows, for what one solution of linear equations settles,
    /// and for models and filters that need every row.
    fn optimum_of_fewer_rows(&self) -> Option<Solution> {
        let recordings = self.training.recordings;
        let linear = self.unknowns.nonlinear.is_empty() && self.model.is_affine();
        let whole = recordings.iter().any(|r| needs_all(self.model, r));
        if linear || whole || counting_rows(recordings) < FEW_ROWS {
            return None;
        }
        let thinned: Vec<Prepared> = recordings.iter().map(|r| r.thinned(EVERY)).collect();
        let fewer = Minimisation {
            model: self.model,
            unknowns: self.unknowns,
            training: Training {
                recordings: &thinned.iter().collect::<Vec<_>>(),
                prior: self.training.prior,
            },
            estimator: self.estimator,
            control: self.control,
        };
        // Rows that do not suffice for a start leave it to the whole.
        Some(fewer.run().ok()?.solution)
    }
}
