//! The parameters of a model: what each is, its unit, its value and whether it is known.

use crate::chain::crosstalk::Heard;
use crate::chain::effect::Linearity;

/// What a parameter stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Entry of the ten inertial parameters of a link (project order).
    Inertial {
        /// Position of the link's joint in the tree.
        link: usize,
        /// Which of the ten, from 0.
        quantity: usize,
    },
    /// Entry of the ten inertial parameters of the load.
    Payload {
        /// Which of the ten, from 0.
        quantity: usize,
    },
    /// Parameter of an effect on a joint: positions in `JointModel::effects` and in the effect.
    Effect {
        /// Position of the joint in the tree.
        joint: usize,
        /// Position in [`JointModel::effects`](crate::chain::joint_model::JointModel::effects).
        effect: usize,
        /// Position among the effect's parameters.
        parameter: usize,
    },
    /// Entry of V.
    Coupling {
        /// The joint that is moved.
        row: usize,
        /// The motor that moves it.
        column: usize,
    },
    /// Share of the signal of one joint in what is recorded of another.
    Crosstalk(Heard),
    /// Roll (0) or pitch (1) of the base.
    Tilt {
        /// Rotation about x or y of the base frame, rad.
        angle: usize,
    },
    /// What a component of the base wrench reads without the robot.
    Tare {
        /// Which of fx, fy, fz, mx, my, mz, from 0.
        component: usize,
    },
    /// Gain of a joint's position controller.
    Controller {
        /// Position of the joint in the tree.
        joint: usize,
        /// Which of its gains.
        gain: ControllerGain,
    },
}

/// A gain of a position controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ControllerGain {
    /// Torque per error of the position.
    Proportional,
    /// Torque per error of the speed.
    Derivative,
}

impl Role {
    /// Whether torques are linear in it along a given motion, as in all parameters of bodies.
    pub fn is_inertial(self) -> bool {
        matches!(self, Self::Inertial { .. } | Self::Payload { .. })
    }
}

/// Whether an estimate may change a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It is estimated.
    Free,
    /// It keeps its value.
    Known,
    /// It has the value of the parameter at this position, which is estimated for both.
    Shared(usize),
}

/// One parameter of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// `<link>.<entry>` for inertial parameters (link3.mcx), `<joint>.<effect>.<parameter>` for effects.
    pub name: String,
    /// SI unit of value, limits and scale.
    pub unit: String,
    /// What it stands for.
    pub role: Role,
    /// Whether an estimate may change it.
    pub state: State,
    /// The known value, or the one from which an estimate starts.
    pub value: f64,
    /// Natural limits, or narrower ones that were asked for.
    pub lower: f64,
    /// The upper end of the same; infinity where there is none.
    pub upper: f64,
    /// Limits were asked for: every estimate keeps them. Natural limits of linear parameters (friction is
    /// not negative) are those of feasible estimates; least squares without them shows when a model is
    /// wrong.
    pub bounded: bool,
    /// A change that matters, in the parameter's unit.
    pub scale: f64,
    /// Whether the signal is affine in it.
    pub linearity: Linearity,
}

impl Parameter {
    /// Whether an estimate may change it.
    pub fn is_free(&self) -> bool {
        self.state == State::Free
    }

    /// Whether an estimate without physical constraints keeps the limits.
    pub fn keeps_limits(&self) -> bool {
        self.bounded || self.linearity == Linearity::Nonlinear
    }

    /// Whether a value lies within its limits.
    pub fn is_within_limits(&self, value: f64) -> bool {
        (self.lower..=self.upper).contains(&value)
    }

    /// Whether the signal is affine in it.
    pub fn is_linear(&self) -> bool {
        self.linearity == Linearity::Linear
    }

    /// Free, and the signal is affine in it.
    pub fn is_linear_unknown(&self) -> bool {
        self.is_free() && self.is_linear()
    }

    /// Free, and the signal is not affine in it.
    pub fn is_nonlinear_unknown(&self) -> bool {
        self.is_free() && self.linearity == Linearity::Nonlinear
    }
}
