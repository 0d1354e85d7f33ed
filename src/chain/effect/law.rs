//! The interface of a law: the samples of the motion that it reads, the torque and derivatives that it writes.

use crate::chain::effect::expression::{Expression, StateLaw};

/// One joint over successive samples, as a torque law sees it.
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    /// m, ṁ, m̈ of the motor at joint scale; q, q̇, q̈ of the joint for a law at the joint.
    pub position: &'a [f64],
    /// ṁ or q̇, rad/s (m/s).
    pub velocity: &'a [f64],
    /// m̈ or q̈, rad/s² (m/s²).
    pub acceleration: &'a [f64],
    /// `ṁ/(|ṁ| + w)`.
    pub sign: &'a [f64],
    /// s from the start of the recording; empty for states that stand alone.
    pub time: &'a [f64],
    /// The last sample is followed by the first: one period of a motion that repeats.
    pub cyclic: bool,
    /// What is known beside the motion of the joint itself.
    pub surroundings: Surroundings<'a>,
}

/// What a law may know beside the motion of its own joint.
#[derive(Debug, Clone, Copy, Default)]
pub struct Surroundings<'a> {
    /// Position and velocity of the motors of other joints, in the order in which the law names them, over the same samples;
    /// empty where they are not known.
    pub others: &'a [[&'a [f64]; 2]],
    /// °C; empty where it was not recorded.
    pub temperature: &'a [f64],
    /// s, after which the motion repeats, if it does.
    pub period: Option<f64>,
    /// N·m/A (N/A) of the joint, where the signal is a current.
    pub torque_constant: Option<f64>,
}

/// Where a torque law puts its torque and derivatives.
#[derive(Debug)]
pub struct Contribution<'a> {
    /// The law's torque is added.
    pub torque: &'a mut [f64],
    /// ∂torque/∂parameter is written, one series per parameter of the effect, borrowed ones behind.
    pub by_parameter: &'a mut [Vec<f64>],
    /// ∂torque/∂sign is added: the chain carries it on to w.
    pub by_sign: &'a mut [f64],
    /// ∂torque/∂position is added; looked at for laws at the joint.
    pub by_position: &'a mut [f64],
    /// ∂torque/∂velocity is added; looked at for laws at the joint.
    pub by_velocity: &'a mut [f64],
}

/// A torque that the motor exerts in addition, or that acts on the joint.
pub trait TorqueLaw: Sync + std::fmt::Debug {
    /// Adds the torque of successive samples for the effect's parameters, borrowed ones behind its own.
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>);

    /// The torque of successive samples alone.
    fn torques(&self, samples: Samples<'_>, parameters: &[f64]) -> Vec<f64> {
        let zeros = || vec![0.0; samples.velocity.len()];
        let mut torque = zeros();
        self.add(
            samples,
            parameters,
            &mut Contribution {
                torque: &mut torque,
                by_parameter: &mut vec![zeros(); parameters.len()],
                by_sign: &mut zeros(),
                by_position: &mut zeros(),
                by_velocity: &mut zeros(),
            },
        );
        torque
    }

    /// What the law does with mechanical power.
    fn power(&self) -> Power;

    /// The same torque as a formula.
    fn torque(&self) -> Expression;

    /// How the states in the formula go on; none of a law without memory.
    fn states(&self) -> Vec<StateLaw> {
        Vec::new()
    }

    /// The law as a differential equation, where its torque depends on a state of its own.
    fn dynamics(&self) -> Option<&dyn LawDynamics> {
        None
    }
}

/// A law with an internal state z: `ż = f(z, v)`, `torque = g(z, v)`.
pub trait LawDynamics: Sync + std::fmt::Debug {
    /// z after a long motion at one velocity; `parameters` as for [`TorqueLaw::add`].
    fn settled(&self, parameters: &[f64], velocity: f64) -> f64;

    /// Rate and torque at (z, v).
    fn flow(&self, parameters: &[f64], state: f64, velocity: f64) -> Flow;
}

/// ż and torque of a law with an internal state, and their derivatives.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Flow {
    /// ż.
    pub rate: f64,
    /// ∂ż/∂z.
    pub rate_by_state: f64,
    /// ∂ż/∂v.
    pub rate_by_velocity: f64,
    /// N·m (N).
    pub torque: f64,
    /// ∂torque/∂z.
    pub torque_by_state: f64,
    /// ∂torque/∂v.
    pub torque_by_velocity: f64,
}

/// Where a law of the transmission puts its torque and derivatives.
#[derive(Debug)]
pub struct Transmitted<'a> {
    /// What the law adds to the transmitted torque is added.
    pub torque: &'a mut [f64],
    /// ∂(added torque)/∂τ_M is added.
    pub by_load: &'a mut [f64],
    /// ∂(added torque)/∂parameter is written.
    pub by_parameter: &'a mut [Vec<f64>],
    /// ∂(added torque)/∂sign is added.
    pub by_sign: &'a mut [f64],
    /// N·m (N) of τ_M within which `|τ_M|` is rounded off, 0 for the law itself: see [`size`].
    pub rounding: f64,
}

/// `|x|` and its slope, beyond `|x| = s` exactly; within it the parabola `x²/(2s) + s/2`, which meets it smoothly.
#[inline]
pub fn size(x: f64, s: f64) -> (f64, f64) {
    if x.abs() < s {
        (0.5 * (x * x / s + s), x / s)
    } else {
        (x.abs(), signum(x))
    }
}

/// A torque that depends on another one: a loss on τ_M, which the gear transmits, or what a signal shows beyond the torque of
/// its motor.
pub trait TransmissionLaw: Sync + std::fmt::Debug {
    /// Adds what is exerted, or shown, beyond `load`.
    fn add(
        &self,
        samples: Samples<'_>,
        load: &[f64],
        parameters: &[f64],
        out: &mut Transmitted<'_>,
    );

    /// What the law adds as a formula.
    fn added(&self) -> Expression;

    /// Whether that is proportional to the load on either side of zero, so that the load follows from the torque.
    fn is_proportional(&self) -> bool {
        true
    }
}

/// What a law does with mechanical power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Power {
    /// Never gives power for parameters within their bounds.
    Dissipates,
    /// Stores power and gives it back, or may do either.
    Exchanges,
}

/// sgn x, 0 at 0.
#[inline]
pub fn signum(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}
