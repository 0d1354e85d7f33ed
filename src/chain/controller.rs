//! Position controllers in the place of a torque channel.
//!
//! ```text
//! τ_mot / gain = kp (m_c − m) + kd (v_c − ṁ) + u
//! s = m_c − m = (τ_mot / gain + kd (ṁ − v_c) − u) / kp
//! ```
//!
//! with the commanded position m_c and speed v_c of a motor at joint scale and the torque u that is fed forward (N·m or N).
//! The signal s is the error of the position (rad or m). That way round the noise of the encoder is noise of the signal,
//! and not of a regressor, which would pull kp towards zero. Where nothing tells its size, kp keeps the value that it
//! starts from, and everything in s is a ratio to it: there is no solution of zeros.

use crate::chain::effect::{Linearity, Unit};
use crate::chain::parameter::{ControllerGain, Parameter, Role, State};
use crate::robot::tree::Joint;

/// A gain of a controller, as it is declared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// The known value, or the one from which an estimate starts.
    pub value: f64,
    /// Whether an estimate may change it.
    pub state: State,
}

impl Gain {
    /// A gain that is known.
    pub const fn known(value: f64) -> Self {
        Self {
            value,
            state: State::Known,
        }
    }

    /// A gain that is estimated, from a value on.
    pub const fn free(value: f64) -> Self {
        Self {
            value,
            state: State::Free,
        }
    }
}

/// The position controller of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    /// N·m/rad (N/m).
    pub kp: Gain,
    /// N·m·s/rad (N·s/m).
    pub kd: Gain,
}

/// Least proportional gain, N·m/rad (N/m): a signal is divided by it.
const LEAST_KP: f64 = 1e-9;

impl Controller {
    /// `<joint>.controller.kp` and behind it `<joint>.controller.kd`.
    pub(super) fn parameters(&self, joint: &Joint, index: usize) -> [Parameter; 2] {
        let parameter = |name: &str, gain, of: Gain| Parameter {
            name: format!("{}.controller.{name}", joint.name),
            unit: String::new(),
            role: Role::Controller { joint: index, gain },
            state: of.state,
            value: of.value,
            lower: 0.0,
            upper: f64::INFINITY,
            bounded: false,
            scale: if of.value > 0.0 { of.value } else { 1.0 },
            linearity: Linearity::Linear,
        };
        [
            Parameter {
                unit: Unit::TorquePerPosition.of(joint.kind).to_string(),
                lower: LEAST_KP,
                linearity: Linearity::Nonlinear,
                ..parameter("kp", ControllerGain::Proportional, self.kp)
            },
            Parameter {
                unit: Unit::TorquePerSpeed.of(joint.kind).to_string(),
                ..parameter("kd", ControllerGain::Derivative, self.kd)
            },
        ]
    }
}

impl ControllerGain {
    /// What the gain is, in words for a list of parameters.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Proportional => "torque of the controller per error of the position",
            Self::Derivative => "torque of the controller per error of the speed",
        }
    }
}

/// What controllers are told beside the position, `[joint][sample]`; zero where empty.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Commands {
    /// Speeds of the motors at joint scale, rad/s (m/s).
    pub velocity: Vec<Vec<f64>>,
    /// Torques of the motors at joint scale, N·m (N).
    pub feed_forward: Vec<Vec<f64>>,
}

impl Commands {
    /// Every n-th sample.
    pub fn thinned(&self, n: usize) -> Self {
        self.map(|series| series.iter().step_by(n).copied().collect())
    }

    fn map(&self, of: impl Fn(&Vec<f64>) -> Vec<f64>) -> Self {
        Self {
            velocity: self.velocity.iter().map(&of).collect(),
            feed_forward: self.feed_forward.iter().map(&of).collect(),
        }
    }

    /// The samples over and over, to so many.
    pub fn repeated(&self, samples: usize) -> Self {
        self.map(|series| series.iter().cycle().take(samples).copied().collect())
    }

    /// The same from a sample on.
    pub fn from_sample(&self, start: usize) -> CommandsFrom<'_> {
        CommandsFrom {
            commands: self,
            start,
        }
    }
}

/// Commands from a sample on.
#[derive(Debug, Clone, Copy)]
pub struct CommandsFrom<'a> {
    commands: &'a Commands,
    start: usize,
}

impl<'a> CommandsFrom<'a> {
    /// The same from a later sample on.
    pub fn later(self, samples: usize) -> Self {
        Self {
            start: self.start + samples,
            ..self
        }
    }

    /// Commanded speed of a joint, empty where it is zero.
    pub fn velocity(self, joint: usize) -> &'a [f64] {
        self.of(&self.commands.velocity, joint)
    }

    /// Torque that is fed forward to a joint, empty where it is zero.
    pub fn feed_forward(self, joint: usize) -> &'a [f64] {
        self.of(&self.commands.feed_forward, joint)
    }

    fn of(self, series: &'a [Vec<f64>], joint: usize) -> &'a [f64] {
        let own = series
            .get(joint)
            .and_then(|series| series.get(self.start..));
        own.unwrap_or(&[])
    }
}
