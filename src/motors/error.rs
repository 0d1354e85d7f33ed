//! Why motor constants cannot be fitted.

use thiserror::Error;

use crate::setup::error::SetupError;

/// A fault of the problem file or of what it names.
#[derive(Debug, Error)]
pub enum MotorsError {
    /// The problem, its robot or its recordings.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The problem file asks for what this fit does not do.
    #[error("{place}: {message}; {remedy}")]
    Setting {
        /// The key of the problem file.
        place: String,
        /// What is asked for.
        message: String,
        /// What to do instead.
        remedy: String,
    },
    /// No part of a recording is steady.
    #[error(
        "{file}: no part of the recording is steady, one joint at constant speed while all others stand; \
         record such motions, or lower fit.constant_velocity.least_speed from {least_speed}"
    )]
    NothingSteady {
        /// The recording.
        file: String,
        /// Least speed that was looked for, rad/s (m/s).
        least_speed: f64,
    },
}

impl MotorsError {
    /// The fault of files behind it, if that is what it is.
    pub fn setup(&self) -> Option<&SetupError> {
        match self {
            Self::Setup(error) => Some(error),
            _ => None,
        }
    }

    /// Whether a recording or robot file is at fault, or the problem file.
    pub fn concerns_data(&self) -> bool {
        match self {
            Self::Setup(error) => error.concerns_data(),
            Self::Setting { .. } => false,
            Self::NothingSteady { .. } => true,
        }
    }
}
