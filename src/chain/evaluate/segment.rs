//! A segment of a recording: the motion that an evaluator takes at once.

use crate::chain::controller::CommandsFrom;
use crate::chain::evaluate::known_bodies::KnownBodies;
use crate::robot::batch::Trajectory;
use std::ops::Range;

/// Samples that an evaluator takes at once: the block stays in the second-level cache.
pub const BLOCK: usize = 64;

/// Motion of the motors at joint scale, `[joint][sample]`, and what the robot carries.
#[derive(Debug, Clone, Copy)]
pub struct Segment<'a> {
    /// Position, velocity and acceleration of the motors.
    pub motors: Trajectory<'a>,
    /// Known forces of the surroundings on the links along their joints, `[joint][sample]`, N·m (N); empty
    /// where there are none.
    pub forces: &'a [Vec<f64>],
    /// What controllers are told beside the position; `None` where there is nothing.
    pub commands: Option<CommandsFrom<'a>>,
    /// What the bodies do, where it is known already.
    pub bodies: Option<&'a KnownBodies>,
    /// s from the start of the recording, one per sample; empty for states that stand alone.
    pub time: &'a [f64],
    /// °C, `[joint][sample]`; empty where none was recorded.
    pub temperature: &'a [Vec<f64>],
    /// The samples are one period of a motion that repeats.
    pub cyclic: bool,
    /// The load hangs on the robot.
    pub loaded: bool,
}

impl<'a> Segment<'a> {
    /// States that stand alone.
    pub fn states(motors: Trajectory<'a>, loaded: bool) -> Self {
        Self {
            motors,
            forces: &[],
            commands: None,
            bodies: None,
            time: &[],
            temperature: &[],
            cyclic: false,
            loaded,
        }
    }

    /// s from sample to sample on the average; of two samples or more.
    pub fn step(&self) -> f64 {
        let last = self.time.len() - 1;
        (self.time[last] - self.time[0]) / last as f64
    }

    /// Times of some samples, empty where there are none.
    pub(super) fn times(&self, range: Range<usize>) -> &'a [f64] {
        self.time.get(range).unwrap_or(&[])
    }

    /// Temperatures of a joint over some samples, empty where there are none.
    pub(super) fn temperatures(&self, joint: usize, range: Range<usize>) -> &'a [f64] {
        let own = self.temperature.get(joint);
        own.and_then(|series| series.get(range)).unwrap_or(&[])
    }
}
