//! A recording that a problem names, and what was read of it.

use crate::problem_file::recordings::RecordingFiles;
use crate::recording::samples::Recording;
use crate::recording::split::Split;

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
