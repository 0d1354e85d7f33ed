//! The text of a user-defined law as a problem file states it.

use crate::robot::inertia::PER_LINK;

/// Parameters that a law may have: as many as the longest effect of the vocabulary, for which evaluations have room.
pub const MOST_PARAMETERS: usize = PER_LINK;

/// A law as it is written.
#[derive(Debug, Clone, PartialEq)]
pub struct LawText {
    /// Identifier in problem files and results.
    pub id: String,
    /// One sentence of physics.
    pub sentence: String,
    /// Author, year and equation; empty where it has none.
    pub source: String,
    /// Where in the chain it acts.
    pub acts_on: ActsOn,
    /// The formula: N·m (N); of a gain a factor.
    pub torque: String,
    /// States z1, z2, ... in the order in which formulas number them.
    pub states: Vec<StateText>,
    /// In the order in which results list them.
    pub parameters: Vec<ParameterText>,
    /// Effects of which it refines one: without any of them it is not looked for.
    pub refines: Vec<String>,
}

/// Where in the chain a law acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActsOn {
    /// A torque that the motor exerts in addition.
    Motor,
    /// A torque at the joint, which an elastic gear passes on.
    Joint,
    /// What the signal shows beyond the torque of the motor.
    Signal,
    /// The true torque constant over the declared one.
    Gain,
}

/// A state of a law.
#[derive(Debug, Clone, PartialEq)]
pub struct StateText {
    /// `dz/dt` as a formula in v, z and parameters.
    pub rate: String,
    /// Its first value as a formula in v and parameters; 0 where it is not stated.
    pub start: Option<String>,
}

/// A parameter of a law.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterText {
    /// Name in formulas and results.
    pub name: String,
    /// Nothing where it is not stated: it is then not checked.
    pub unit: Option<String>,
    /// In a few words; may be empty.
    pub meaning: String,
    /// Least value, in its unit; minus infinity where there is no limit.
    pub lower: f64,
    /// Greatest value; infinity where there is no limit.
    pub upper: f64,
    /// A value of usual size, from which estimates start.
    pub typical: f64,
    /// Where a search for it starts.
    pub search: SearchText,
}

/// Values from which a search for a parameter starts.
#[derive(Debug, Clone, PartialEq)]
pub enum SearchText {
    /// From the typical value alone.
    Typical,
    /// From each of these, in the parameter's unit.
    Values(Vec<f64>),
    /// Shares of something that the motion has.
    Shares(ShareOf, Vec<f64>),
    /// Cycles over the range of the joint's positions.
    Cycles,
}

/// What shares are of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShareOf {
    /// Of the way from the least to the greatest position.
    Position,
    /// Of the range of positions.
    Range,
    /// Of the greatest speed.
    Speed,
    /// Multiples of one over the greatest speed.
    OverSpeed,
    /// Of the duration of the recording.
    Duration,
}
