//! Why the models of a result are not rolled out.

use crate::chain::forward::NotForward;
use crate::setup::error::SetupError;
use thiserror::Error;

/// A rollout that cannot start or finish.
#[derive(Debug, Error)]
pub enum RolloutError {
    /// The problem, its robot or its recordings.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The result identifies no robot.
    #[error(
        "a result of `{verb}` holds no robot that was identified; give the results folder of `exid fit` or `exid diagnose`"
    )]
    NoRobot {
        /// Verb of the result.
        verb: &'static str,
    },
    /// The result does not hold its model in full.
    #[error(
        "the result does not hold its model in full, as results of this version do; make it again: exid {verb} {problem}"
    )]
    Incomplete {
        /// Verb of the result.
        verb: &'static str,
        /// Its problem file.
        problem: String,
    },
    /// Motor constants from constant speed are no model of a motion.
    #[error(
        "the result was made with motor constants from constant speed, which is no model of a motion; fit with another estimator"
    )]
    ConstantVelocity,
    /// No motion follows from the signal.
    #[error("no forward simulation: {0}")]
    Forward(#[from] NotForward),
    /// No held-out recording is long enough without gaps.
    #[error(
        "no held-out recording has {seconds} s without gaps, which is the shortest window; record for longer, or mask less"
    )]
    NoWindow {
        /// Length of the shortest window, s.
        seconds: f64,
    },
    /// Nothing had been simulated when the interrupt came.
    #[error("interrupted; nothing is written")]
    Interrupted,
}

impl RolloutError {
    /// The fault of files behind it, if that is what it is.
    pub fn setup(&self) -> Option<&SetupError> {
        match self {
            Self::Setup(error) => Some(error),
            _ => None,
        }
    }

    /// Whether it was interrupted.
    pub fn is_interrupt(&self) -> bool {
        match self {
            Self::Interrupted => true,
            Self::Setup(error) => error.is_interrupt(),
            _ => false,
        }
    }

    /// Whether a recording or robot file is at fault, and not the command line.
    pub fn concerns_data(&self) -> bool {
        match self {
            Self::Setup(error) => error.concerns_data(),
            Self::NoWindow { .. } => true,
            _ => false,
        }
    }
}
