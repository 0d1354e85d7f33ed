//! Recordings by the names of a problem file, and as they were read.

use crate::chain::model::Model;
use crate::problem_file::RecordingsTable;
use crate::problem_file::recordings::RecordingFiles;
use crate::recording::samples::Recording;
use crate::recording::split::Split;
use crate::setup::robot::Robot;

/// The robot that recordings are of, and what the problem file says of them.
#[derive(Debug, Clone, Copy)]
pub struct RecordedRobot<'a> {
    /// `[recordings]` of the problem file.
    pub table: &'a RecordingsTable,
    /// As the problem has it.
    pub robot: &'a Robot,
    /// With its motors and channels.
    pub model: &'a Model,
}

/// A recording that the problem file names.
#[derive(Debug, Clone)]
pub struct NamedRecording<'a> {
    /// Its files, as the problem names them.
    pub path: &'a RecordingFiles,
    /// Whether it is fitted or held out.
    pub split: Split,
    /// A load that the model has hangs on the robot.
    pub loaded: bool,
}

/// A recording as it was read.
#[derive(Debug, Clone)]
pub struct ReadRecording<'a> {
    /// As the problem names it.
    pub named: NamedRecording<'a>,
    /// What was read.
    pub recording: Recording,
}
