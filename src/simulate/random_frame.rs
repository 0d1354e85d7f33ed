//! Inputs of a random path: limits, period, harmonics.

use crate::chain::model::Model;
use crate::setup::limits::JointLimits;

/// Motions that do not repeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Tones,
    Moves,
    Sweeps,
}

/// Share of every limit that a random trajectory uses: room for the tracking error and for the peaks
/// between the instants that are looked at.
pub const SHARE: f64 = 0.8;

/// What a random path is drawn from.
pub struct Frame<'a> {
    /// The commanded torque of everything that acts.
    pub plant: &'a Model,
    /// What the planner takes for the way from motors to joints.
    pub nominal: &'a Model,
    pub limits: &'a [JointLimits],
    pub harmonics: usize,
    /// s.
    pub period: f64,
    pub shape: Shape,
}

/// What kind of motion is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    Fourier,
    /// Does not repeat; lasts `duration` s.
    Aperiodic {
        kind: Kind,
        duration: f64,
    },
}
