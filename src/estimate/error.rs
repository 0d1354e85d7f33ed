//! Why an estimate cannot be made.

use crate::chain::error::ModelError;
use crate::problem::error::ProblemError;
use crate::solve::error::SolveError;
use thiserror::Error;

/// A fit that cannot start or finish.
#[derive(Debug, Error)]
pub enum EstimateError {
    /// No recording is to be fitted.
    #[error("there is no training recording; name at least one under `recordings.train`")]
    NoTraining,
    /// Fewer rows than unknown parameters.
    #[error(
        "{rows} samples for {unknowns} unknown parameters; record more, or fix parameters under `drive.values`"
    )]
    TooFewRows {
        /// Rows of all recordings, all channels counted.
        rows: usize,
        /// Parameters to be estimated.
        unknowns: usize,
    },
    /// Every parameter is given.
    #[error(
        "nothing is unknown: every parameter of the model is given; free some, or use `exid simulate`"
    )]
    NothingUnknown,
    /// A bound is asked for on a parameter that the data determine only together with others.
    #[error(
        "`{name}` cannot be bounded by itself: the data determine it only within {expression}; \
         use `estimator = \"feasible\"`, or bound what is determined"
    )]
    BoundOnCombination {
        /// Name of the parameter.
        name: String,
        /// The combination that the data determine.
        expression: String,
    },
    /// The covariance of the residuals is singular.
    #[error(
        "the covariance of the residuals cannot be factorised; a channel is constant or two are the same"
    )]
    SingularResiduals,
    /// A prior is to be weighed against noise that nothing tells.
    #[error(
        "no recording repeats its motion, so nothing tells the noise that `fit.prior.strength = \"noise\"` needs; \
         state recordings.period, or use \"held_out\" or a number"
    )]
    NoNoiseLevel,
    /// Noise of the motion is to be told from periods, and a recording has none.
    #[error(
        "`fit.motion = \"noisy\"` needs the scatter of periods, and {recording} has none; state recordings.period \
         and record two periods or more, without recordings.differentiation.parallel_hz"
    )]
    MotionWithoutPeriods {
        /// Name of the recording.
        recording: String,
    },
    /// Noisy motions, and a law whose torque depends on the motion before.
    #[error(
        "`fit.motion = \"noisy\"` does not go with a law that remembers the course of the motion; leave it out of \
         drive.effects or use `motion = \"exact\"`"
    )]
    MotionWithMemory,
    /// A limit that the coordinates of possible bodies cannot keep.
    #[error(
        "`fit.feasible_by = \"log_cholesky\"` does not keep the limit {name}; use \"cones\", or leave the limit out"
    )]
    LimitInChart {
        /// What is limited.
        name: String,
    },
    /// A body of which some parameters are given has no such coordinates.
    #[error(
        "`fit.feasible_by = \"log_cholesky\"` needs all ten parameters of {body} unknown, and some are given; use \"cones\""
    )]
    PartOfBodyInChart {
        /// Name of the link or load.
        body: String,
    },
    /// A load by difference needs recordings without it and with it.
    #[error(
        "`fit.load = \"difference\"` needs `robot.payload`, and recordings without the load under `recordings.train` \
         beside those with it under `recordings.loaded`"
    )]
    NoDifference,
    /// The model cannot be built or changed as the fit needs.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The problem has not the form that a solver needs.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// A solver cannot start.
    #[error(transparent)]
    Solve(#[from] SolveError),
}
