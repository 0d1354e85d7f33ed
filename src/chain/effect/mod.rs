//! The vocabulary of physics: one file per effect, one table, [`EFFECTS`].
//!
//! Laws give the torque that the motor has to exert in addition. `sign(v)` means `v/(|v| + w)` with the
//! transition speed w of the joint's Coulomb friction, 0 where it has none.

pub mod asymmetric_friction;
pub mod coulomb_friction;
pub mod drive_gain;
pub mod kinematic_coupling;
pub mod rotor_inertia;
pub mod torque_offset;
pub mod unmodelled_payload;
pub mod viscous_friction;

use crate::robot::tree::JointKind;

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
}

/// Where in the chain an effect acts, and how.
#[derive(Debug, Clone, Copy)]
pub enum Law {
    /// A torque at the motor.
    Motor(&'static dyn TorqueLaw),
    /// A factor of the signal.
    Gain,
    /// Entries of the matrix V.
    Coupling,
    /// A body on a link.
    Body,
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
}

/// Whether the signal is affine in a parameter while the others stay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Linearity {
    Linear,
    Nonlinear,
}

/// Units that depend on whether the joint turns or slides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    One,
    Torque,
    TorquePerSpeed,
    Inertia,
    Speed,
}

impl Unit {
    /// The unit for a joint of the given kind.
    pub fn of(self, kind: JointKind) -> &'static str {
        let turns = kind == JointKind::Revolute;
        match self {
            Self::One => "1",
            Self::Torque => kind.effort_unit(),
            Self::TorquePerSpeed if turns => "N·m·s/rad",
            Self::TorquePerSpeed => "N·s/m",
            Self::Inertia if turns => "kg·m²",
            Self::Inertia => "kg",
            Self::Speed if turns => "rad/s",
            Self::Speed => "m/s",
        }
    }
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

/// One joint over a block of samples, as a torque law sees it.
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    /// m, ṁ, m̈ of the motor at joint scale.
    pub position: &'a [f64],
    pub velocity: &'a [f64],
    pub acceleration: &'a [f64],
    /// `ṁ/(|ṁ| + w)`.
    pub sign: &'a [f64],
}

/// Where a torque law puts its torque and derivatives.
#[derive(Debug)]
pub struct Contribution<'a> {
    /// The law's torque is added.
    pub torque: &'a mut [f64],
    /// ∂torque/∂parameter is written, one series per parameter of the effect.
    pub by_parameter: &'a mut [Vec<f64>],
    /// ∂torque/∂sign is added: the chain carries it on to w.
    pub by_sign: &'a mut [f64],
}

/// A torque that the motor exerts in addition.
pub trait TorqueLaw: Sync + std::fmt::Debug {
    /// Adds the torque of a block of samples for the effect's parameters.
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>);

    /// What the law does with mechanical power.
    fn power(&self) -> Power;
}

/// What a law does with mechanical power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Power {
    /// Never gives power for parameters within their bounds.
    Dissipates,
    /// Stores power and gives it back, or may do either.
    Exchanges,
}

/// Every effect that the tool knows, in the order in which it lists them.
pub const EFFECTS: &[&Effect] = &[
    &coulomb_friction::EFFECT,
    &viscous_friction::EFFECT,
    &asymmetric_friction::EFFECT,
    &torque_offset::EFFECT,
    &rotor_inertia::EFFECT,
    &drive_gain::EFFECT,
    &kinematic_coupling::EFFECT,
    &unmodelled_payload::EFFECT,
];

/// An effect by its identifier.
pub fn find(id: &str) -> Option<&'static Effect> {
    EFFECTS.iter().find(|effect| effect.id == id).copied()
}

/// The identifiers of the vocabulary.
pub fn ids() -> Vec<&'static str> {
    EFFECTS.iter().map(|effect| effect.id).collect()
}

#[cfg(test)]
mod tests;
