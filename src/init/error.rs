//! Why no problem file can be drafted.

use crate::problem_file::ProblemFileError;
use crate::recording::error::RecordingError;
use crate::robot::error::RobotError;
use std::path::PathBuf;
use thiserror::Error;

/// What is missing or cannot be read.
#[derive(Debug, Error)]
pub enum InitError {
    /// The robot's description cannot be read.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// A recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The draft itself is no problem file.
    #[error(transparent)]
    Draft(#[from] ProblemFileError),
    /// No recording is named.
    #[error("no recordings are given; name at least one")]
    NoRecordings,
    /// A recording has no column for the joints that is known by its name.
    #[error(
        "{}: no column is known by its name to hold {what} of the joints {}; it has {}. Name them, as with \
         --column 'position=NAME{{n}}' --column 'current=NAME{{n}}', where {{n}} is the number of a joint",
        file.display(), joints.join(", "), present.join(", ")
    )]
    NoChannel {
        /// The recording.
        file: PathBuf,
        /// What the column would hold.
        what: &'static str,
        /// Joints of the robot.
        joints: Vec<String>,
        /// Columns of the recording.
        present: Vec<String>,
    },
    /// A column that is named is not in the recording.
    #[error("{}: it has no column `{column}`; it has {}", file.display(), present.join(", "))]
    NoColumn {
        /// The recording.
        file: PathBuf,
        /// What was named.
        column: String,
        /// Columns of the recording.
        present: Vec<String>,
    },
    /// A recording without time stamps and velocities.
    #[error(
        "{}: there are neither time stamps nor velocities, so that nothing tells the rate; state it with --rate, in Hz, or name the \
         column of the stamps with --column time=NAME", file.display()
    )]
    NoTimeBase {
        /// The recording.
        file: PathBuf,
    },
}

impl InitError {
    /// Whether a recording or robot file is at fault.
    pub fn concerns_data(&self) -> bool {
        !matches!(self, Self::Draft(_) | Self::NoRecordings)
    }
}
