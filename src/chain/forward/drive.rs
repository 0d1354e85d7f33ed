//! The drive of one motor at one state: what its laws and losses take of its torque.

use crate::chain::effect::current_polynomial::{COEFFICIENTS, torque};
use crate::chain::effect::sign::sign;
use crate::chain::effect::{
    Contribution, Flow, Law, LawDynamics, Memory, Samples, Surroundings, TorqueLaw,
    TransmissionLaw, Transmitted,
};
use crate::chain::forward::told::Told;
use crate::chain::model::{JointModel, Signal};
use nalgebra::DVector;

/// Least transition speed of friction, rad/s (m/s): a sign that jumps has no motion that follows from torques while it
/// sticks; within this speed a joint creeps by less than a ten-thousandth of a radian in a second.
pub const LEAST_WIDTH: f64 = 1e-4;

/// Step of the difference that gives the slope of friction, rad/s or m/s: well below any w, and large enough that
/// rounding of torques leaves seven digits.
const SPEED_STEP: f64 = 1e-6;

/// Samples that laws are asked for at once: the state, and one a little faster.
const LANES: usize = 2;

/// Parameters of the longest law, borrowed ones included.
const MOST_PARAMETERS: usize = 16;

/// What the laws of a motor take at one state.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Taken {
    /// N·m (N), and its derivative by the velocity.
    pub torque: f64,
    pub slope: f64,
    /// ∂sign/∂ṁ of the regularised sign.
    pub sign_slope: f64,
}

/// Position and velocity of a motor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moving {
    pub position: f64,
    pub velocity: f64,
}

/// What the gear loses of a transmitted torque.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Loss {
    pub torque: f64,
    pub by_load: f64,
    pub by_sign: f64,
}

/// A position controller, its gains times that of the drive.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Servo {
    /// N·m/rad (N/m).
    pub stiffness: f64,
    /// N·m·s/rad (N·s/m).
    pub damping: f64,
}

/// A law with its parameters, borrowed ones behind its own.
#[derive(Debug)]
struct Valued<T: 'static + ?Sized> {
    law: &'static T,
    parameters: Vec<f64>,
}

/// The drive of one motor.
#[derive(Debug)]
pub(super) struct Drive {
    laws: Vec<Valued<dyn TorqueLaw>>,
    memory: Option<Valued<dyn LawDynamics>>,
    losses: Vec<Valued<dyn TransmissionLaw>>,
    width: f64,
    rounding: f64,
    /// Reflected inertia of the rotor, kg·m² (kg).
    pub inertia: f64,
    /// Torque per unit of the signal; of a current with a polynomial the gain alone.
    factor: f64,
    polynomial: Option<[f64; COEFFICIENTS]>,
    /// Zero of a motor without a position controller.
    pub servo: Servo,
    by_parameter: Vec<Vec<f64>>,
}

impl Drive {
    pub fn new(joint: &JointModel, values: &DVector<f64>, signal: Signal) -> Self {
        let gain = joint.gain.map_or(1.0, |at| values[at]);
        let polynomial = joint.polynomial.filter(|_| signal == Signal::Current);
        let mut drive = Self {
            laws: Vec::new(),
            memory: None,
            losses: Vec::new(),
            width: joint.width.map_or(0.0, |at| values[at]).max(LEAST_WIDTH),
            rounding: joint.rounding,
            inertia: 0.0,
            factor: gain
                * if polynomial.is_some() {
                    1.0
                } else {
                    joint.torque_constant
                },
            polynomial: polynomial.map(|at| std::array::from_fn(|k| values[at + k])),
            servo: joint.controller.map_or_else(Servo::default, |at| Servo {
                stiffness: gain * values[at],
                damping: gain * values[at + 1],
            }),
            by_parameter: vec![vec![0.0; LANES]; MOST_PARAMETERS],
        };
        for (index, &(effect, first)) in joint.effects.iter().enumerate() {
            let own = first..first + effect.parameters.len();
            let positions = own.chain(joint.borrowed[index].iter().copied());
            let parameters: Vec<f64> = positions.map(|p| values[p]).collect();
            match effect.law {
                Law::Transmission(law) => drive.losses.push(Valued { law, parameters }),
                Law::Motor(law) if !joint.replaced[index] => match law.dynamics() {
                    Some(law) => drive.memory = Some(Valued { law, parameters }),
                    None if effect.needs.memory == Memory::None => {
                        drive.laws.push(Valued { law, parameters });
                    }
                    None => {}
                },
                _ => {}
            }
        }
        let [still, accelerated] = [0.0, 1.0].map(|a| drive.at([0.0; LANES], [0.0; LANES], a)[0]);
        drive.inertia = accelerated - still;
        drive
    }

    /// Torque at joint scale of a signal.
    pub fn torque(&self, signal: f64) -> f64 {
        match self.polynomial {
            Some(c) => self.factor * torque(c, signal),
            None => self.factor * signal,
        }
    }

    /// Torque of the controller were the motor at rest at position zero.
    pub fn aim(&self, told: Told) -> f64 {
        self.servo.stiffness * told.position
            + self.servo.damping * told.velocity
            + self.factor * told.feed_forward
    }

    pub fn has_memory(&self) -> bool {
        self.memory.is_some()
    }

    pub fn has_losses(&self) -> bool {
        !self.losses.is_empty()
    }

    /// Torque of the laws without memory, at positions and velocities.
    fn at(
        &mut self,
        position: [f64; LANES],
        velocity: [f64; LANES],
        acceleration: f64,
    ) -> [f64; LANES] {
        let sign = velocity.map(|v| sign(v, self.width));
        let (mut torque, mut by_sign) = ([0.0; LANES], [0.0; LANES]);
        let (mut by_position, mut by_velocity) = ([0.0; LANES], [0.0; LANES]);
        for Valued { law, parameters } in &self.laws {
            let samples = Samples {
                position: &position,
                velocity: &velocity,
                acceleration: &[acceleration; LANES],
                sign: &sign,
                time: &[],
                cyclic: false,
                surroundings: Surroundings::default(),
            };
            let mut out = Contribution {
                torque: &mut torque,
                by_parameter: &mut self.by_parameter[..parameters.len()],
                by_sign: &mut by_sign,
                by_position: &mut by_position,
                by_velocity: &mut by_velocity,
            };
            law.add(samples, parameters, &mut out);
        }
        torque
    }

    /// What the laws without memory take.
    pub fn taken(&mut self, position: f64, velocity: f64) -> Taken {
        let torque = self.at([position; LANES], [velocity, velocity + SPEED_STEP], 0.0);
        let beyond = velocity.abs() + self.width;
        Taken {
            torque: torque[0],
            // Friction that falls with speed drives: an implicit slope would hide it.
            slope: ((torque[1] - torque[0]) / SPEED_STEP).max(0.0),
            sign_slope: self.width / (beyond * beyond),
        }
    }

    /// What the law with a memory does.
    pub fn flow(&self, state: f64, velocity: f64) -> Option<Flow> {
        let memory = self.memory.as_ref()?;
        Some(memory.law.flow(&memory.parameters, state, velocity))
    }

    /// Its state after a long motion at a velocity; 0 without such a law.
    pub fn settled(&self, velocity: f64) -> f64 {
        let memory = self.memory.as_ref();
        memory.map_or(0.0, |m| m.law.settled(&m.parameters, velocity))
    }

    /// What the gear loses of a transmitted torque.
    pub fn loss(&mut self, load: f64, motion: Moving) -> Loss {
        let (mut torque, mut by_load, mut by_sign) = ([0.0], [0.0], [0.0]);
        for Valued { law, parameters } in &self.losses {
            let mut out = Transmitted {
                torque: &mut torque,
                by_load: &mut by_load,
                by_parameter: &mut self.by_parameter[..parameters.len()],
                by_sign: &mut by_sign,
                rounding: self.rounding,
            };
            let samples = Samples {
                position: &[motion.position],
                velocity: &[motion.velocity],
                acceleration: &[0.0],
                sign: &[sign(motion.velocity, self.width)],
                time: &[],
                cyclic: false,
                surroundings: Surroundings::default(),
            };
            law.add(samples, &[load], parameters, &mut out);
        }
        Loss {
            torque: torque[0],
            by_load: by_load[0],
            by_sign: by_sign[0],
        }
    }
}
