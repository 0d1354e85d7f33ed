//! Feasible estimation: every body physically possible, friction with its sign, limits kept.
//!
//! ```text
//! minimise ½ ‖W (ŝ(x) − s)‖² + γ d(x)   subject to   D J_k(x) D ⪰ margin·1,  rows(x) >= 0,  lower <= x <= upper
//! ```
//!
//! x are the standard parameters; J_k is the 4 x 4 pseudo-inertia, which is positive semidefinite exactly for
//! bodies of nonnegative density (Wensing, Kim and Slotine 2018). A positive definite inertia about the centre
//! of mass alone admits bodies that break the triangle inequality. The residual is compressed by QR. Nonlinear
//! parameters are found by sequential conic steps: each round linearises the residual and keeps the cones. A second way
//! is a chart of the possible bodies and no cones at all.

use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::chain::prior::Prior;
use crate::estimate::error::EstimateError;
use crate::estimate::feasible::feasible_fit::FeasibleFit;
pub use crate::estimate::feasible::feasible_fit::MARGIN;
use crate::estimate::feasible::prior::InertialPrior;
use crate::estimate::feasible::program::Constraints;
use crate::estimate::feasible::regularisation_weight::FitPoint;
use crate::estimate::feasible::solve::{Feasible, Setting, compressed};
use crate::estimate::feasible::standard::StandardParameters;
use crate::estimate::fit::Fitted;
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::fit_problem::problem::{FitProblem, NoiseSource};
use crate::estimate::minimisation::fit_setup::FitSetup;
use crate::estimate::minimisation::optimum::Optimum;
use crate::estimate::residual::weights::Weights;
use crate::estimate::solve::least_squares;
use crate::problem::solution::Control;
use crate::problem_file::choices::{FeasibleBy, PriorKind};
use crate::problem_file::fit::RegularisationWeight;
use crate::setup::combined_limits::Limit;
use nalgebra::DVector;

mod active_bounds;
pub mod chart;
mod feasible_fit;
mod outcome;
pub mod prior;
pub mod program;
mod regularisation_weight;
mod sequential;
pub mod solve;
pub mod standard;

/// Rounds of reweighting.
const MAX_ROUNDS: usize = 10;

/// Reweighting ends when no deviation of a residual changes by more than this share.
const ROUND_TOLERANCE: f64 = 1e-3;

/// How residuals are weighted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Every channel by the deviation of its residual.
    Weighted,
    /// The covariance across channels by the scatter of periods, else as weighted.
    MaximumLikelihood,
}

/// What a feasible fit keeps and prefers.
#[derive(Debug, Clone)]
pub struct Settings {
    /// How channels are weighted.
    pub form: Form,
    /// How bodies are kept possible.
    pub by: FeasibleBy,
    /// What is preferred among bodies that explain the recordings as well, and by how much; none without a prior.
    pub prior: Option<(PriorKind, RegularisationWeight)>,
    /// Limits on combinations of parameters beside those of single ones.
    pub limits: Vec<Limit>,
}

/// Fits a model to the training recordings of a dataset under its physical constraints.
pub fn fit(
    model: &Model,
    data: &Dataset,
    prior: &Prior,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<Fitted, EstimateError> {
    let estimator = match settings.form {
        Form::Weighted => Estimator::Weighted,
        Form::MaximumLikelihood => Estimator::MaximumLikelihood,
    };
    let setup = FitSetup::of(model, data, prior)?;
    let Optimum {
        solution: first,
        mut problem,
    } = setup.minimisation(estimator, control).run()?;
    let standard = StandardParameters::new(model, &setup.unknowns);
    let constraints = Constraints::new(&standard, &settings.limits);
    let bodies = settings
        .prior
        .map(|(kind, _)| InertialPrior::new(kind, &standard, MARGIN));
    let mut chosen = match (&bodies, settings.prior) {
        (Some(bodies), Some((_, choice))) => {
            let point = FitPoint {
                problem: &problem,
                at: &first.x,
            };
            let setting = Setting {
                standard: &standard,
                constraints: &constraints,
                margin: MARGIN,
                prior: Some((bodies, 1.0)),
            };
            Some(regularisation_weight::choose(
                setting, point, choice, data, control,
            )?)
        }
        _ => None,
    };
    let setting = Setting {
        standard: &standard,
        constraints: &constraints,
        margin: MARGIN,
        prior: bodies.as_ref().zip(chosen.as_ref().map(|c| c.weight)),
    };
    let Settled { feasible, free } = rounds(setting, &mut problem, &first.x, settings, control)?;
    let found = FeasibleFit {
        problem,
        standard: &standard,
        constraints: &constraints,
        prior: bodies.as_ref().zip(chosen.take()),
        by: settings.by,
        feasible,
        free,
    };
    Ok(outcome::report(&found, data, control))
}

/// The estimate with settled weights, and the base unknowns of least squares with the same weights.
struct Settled {
    feasible: Feasible,
    free: DVector<f64>,
}

/// Estimate and weights in turn until the weights settle.
fn rounds(
    setting: Setting<'_>,
    problem: &mut FitProblem<'_>,
    first: &DVector<f64>,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<Settled, EstimateError> {
    let minimise = match settings.by {
        FeasibleBy::Cones => sequential::minimise,
        FeasibleBy::LogCholesky => chart::minimise,
    };
    let mut feasible = minimise(setting, problem, first, control)?;
    let mut at = &setting.standard.to_base * &feasible.x;
    for _ in 0..MAX_ROUNDS {
        if problem.noise == NoiseSource::Periods {
            break;
        }
        let covariance = least_squares::covariance_at(problem, &at);
        let weights = Weights::by_deviation(covariance.diagonal().map(f64::sqrt).as_slice());
        let before = problem.weights().matrix();
        let change = (weights.matrix() - &before).amax() / before.amax();
        if change <= ROUND_TOLERANCE || control.is_interrupted() {
            break;
        }
        problem.reweigh(weights);
        let next = minimise(setting, problem, &at, control)?;
        at = &setting.standard.to_base * &next.x;
        feasible = Feasible {
            iterations: feasible.iterations + next.iterations,
            ..next
        };
    }
    let free = compressed(problem, &at)?.least_squares();
    Ok(Settled {
        feasible,
        free: free.unwrap_or_else(|| first.clone()),
    })
}
