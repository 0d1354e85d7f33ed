//! What is known of an effect beyond its law: its part in a drive, what says how much of it there is, and what it means to
//! the people who look after the robot.

use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::site::Site;
use rand_chacha::ChaCha8Rng;

/// What is known of an effect beyond its law.
#[derive(Debug, Clone, Copy)]
pub struct Knowledge {
    /// What a finding of it means, in a sentence that a plant engineer understands; where there is none, the effect's own
    /// sentence has to do.
    pub finding: Option<fn(&FittedEffect<'_>) -> String>,
    /// What a change of its size over time means.
    pub change: Option<Change>,
    /// What says how much of it there is.
    pub sizes: Sizes,
    /// How trials conceal it.
    pub trial: Trial,
    /// The usual term of a joint that it is.
    pub term: Option<JointTerm>,
    /// The parameter that is the transition speed w of the joint's `sign(v)`.
    pub transition: Option<Transition>,
    /// Its sines, each of which can be written in two ways.
    pub sines: &'static [Sine],
    /// Its law is one shape of the many that the same physics can have, a bump for what comes and goes with the position: where more is
    /// left of its joint, the shape is another.
    pub has_one_shape_of_many: bool,
}

/// A term `amplitude·sin(… + phase)` of an effect, by the names of its parameters: the same as one of the other sign half a
/// turn further, `−amplitude·sin(… + phase + π)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sine {
    /// The parameter that is its amplitude.
    pub amplitude: &'static str,
    /// The parameter that is its phase.
    pub phase: &'static str,
}

/// A transition speed among the parameters of an effect.
#[derive(Debug, Clone, Copy)]
pub struct Transition {
    /// Its position among them.
    pub speed: usize,
    /// Position of the size F that the friction comes to, `F v/(|v| + w)`.
    pub size: usize,
    /// The narrowest limit that makes sense, rad/s or m/s at joint scale: what creeps tells nothing of it.
    pub least: f64,
    /// The term without which a wide transition stands for that term, and is not limited.
    pub stands_for: JointTerm,
}

impl Transition {
    /// The widest transition with which a friction lacks no more than a share of its size at a speed, `w/(v + w) = unseen`.
    pub fn shown(&self, fastest: f64, unseen: f64) -> f64 {
        (fastest * unseen / (1.0 - unseen)).max(self.least)
    }
}

impl Knowledge {
    /// Nothing but the law.
    pub const NONE: Self = Self {
        finding: None,
        change: None,
        sizes: Sizes::Linear,
        trial: Trial::FromLaw,
        term: None,
        transition: None,
        sines: &[],
        has_one_shape_of_many: false,
    };
}

/// Words for a size that grows and for one that falls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// Where its size grows.
    pub up: &'static str,
    /// Where its size falls.
    pub down: &'static str,
}

impl Change {
    /// More friction, or less.
    pub const FRICTION: Self = Self {
        up: "friction up",
        down: "friction down",
    };

    /// The same words for both directions.
    pub const fn both(words: &'static str) -> Self {
        Self {
            up: words,
            down: words,
        }
    }
}

/// Parameters that say how much of an effect there is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sizes {
    /// The first parameter, which is zero where there is nothing.
    First,
    /// Every linear parameter, zero where there is nothing; the first one of a law without any.
    Linear,
    /// These, each of which has the value `nothing` where there is nothing. Without any the effect has no size: its
    /// parameters trade against one another.
    Of {
        /// Names of the parameters within the effect.
        names: &'static [&'static str],
        /// Their value where there is nothing.
        nothing: f64,
    },
}

/// How trials conceal an effect.
#[derive(Debug, Clone, Copy)]
pub enum Trial {
    /// They declare it, and conceal others.
    Declared,
    /// With values of this size at a joint, by the names of its parameters.
    Drawn(fn(&Site, &mut ChaCha8Rng) -> Vec<Drawn>),
    /// With values that follow from its formula, where its size can be told from that.
    FromLaw,
}

/// A parameter by its name within the effect, and the value that was drawn for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// Name within the effect.
    pub parameter: &'static str,
    /// In the parameter's unit.
    pub value: f64,
}

/// A parameter with its value.
pub fn drawn(parameter: &'static str, value: f64) -> Drawn {
    Drawn { parameter, value }
}

/// A term that the drive of nearly every joint has, by which robot files and other programs know it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointTerm {
    /// Friction that does not depend on speed.
    DryFriction,
    /// Friction in proportion to speed.
    ViscousFriction,
    /// A constant torque.
    Offset,
    /// What spins with the motor, at joint scale.
    RotorInertia,
    /// A spring between link and parent: stiffness, then position of rest.
    Spring,
    /// A factor of the declared torque constant.
    Gain,
}
