//! The kinds of measured signal.

use crate::robot::regressor::Rows;

/// What the signal is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// Motor currents, A.
    Current,
    /// Motor torques at joint scale, N·m or N.
    Torque,
    /// Torques of sensors behind the gears: rotors are not in them.
    LinkTorque,
    /// Force and moment of the base on the first link, N and N·m.
    BaseWrench,
    /// Motor torques, then base wrench.
    Both,
    /// Errors of position controllers, command minus position, rad or m.
    PositionCommand,
}

impl Signal {
    /// Whether the currents or torques of motors are measured, each in a channel of its own.
    pub fn has_channels_of_motors(self) -> bool {
        matches!(
            self,
            Self::Current | Self::Torque | Self::LinkTorque | Self::Both
        )
    }

    /// Rows of the rigid-body regressor that the signal needs.
    pub fn rows(self) -> Rows {
        match self {
            Self::Current | Self::Torque | Self::LinkTorque | Self::PositionCommand => Rows::Torque,
            Self::BaseWrench => Rows::Base,
            Self::Both => Rows::Both,
        }
    }
}
