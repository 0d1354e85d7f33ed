//! The signal path from the torque of a joint to the signal of a channel, and which part of it a hypothesis leaves unchanged.

use crate::chain::effect::Law;
use crate::chain::model::{Channel, JointModel, Model, Signal};
use crate::diagnose::fit::hypothesis::Hypothesis;

/// What lies between the motors and the channels of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignalPath {
    /// Every channel is the torque of one motor that its joint follows at once.
    Simple,
    /// The same, but that links lag their motors.
    Lagging,
    /// The same as a simple one, but that signals are late.
    Late,
    /// Motors are coupled, signals heard by other channels, joints driven together, or signals late of links that lag.
    Other,
}

impl SignalPath {
    /// Of a model, by its coupling, loops, crosstalk, delays and lags.
    pub fn of(model: &Model) -> Self {
        let own = |(c, channel): (usize, &Channel)| channel.joint == Some(c);
        let is_plain = model.is_uncoupled()
            && model.mechanism().is_none()
            && model.heard().next().is_none()
            && model.channels().iter().enumerate().all(own);
        let is_late = model.joints().iter().any(|joint| joint.delay.is_some());
        let has_lag = model.joints().iter().any(JointModel::has_lag);
        let is_command = model.signal() == Signal::PositionCommand;
        match (is_plain, is_late, has_lag) {
            (true, false, false) => Self::Simple,
            (true, false, true) => Self::Lagging,
            (true, true, false) if !is_command => Self::Late,
            _ => Self::Other,
        }
    }

    /// Whether a hypothesis acts on the channels of its own joints alone, and leaves motion and bodies as they are.
    pub fn leaves_others(self, model: &Model, hypothesis: &Hypothesis) -> bool {
        let joints = hypothesis.joints.iter();
        let lags = joints.clone().any(|&j| model.joints()[j].has_lag());
        let is_of_drive = match hypothesis.effect.law {
            Law::Motor(_)
            | Law::Transmission(_)
            | Law::Signal(_)
            | Law::Crosstalk
            | Law::Gain
            | Law::Current => true,
            // A torque at a joint moves a link that lags.
            Law::Joint(_) => !lags,
            _ => false,
        };
        self != Self::Other && is_of_drive
    }

    /// Whether what the bodies do along the motion as it was recorded is known for a hypothesis.
    pub fn knows_bodies(self, model: &Model, hypothesis: &Hypothesis) -> bool {
        let lags = matches!(hypothesis.effect.law, Law::Spring | Law::Play);
        match self {
            Self::Simple => lags || self.leaves_others(model, hypothesis),
            Self::Lagging => self.leaves_others(model, hypothesis),
            Self::Late | Self::Other => false,
        }
    }
}
