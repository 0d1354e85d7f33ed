//! The vocabulary of physics: one file per effect, one table, [`EFFECTS`]; laws of one's own beside it, in a [`Catalogue`].
//!
//! Laws give the torque that the motor has to exert in addition. `sign(v)` means `v/(|v| + w)` with the
//! transition speed w of the joint's Coulomb friction, 0 where it has none.

pub mod asymmetric_friction;
pub mod backlash;
pub mod base_tilt;
pub mod catalogue;
pub mod coulomb_friction;
pub mod drive_gain;
pub mod encoder_offset;
pub mod expression;
pub mod external_contact;
pub mod flank;
pub mod formula;
pub mod joint_elasticity;
pub mod joint_spring;
pub mod kinematic_coupling;
pub mod law;
pub mod load_dependent_friction;
pub mod own;
pub mod position_dependent_friction;
pub mod presliding_hysteresis;
pub mod rotor_inertia;
pub mod sigmoid_friction;
pub mod stribeck_friction;
pub mod thermal_drift;
pub mod time_delay;
pub mod torque_current_nonlinearity;
pub mod torque_offset;
pub mod torque_ripple;
pub mod transmission_efficiency;
pub mod unit;
pub mod unmodelled_payload;
pub mod viscous_friction;
pub mod viscous_nonlinearity;

pub use catalogue::Catalogue;
pub use law::{
    Contribution, Flow, LawDynamics, Power, Samples, Surroundings, TorqueLaw, TransmissionLaw,
    Transmitted,
};
pub use unit::Unit;

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
    pub parameters: &'static [ParameterInfo],
    /// Motion variables that its torque depends on.
    pub depends_on: &'static [Dependence],
    pub confounded_with: &'static [Confounder],
    pub law: Law,
    pub needs: Needs,
}

/// What an effect needs beside its own parameters and the state at one sample.
#[derive(Debug, Clone, Copy)]
pub struct Needs {
    pub memory: Memory,
    /// Parameters of other effects of the same joint, `(effect, parameter)`.
    pub borrows: &'static [(&'static str, &'static str)],
    /// The effect of the same joint whose torque this one takes the place of.
    pub replaces: Option<&'static str>,
    /// Effects of the same joint of which it refines one: where none is there, it would only imitate it. Empty where it
    /// stands alone.
    pub refines: &'static [&'static str],
    pub lasts: Lasts,
    /// Other joints whose motion the law knows, by name, or [`NEXT`] and [`PREVIOUS`].
    pub others: &'static [&'static str],
}

/// The joint behind one in the order of the robot, and the one before it.
pub const NEXT: &str = "next";
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
    None,
    /// The time of the sample: averages over periods hide the effect.
    Time,
    /// The whole course of the motion, in order.
    Course,
}

/// Whether an effect belongs to the robot or to one recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lasts {
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
                | Self::Body
                | Self::Tilt
                | Self::Encoder
                | Self::Delay
        )
    }

    /// Whether a diagnosis looks for it where nobody asks for it by name. A zero that is off is first moments that are other ones
    /// wherever these are unknown, and a matter of calibration where they are known.
    pub fn is_sought(self) -> bool {
        !matches!(self, Self::Encoder)
    }
}

/// A parameter of an effect.
#[derive(Debug, Clone, Copy)]
pub struct ParameterInfo {
    pub name: &'static str,
    pub unit: Unit,
    pub meaning: &'static str,
    pub lower: f64,
    pub upper: f64,
    /// Value from which a nonlinear estimate starts, and a size at which it matters.
    pub typical: f64,
    pub linearity: Linearity,
    pub search: Search,
}

impl ParameterInfo {
    /// A parameter in which the signal is affine, of any sign.
    pub const fn linear(
        (name, unit): (&'static str, Unit),
        meaning: &'static str,
        typical: f64,
    ) -> Self {
        Self {
            name,
            unit,
            meaning,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            typical,
            linearity: Linearity::Linear,
            search: Search::Typical,
        }
    }

    /// A parameter in which the signal is not affine, between limits.
    pub const fn nonlinear(
        (name, unit): (&'static str, Unit),
        meaning: &'static str,
        (lower, typical, upper): (f64, f64, f64),
        search: Search,
    ) -> Self {
        Self {
            name,
            unit,
            meaning,
            lower,
            upper,
            typical,
            linearity: Linearity::Nonlinear,
            search,
        }
    }

    /// The same with other limits.
    pub const fn within(mut self, lower: f64, upper: f64) -> Self {
        (self.lower, self.upper) = (lower, upper);
        self
    }
}

/// Values from which a search for a nonlinear parameter starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Search {
    /// The typical value is good enough.
    Typical,
    Values(&'static [f64]),
    /// Rising values of which all beyond one that is far too large are larger still.
    Rising(&'static [f64]),
    /// Shares of the way from the least to the greatest position of the joint.
    Position(&'static [f64]),
    /// Shares of the range of the joint's positions.
    Range(&'static [f64]),
    /// Shares of the greatest speed of the joint.
    Speed(&'static [f64]),
    /// Multiples of one over the greatest speed of the joint.
    OverSpeed(&'static [f64]),
    /// Shares of the duration of the recording.
    Duration(&'static [f64]),
    /// The same, of what begins or ends then.
    Instant(&'static [f64]),
    /// Cycles over the range of the joint's positions, from one to what the sampling resolves.
    Cycles,
}

/// Whether the signal is affine in a parameter while the others stay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Linearity {
    Linear,
    Nonlinear,
}

/// A variable that an effect's torque varies with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dependence {
    Position,
    Speed,
    Direction,
    Acceleration,
    Load,
    OtherJoints,
    Gravity,
    Time,
    Temperature,
    Current,
    Nothing,
}

impl Dependence {
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
    pub with: &'static str,
    pub separated_by: &'static str,
}

/// Every effect that the tool knows, in the order in which it lists them.
pub const EFFECTS: &[&Effect] = &[
    &coulomb_friction::EFFECT,
    &viscous_friction::EFFECT,
    &asymmetric_friction::EFFECT,
    &stribeck_friction::EFFECT,
    &viscous_nonlinearity::EFFECT,
    &sigmoid_friction::EFFECT,
    &presliding_hysteresis::EFFECT,
    &position_dependent_friction::EFFECT,
    &transmission_efficiency::EFFECT,
    &load_dependent_friction::EFFECT,
    &torque_current_nonlinearity::EFFECT,
    &drive_gain::EFFECT,
    &torque_offset::EFFECT,
    &rotor_inertia::EFFECT,
    &kinematic_coupling::EFFECT,
    &joint_elasticity::EFFECT,
    &backlash::EFFECT,
    &torque_ripple::EFFECT,
    &joint_spring::EFFECT,
    &unmodelled_payload::EFFECT,
    &base_tilt::EFFECT,
    &encoder_offset::EFFECT,
    &time_delay::EFFECT,
    &thermal_drift::EFFECT,
    &external_contact::EFFECT,
];

/// An effect of the vocabulary, or one that was [registered](catalogue::register), by its identifier.
pub fn find(id: &str) -> Option<&'static Effect> {
    Catalogue::known().find(id)
}

/// The identifiers of the vocabulary and of registered effects.
pub fn ids() -> Vec<&'static str> {
    Catalogue::known().ids()
}

#[cfg(test)]
mod tests;
