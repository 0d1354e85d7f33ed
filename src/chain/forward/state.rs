//! What a forward simulation carries from step to step, and what drives it.

use crate::chain::flank::Flank;
use crate::chain::forward::drive::Drive;

/// Motions of the motors and of what lags behind them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// Motors that move at joint scale, then lags, rad (m).
    pub position: Vec<f64>,
    /// Their rates, rad/s (m/s).
    pub velocity: Vec<f64>,
    /// Internal state of the law of each motor that has one, 0 for the others.
    pub memory: Vec<f64>,
}

/// What moves the motors over a step.
#[derive(Debug, Clone, Copy)]
pub enum Driven<'a> {
    /// Torques of the motors at joint scale at both ends, N·m (N), linear between them.
    Torque {
        /// At the start of the step.
        from: &'a [f64],
        /// At its end.
        to: &'a [f64],
    },
    /// What position controllers are [told](super::Told) at both ends, linear between them.
    Command {
        /// At the start of the step, by [`Forward::aim`](super::Forward::aim).
        from: &'a [f64],
        /// At its end.
        to: &'a [f64],
    },
    /// Their accelerations, rad/s² (m/s²), whatever it takes: what lags and what has a memory follow.
    Motion {
        /// One per motor that moves, the same over the step.
        acceleration: &'a [f64],
    },
}

/// A link behind an elastic gear or one with play.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lagging {
    pub joint: usize,
    pub flank: Flank,
}

/// The drives, the links that lag behind them, and what moves the motors.
pub(super) struct Drivetrain<'a> {
    pub drives: &'a mut [Drive],
    pub lags: &'a [Lagging],
    pub driven: Driven<'a>,
}

impl Drivetrain<'_> {
    /// Whether the motion of the motors is given.
    pub fn is_given(&self) -> bool {
        matches!(self.driven, Driven::Motion { .. })
    }

    /// Whether position controllers act.
    pub fn is_controlled(&self) -> bool {
        matches!(self.driven, Driven::Command { .. })
    }

    pub fn has_losses(&self) -> bool {
        self.drives.iter().any(Drive::has_losses)
    }
}

/// A step: its duration, s, and the shares of the time over which a torque is linear at which it begins and ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimeSpan {
    pub duration: f64,
    pub from: f64,
    pub to: f64,
}

impl TimeSpan {
    /// The share of that time at a share of the step.
    pub fn at(self, share: f64) -> f64 {
        self.from + (self.to - self.from) * share
    }
}
