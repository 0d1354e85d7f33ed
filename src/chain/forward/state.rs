//! What a forward simulation carries from step to step, and what drives it.

use crate::chain::flank::Flank;

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
