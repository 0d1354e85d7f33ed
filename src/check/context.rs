//! The context of checks: the problem, a recording as it was read, a prepared recording.

use crate::chain::dataset::Prepared;
use crate::chain::model::Model;
use crate::check::regression::Comparison;
use crate::fault::Place;
use crate::outcome::check::Mistake;
use crate::problem_file::choices::{PositionSide, Signal};
use crate::problem_file::{ProblemFile, RecordingsTable};
use crate::recording::error::RecordingError;
use crate::recording::samples::Recording;
use crate::recording::timing::{Timing, examine};
use crate::robot::tree::{Joint, JointKind};
use crate::setup::robot::Robot;

/// The problem that recordings are checked for.
pub(super) struct CheckContext<'a> {
    pub problem: &'a ProblemFile,
    pub table: &'a RecordingsTable,
    pub robot: &'a Robot,
    /// Joints of the tree that recordings hold, in the order of their channels.
    pub moving: Vec<usize>,
}

impl<'a> CheckContext<'a> {
    pub fn new(problem: &'a ProblemFile, table: &'a RecordingsTable, robot: &'a Robot) -> Self {
        let moving = (0..robot.tree.len()).filter(|&k| robot.locked[k].is_none());
        Self {
            problem,
            table,
            robot,
            moving: moving.collect(),
        }
    }

    /// The joint that the channel with this index among the recorded joints belongs to.
    pub fn joint(&self, index: usize) -> &Joint {
        &self.robot.tree.joints()[self.moving[index]]
    }

    /// Factor from recorded positions to joint positions.
    pub fn position_factor(&self, index: usize) -> f64 {
        match (&self.robot.ratio, self.table.position_side.value) {
            (Some(ratio), PositionSide::Motor) => 1.0 / ratio[self.moving[index]],
            _ => 1.0,
        }
    }

    /// Whether recorded positions are those of the joints: the coupling is the identity.
    pub fn is_uncoupled(&self) -> bool {
        self.problem.drive.coupling.is_none()
    }

    /// What `q = V m + offset` adds to a recorded position.
    pub fn position_offset(&self, index: usize) -> f64 {
        let offsets = self
            .robot
            .per_joint(&self.problem.drive.offset)
            .ok()
            .flatten();
        match self.table.position_side.value {
            PositionSide::Link => 0.0,
            _ => offsets.map_or(0.0, |offsets| offsets[self.moving[index]]),
        }
    }

    pub fn is_revolute(&self, index: usize) -> bool {
        self.joint(index).kind == JointKind::Revolute
    }
}

/// A recording as it was read.
pub(super) struct RawRecording<'a> {
    pub context: &'a CheckContext<'a>,
    pub recording: &'a Recording,
    pub timing: Timing,
}

impl<'a> RawRecording<'a> {
    /// Errors: those of the time base.
    pub fn new(
        context: &'a CheckContext<'a>,
        recording: &'a Recording,
    ) -> Result<Self, RecordingError> {
        let timing = examine(recording, context.table.rate.as_ref().map(|r| r.value))?;
        Ok(Self {
            context,
            recording,
            timing,
        })
    }

    pub fn place(&self) -> Place {
        Place::file(&self.recording.file)
    }

    /// The place of a joint's channel.
    pub fn at_joint(&self, index: usize) -> Place {
        self.place().key(&self.context.joint(index).name)
    }

    /// The place of a channel of the signal.
    pub fn at_signal(&self, channel: usize) -> Place {
        const WRENCH: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];
        let joints = match self.context.table.signal.value {
            Signal::BaseWrench => 0,
            _ => self.context.moving.len(),
        };
        match channel.checked_sub(joints) {
            Some(component) => self.place().key(WRENCH[component % 6]),
            None => self.at_joint(channel),
        }
    }

    pub fn samples(&self) -> usize {
        self.recording.position.first().map_or(0, Vec::len)
    }

    /// Time of a sample from the first, s.
    pub fn time(&self, sample: usize) -> f64 {
        match &self.recording.time {
            Some(time) => time[sample] - time[0],
            None => sample as f64 / self.timing.rate_hz,
        }
    }

    /// Whether the mask lets a sample count.
    pub fn counts(&self, sample: usize) -> bool {
        self.recording.mask.as_ref().is_none_or(|mask| mask[sample])
    }
}

/// A recording made ready, beside the model.
pub(super) struct PreparedRecording<'a> {
    pub context: &'a CheckContext<'a>,
    pub model: &'a Model,
    pub prepared: &'a Prepared,
    /// The signal against a model with every inertial parameter, rotor and simple friction free.
    pub comparison: Comparison,
    /// Another reading of the columns, where it explains the signal far better.
    pub other_reading: Vec<Mistake>,
}

impl<'a> PreparedRecording<'a> {
    pub fn new(context: &'a CheckContext<'a>, model: &'a Model, prepared: &'a Prepared) -> Self {
        Self {
            comparison: Comparison::new(model, prepared),
            context,
            model,
            prepared,
            other_reading: Vec::new(),
        }
    }

    pub fn place(&self) -> Place {
        Place::file(&self.prepared.experiment.file)
    }

    /// The place of a channel of the signal.
    pub fn at_channel(&self, channel: usize) -> Place {
        self.place().key(&self.model.channels()[channel].name)
    }

    /// The place of a joint, whatever the signal is.
    pub fn at_channel_of(&self, joint: usize) -> Place {
        self.place().key(&self.model.joints()[joint].name)
    }
}
