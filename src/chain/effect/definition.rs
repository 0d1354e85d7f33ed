//! The definition of an effect: its law and source, what it needs, and what it is confounded with.

use crate::chain::effect::knowledge::Knowledge;
use crate::chain::effect::law::{TorqueLaw, TransmissionLaw};
use crate::chain::effect::parameter::ParameterInfo;

/// A physical effect of the vocabulary.
#[derive(Debug, Clone, Copy)]
pub struct Effect {
    /// Identifier in problem files and results.
    pub id: &'static str,
    /// One sentence of physics.
    pub sentence: &'static str,
    /// The law in plain text.
    pub equation: &'static str,
    /// Author, year and equation.
    pub source: &'static str,
    /// In the order in which its law takes them.
    pub parameters: &'static [ParameterInfo],
    /// Motion variables that its torque depends on.
    pub depends_on: &'static [Dependence],
    /// What it can be mistaken for.
    pub confounded_with: &'static [Confounder],
    /// Where it acts, and its torque as a function of the motion.
    pub law: Law,
    /// What it needs beside its parameters and the state at one sample.
    pub needs: Needs,
    /// What is known of it beyond its law.
    pub knowledge: Knowledge,
}

impl Effect {
    /// A torque at the motor of which no more is stated than its parameters and law. The rest is left empty, to be filled in by
    /// `Effect { sentence: "…", ..Effect::at_motor(…) }`.
    pub const fn at_motor(
        id: &'static str,
        parameters: &'static [ParameterInfo],
        law: &'static dyn TorqueLaw,
    ) -> Self {
        Self {
            id,
            sentence: "",
            equation: "",
            source: "",
            parameters,
            depends_on: &[],
            confounded_with: &[],
            law: Law::Motor(law),
            needs: Needs::NOTHING,
            knowledge: Knowledge::NONE,
        }
    }
}

/// What an effect needs beside its own parameters and the state at one sample.
#[derive(Debug, Clone, Copy)]
pub struct Needs {
    /// What of the past its law has to know.
    pub memory: Memory,
    /// Parameters of other effects of the same joint, `(effect, parameter)`.
    pub borrows: &'static [(&'static str, &'static str)],
    /// The effect of the same joint whose torque this one takes the place of.
    pub replaces: Option<&'static str>,
    /// Effects of the same joint of which it refines one: where none is there, it would only imitate it. Empty where it
    /// stands alone.
    pub refines: &'static [&'static str],
    /// Whether the next recording has the same parameters.
    pub lasts: Lasts,
    /// Other joints whose motion the law knows, by name, or [`NEXT`] and [`PREVIOUS`].
    pub others: &'static [&'static str],
}

/// The joint behind one in the order of the robot, and the one before it.
pub const NEXT: &str = "next";

/// The joint before one in the order of the robot.
pub const PREVIOUS: &str = "previous";

impl Needs {
    /// The state at one sample is enough, and the effect belongs to the robot.
    pub const NOTHING: Self = Self {
        memory: Memory::None,
        borrows: &[],
        replaces: None,
        refines: &[],
        lasts: Lasts::Always,
        others: &[],
    };
}

/// What of the past a law has to know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Memory {
    /// Nothing: the state at one sample is enough.
    None,
    /// The time of the sample: averages over periods hide the effect.
    Time,
    /// The whole motion, in order.
    WholeMotion,
}

/// Whether an effect belongs to the robot or to one recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lasts {
    /// Its parameters are the robot's, the same in every recording.
    Always,
    /// Its parameters are other ones in the next recording.
    OneRecording,
}

/// Where in the chain an effect acts, and how.
#[derive(Debug, Clone, Copy)]
pub enum Law {
    /// A torque at the motor.
    Motor(&'static dyn TorqueLaw),
    /// A torque at the joint.
    Joint(&'static dyn TorqueLaw),
    /// A loss between motor and joint.
    Transmission(&'static dyn TransmissionLaw),
    /// What a signal shows beyond the torque of its motor.
    Signal(&'static dyn TransmissionLaw),
    /// A factor of the signal.
    Gain,
    /// The polynomial from current to torque.
    Current,
    /// Entries of the matrix V.
    Coupling,
    /// Shares of other joints' signals in what is recorded of one.
    Crosstalk,
    /// A body on a link.
    Body,
    /// The direction of gravity.
    Tilt,
    /// The zero of the joint's positions.
    Encoder,
    /// A spring between motor and link: the link filters the motor's motion.
    Spring,
    /// Play between motor and link.
    Play,
    /// A delay of the signal.
    Delay,
}

impl Law {
    /// Whether the torque stays affine in the inertial parameters when the effect's own are fixed.
    pub fn keeps_affine(self) -> bool {
        matches!(
            self,
            Self::Motor(_)
                | Self::Joint(_)
                | Self::Gain
                | Self::Coupling
                | Self::Crosstalk
                | Self::Body
                | Self::Tilt
                | Self::Encoder
                | Self::Delay
        )
    }

    /// Whether joints stand elsewhere than their motors because of it: what else their loops move would have to follow.
    pub fn moves_joints(self) -> bool {
        matches!(
            self,
            Self::Coupling | Self::Encoder | Self::Spring | Self::Play
        )
    }

    /// Whether it acts on an ordered pair of joints, with one parameter that is named after the second.
    pub fn is_of_pairs(self) -> bool {
        matches!(self, Self::Coupling | Self::Crosstalk)
    }

    /// Whether a diagnosis looks for it where nobody asks for it by name. A zero that is off is first moments that are other
    /// ones wherever these are unknown, and a matter of calibration where they are known.
    pub fn is_sought(self) -> bool {
        !matches!(self, Self::Encoder)
    }
}

/// A variable that an effect's torque varies with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dependence {
    /// Of the motor or joint.
    Position,
    /// Size of the velocity.
    Speed,
    /// Sign of the velocity.
    Direction,
    /// Of the motor or joint.
    Acceleration,
    /// What the gear transmits.
    Load,
    /// Positions or velocities of other joints.
    OtherJoints,
    /// Posture, through the weight of the links.
    Gravity,
    /// Since the start of the recording.
    Time,
    /// As recorded with the joint.
    Temperature,
    /// The motor's.
    Current,
    /// It is constant.
    Nothing,
}

impl Dependence {
    /// As catalogue and problem files show it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Speed => "speed",
            Self::Direction => "direction of motion",
            Self::Acceleration => "acceleration",
            Self::Load => "transmitted torque",
            Self::OtherJoints => "motion of other joints",
            Self::Gravity => "gravity",
            Self::Time => "time",
            Self::Temperature => "temperature",
            Self::Current => "current",
            Self::Nothing => "nothing: constant",
        }
    }
}

/// What an effect can be mistaken for, and the motion that tells them apart.
#[derive(Debug, Clone, Copy)]
pub struct Confounder {
    /// Identifier of the other effect.
    pub with: &'static str,
    /// The motion that does, in words.
    pub separated_by: &'static str,
}
