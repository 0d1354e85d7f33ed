//! Why an estimate cannot be made.

use crate::chain::error::ModelError;
use crate::problem::error::ProblemError;
use crate::solve::error::SolveError;
use thiserror::Error;

/// A fit that cannot start or finish.
#[derive(Debug, Error)]
pub enum EstimateError {
    #[error("there is no training recording; name at least one under `recordings.train`")]
    NoTraining,
    #[error(
        "{rows} samples for {unknowns} unknown parameters; record more, or fix parameters under `drive.values`"
    )]
    TooFewRows { rows: usize, unknowns: usize },
    #[error(
        "nothing is unknown: every parameter of the model is given; free some, or use `exid simulate`"
    )]
    NothingUnknown,
    #[error(
        "`{name}` cannot be bounded by itself: the data determine it only within {expression}; \
         use `estimator = \"feasible\"`, or bound what is determined"
    )]
    BoundOnCombination { name: String, expression: String },
    #[error(
        "the covariance of the residuals cannot be factorised; a channel is constant or two are the same"
    )]
    SingularResiduals,
    #[error(
        "no recording repeats its motion, so nothing tells the noise that `fit.prior.strength = \"noise\"` needs; \
         state recordings.period, or use \"held_out\" or a number"
    )]
    NoNoiseLevel,
    #[error(
        "`fit.motion = \"noisy\"` needs the scatter of periods, and {recording} has none; state recordings.period \
         and record two periods or more, without recordings.differentiation.parallel_hz"
    )]
    MotionWithoutPeriods { recording: String },
    #[error(
        "`fit.motion = \"noisy\"` does not go with a law that remembers the course of the motion; leave it out of \
         drive.effects or use `motion = \"exact\"`"
    )]
    MotionWithMemory,
    #[error(
        "`fit.feasible_by = \"log_cholesky\"` does not keep the limit {name}; use \"cones\", or leave the limit out"
    )]
    LimitInChart { name: String },
    #[error(
        "`fit.feasible_by = \"log_cholesky\"` needs all ten parameters of {body} unknown, and some are given; use \"cones\""
    )]
    PartOfBodyInChart { body: String },
    #[error(
        "`fit.load = \"difference\"` needs `robot.payload`, and recordings without the load under `recordings.train` \
         beside those with it under `recordings.loaded`"
    )]
    NoDifference,
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error(transparent)]
    Problem(#[from] ProblemError),
    #[error(transparent)]
    Solve(#[from] SolveError),
}
