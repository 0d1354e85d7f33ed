//! A parameter of an effect: its unit and limits, and where a search for it starts.

use crate::chain::effect::unit::Unit;

/// A parameter of an effect.
#[derive(Debug, Clone, Copy)]
pub struct ParameterInfo {
    /// Within the effect, as results and problem files have it.
    pub name: &'static str,
    /// Depends on whether the joint turns or slides.
    pub unit: Unit,
    /// In a few words.
    pub meaning: &'static str,
    /// Least value that the physics allows, in the unit; minus infinity where there is no limit.
    pub lower: f64,
    /// Greatest value that the physics allows; infinity where there is no limit.
    pub upper: f64,
    /// Value from which a nonlinear estimate starts, and a size at which it matters.
    pub typical: f64,
    /// Whether the signal is affine in it.
    pub linearity: Linearity,
    /// Where a search for it starts.
    pub search: Search,
}

/// Limits of a parameter and its usual value between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Least value.
    pub lower: f64,
    /// Value from which an estimate starts.
    pub typical: f64,
    /// Greatest value.
    pub upper: f64,
}

impl ParameterInfo {
    /// In words, where a value is not one that the physics allows.
    pub fn beyond_physics(&self, value: f64) -> Option<String> {
        let Self {
            lower,
            upper,
            meaning,
            ..
        } = self;
        match () {
            () if value < *lower => Some(format!(
                "{value} is less than {lower}, the least possible {meaning}"
            )),
            () if value > *upper => Some(format!(
                "{value} is more than {upper}, the largest possible {meaning}"
            )),
            () => None,
        }
    }

    /// A parameter in which the signal is affine, of any sign.
    pub const fn linear(
        name: &'static str,
        unit: Unit,
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
        name: &'static str,
        unit: Unit,
        meaning: &'static str,
        span: Span,
        search: Search,
    ) -> Self {
        Self {
            name,
            unit,
            meaning,
            lower: span.lower,
            upper: span.upper,
            typical: span.typical,
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
    /// Each of these, in the parameter's unit.
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
    /// Affine: one linear solution finds it.
    Linear,
    /// Not affine: it is found by iteration, from where its search starts.
    Nonlinear,
}
