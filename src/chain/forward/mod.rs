//! Forward dynamics of the chain: from the torque of the motors to the motion.
//!
//! ```text
//! x = (m, δ)                     motors at joint scale, lags of links behind elastic gears and gears with play
//! q = V m + offset − E δ = B x + constant
//! A ẍ = r(x, ẋ, z, t),           A = (1 + ∂losses/∂τ) Bᵀ M B + J
//! motors:  r = τ_mot − laws(m, ṁ, z) − (losses − ∂losses/∂τ · τ) − (1 + ∂losses/∂τ) (Bᵀ h)
//!          τ_mot = gain (kp (m_c − m) + kd (v_c − ṁ) + u) under commands
//! lags:    r = −c(δ, δ̇) − (Bᵀ h)
//! bristles and the like:  ż = f(z, ṁ)
//! ```
//!
//! Where loops are closed, q̇ = (1; P) q̇_a and q̈ = (1; P) q̈_a + c of the [mechanism](crate::mechanism): rows of B at joints
//! without a motor are P times those of the others, and h is that at the acceleration c.
//!
//! Friction near standstill, flanks and bristles are stiff, links are not. So M(q) and h(q, q̇) are taken once for each
//! [step](Forward::advance), at its middle, and the rest is integrated within it by as many steps as it asks for of ROS2,
//! an L-stable Rosenbrock method that is of order two for any approximate Jacobian (Verwer, Spee, Blom and Hundsdorfer
//! 1999, eq. 1.3). Both are of order two.

mod drive;
mod rosenbrock;
mod state;
mod told;

use crate::chain::effect::sign::sign;
use crate::chain::effect::tilt::tilted;
use crate::chain::effect::{Contribution, Effect, Law, Memory, Samples, Surroundings};
use crate::chain::evaluate::bodies;
use crate::chain::flank::Flank;
use crate::chain::forward::drive::{Drive, LEAST_WIDTH};
use crate::chain::forward::rosenbrock::Rosenbrock;
use crate::chain::forward::state::{Drivetrain, Lagging, TimeSpan};
use crate::chain::model::{JointModel, Model, Signal};
use crate::mechanism::error::MechanismError;
use crate::mechanism::loops::Mechanism;
use crate::robot::forward_dynamics::ForwardDynamics;
use crate::robot::tree::Tree;
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;

pub use crate::chain::forward::state::{Driven, State};
pub use crate::chain::forward::told::Told;

/// How finely is integrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Longest step between two evaluations of M and h, s.
    pub step: f64,
    /// Largest difference of a velocity from the method of order one over one step, rad/s (m/s).
    pub tolerance: f64,
}

impl Default for Accuracy {
    /// Links of robots turn by less than a hundredth of a radian within a millisecond; and a reversal passes a transition
    /// speed of 0.004 rad/s in twenty steps.
    fn default() -> Self {
        Self {
            step: 1e-3,
            tolerance: 2e-4,
        }
    }
}

impl Accuracy {
    /// Half of the steps, whose errors of order two are a quarter.
    pub fn halved(self) -> Self {
        Self {
            step: 0.5 * self.step,
            tolerance: 0.25 * self.tolerance,
        }
    }
}

/// Why a model cannot be simulated forward.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotForward {
    /// The signal is a base wrench, from which no motion follows.
    #[error(
        "the signal is a base wrench, which no motion follows from; record motor currents or torques too"
    )]
    NoTorque,
    /// Every joint is locked.
    #[error("every joint is locked; release one")]
    NothingMoves,
}

/// Why a motion ends.
#[derive(Debug, Clone, PartialEq)]
pub enum MotionEnds {
    /// The inertia that accelerates is not positive: these are no bodies.
    NoInertia {
        /// Index of the joint.
        joint: usize,
    },
    /// The loops of the mechanism stay open, or nothing holds them.
    Open(MechanismError),
}

/// Least inertia of a motor in front of a lag, as a share of that of its link: without any, its acceleration would not
/// be a number.
const LEAST_ROTOR: f64 = 1e-4;

/// A model whose motion follows from the torques of its motors.
#[derive(Debug)]
pub struct Forward<'m> {
    model: &'m Model,
    values: DVector<f64>,
    tree: Tree,
    bodies: Vec<f64>,
    dynamics: ForwardDynamics,
    /// Joints whose motors move.
    motors: Vec<usize>,
    lags: Vec<Lagging>,
    /// B, joints x (motors and lags).
    map: DMatrix<f64>,
    /// B is the identity.
    direct: bool,
    /// Positions of the joints while x vanishes.
    constant: Vec<f64>,
    drives: Vec<Drive>,
    /// Signals of the motors by recorded ones, where channels hear one another.
    unmixed: Option<DMatrix<f64>>,
    solver: Rosenbrock,
    accuracy: Accuracy,
    /// Mean of ẍ over the last step.
    acceleration: Vec<f64>,
    joints: [Vec<f64>; 2],
    middle: [Vec<f64>; 2],
    loops: Option<Loops<'m>>,
}

/// The loops of a mechanism at the state of the last step.
#[derive(Debug)]
struct Loops<'m> {
    mechanism: &'m Mechanism,
    /// All joints where the loops closed last: the next search begins there.
    near: Vec<f64>,
    /// Accelerations of all joints while those of the motors vanish.
    bias: Vec<f64>,
}

impl<'m> Forward<'m> {
    /// The model at parameter values, with or without its load. Effects that belong to one recording do not act.
    ///
    /// # Errors
    /// Where the model has no forward dynamics.
    pub fn new(
        model: &'m Model,
        values: &DVector<f64>,
        loaded: bool,
        accuracy: Accuracy,
    ) -> Result<Self, NotForward> {
        if model.signal() == Signal::BaseWrench {
            return Err(NotForward::NoTorque);
        }
        let joints = model.joints();
        let n = joints.len();
        let motors: Vec<usize> = (0..n).filter(|&j| !joints[j].locked).collect();
        if motors.is_empty() {
            return Err(NotForward::NothingMoves);
        }
        let lagging = |&j: &usize| {
            let flank = Flank::of_joint(&joints[j], values)?;
            Some(Lagging { joint: j, flank })
        };
        let lags: Vec<Lagging> = motors.iter().filter_map(lagging).collect();
        let coupling = model.coupling(values);
        let size = motors.len() + lags.len();
        let map = DMatrix::from_fn(n, size, |i, k| match k.checked_sub(motors.len()) {
            None => coupling[(i, motors[k])],
            Some(lag) => -f64::from(u8::from(lags[lag].joint == i)),
        });
        let tree = match model.tilt() {
            None => model.tree().clone(),
            Some(at) => {
                let gravity = tilted(&model.tree().gravity(), [values[at], values[at + 1]]);
                model.tree().clone().with_gravity(gravity.into())
            }
        };
        let drives: Vec<Drive> = motors
            .iter()
            .map(|&j| Drive::new(&joints[j], values, model.signal()))
            .collect();
        Ok(Self {
            unmixed: model
                .crosstalk_removal(values)
                .map(|all| all.select_rows(&motors).select_columns(&motors)),
            dynamics: ForwardDynamics::new(&tree),
            bodies: bodies(model, values, loaded),
            direct: size == n && map.is_identity(0.0),
            constant: (0..n)
                .map(|j| model.offset()[j] + model.encoder_offset(j, values))
                .collect(),
            solver: Rosenbrock::new(size, motors.len(), accuracy.tolerance),
            acceleration: vec![0.0; size],
            joints: [vec![0.0; n], vec![0.0; n]],
            middle: [vec![0.0; size], vec![0.0; size]],
            loops: model.mechanism().map(|mechanism| Loops {
                mechanism,
                near: mechanism.home().to_vec(),
                bias: vec![0.0; n],
            }),
            values: values.clone(),
            model,
            tree,
            motors,
            lags,
            map,
            drives,
            accuracy,
        })
    }

    /// Joints whose motors move, in the order of torques and states.
    pub fn motors(&self) -> &[usize] {
        &self.motors
    }

    /// Number of lags behind the motors in a state.
    pub fn lags(&self) -> usize {
        self.lags.len()
    }

    /// Whether a law of some motor has a state of its own.
    pub fn has_memory(&self) -> bool {
        self.drives.iter().any(Drive::has_memory)
    }

    /// Torques of the motors at joint scale that their recorded signals stand for, N·m (N).
    pub fn motor_torques(&self, signals: &[f64]) -> Vec<f64> {
        let own = match &self.unmixed {
            Some(unmixed) => {
                Cow::Owned((unmixed * DVector::from_column_slice(signals)).data.into())
            }
            None => Cow::Borrowed(signals),
        };
        let drives = self.drives.iter().zip(own.iter());
        drives
            .map(|(drive, signal)| drive.torque(*signal))
            .collect()
    }

    /// Whether what moves the motors is told to position controllers.
    pub fn is_controlled(&self) -> bool {
        self.model.signal() == Signal::PositionCommand
    }

    /// Torque that the controller of a motor, told this, would give at rest at position zero, N·m (N).
    pub fn aim(&self, motor: usize, told: Told) -> f64 {
        self.drives[motor].aim(told)
    }

    /// s by which the channel of a motor is recorded late, or by which a command acts late.
    pub fn delay(&self, motor: usize) -> f64 {
        let joint = &self.model.joints()[self.motors[motor]];
        joint.delay.map_or(0.0, |at| self.values[at])
    }

    /// Where motors that stand still are, `[joint]` at joint scale; others are passed over.
    pub fn hold(&mut self, motors: &[f64]) {
        let coupling = self.model.coupling(&self.values);
        for (i, constant) in self.constant.iter_mut().enumerate() {
            let held = (0..motors.len()).filter(|j| !self.motors.contains(j));
            *constant = self.model.offset()[i]
                + self.model.encoder_offset(i, &self.values)
                + held.map(|j| coupling[(i, j)] * motors[j]).sum::<f64>();
        }
    }

    /// Has the loops of a mechanism close near the given positions of all joints.
    pub fn close_near(&mut self, position: impl Fn(usize) -> f64) {
        if let Some(loops) = &mut self.loops {
            let joints = loops.near.iter_mut().enumerate();
            joints.for_each(|(joint, near)| *near = position(joint));
        }
    }

    /// Positions of the drives' side of all joints that move as they are recorded, `V m + offset`.
    pub fn joint_positions(&self, position: &[f64], out: &mut [f64]) {
        for (slot, &j) in out.iter_mut().zip(&self.motors) {
            let own = (0..self.motors.len()).map(|k| self.map[(j, k)] * position[k]);
            *slot =
                self.constant[j] - self.model.encoder_offset(j, &self.values) + own.sum::<f64>();
        }
    }

    /// The entry of V of a joint and a motor, by their places among those that move.
    pub fn coupling_entry(&self, joint: usize, motor: usize) -> f64 {
        self.map[(self.motors[joint], motor)]
    }

    /// A state of given motors: links rest where their flanks bear the torque at rest, and bristles as after a long
    /// motion at the same velocity.
    pub fn settled(&mut self, position: &[f64], velocity: &[f64]) -> State {
        let size = self.motors.len() + self.lags.len();
        let mut state = State {
            position: position.to_vec(),
            velocity: velocity.to_vec(),
            memory: Vec::new(),
        };
        state.position.resize(size, 0.0);
        state.velocity.resize(size, 0.0);
        // Where loops stay open nothing bears on the flanks, and the first step says so.
        let is_closed = self.linearise(&state.position, &state.velocity).is_ok();
        for (f, lag) in self.lags.iter().enumerate() {
            let at = self.motors.len() + f;
            let torque = if is_closed {
                -self.solver.bias[at]
            } else {
                0.0
            };
            state.position[at] =
                torque / lag.flank.stiffness + lag.flank.half_gap * torque.signum();
        }
        let drives = self.drives.iter().zip(velocity);
        state.memory = drives.map(|(drive, v)| drive.settled(*v)).collect();
        self.begin();
        state
    }

    /// Forgets the accelerations of another motion.
    pub fn begin(&mut self) {
        self.acceleration.fill(0.0);
        self.solver.begin();
    }

    /// Advances a state by `duration`, s, in equal steps that are no longer than the accuracy allows.
    ///
    /// # Errors
    /// Where the inertia is not positive, or loops stay open.
    pub fn advance(
        &mut self,
        state: &mut State,
        driven: Driven<'_>,
        duration: f64,
    ) -> Result<(), MotionEnds> {
        // A share of a step more is rounding of the rate.
        let steps = (duration / self.accuracy.step - 1e-9).ceil().max(1.0);
        let h = duration / steps;
        for step in 0..steps as usize {
            let span = TimeSpan {
                duration: h,
                from: step as f64 / steps,
                to: (step + 1) as f64 / steps,
            };
            self.step(state, driven, span)?;
        }
        Ok(())
    }

    fn step(
        &mut self,
        state: &mut State,
        driven: Driven<'_>,
        span: TimeSpan,
    ) -> Result<(), MotionEnds> {
        let h = span.duration;
        let mut middle = std::mem::take(&mut self.middle);
        for k in 0..state.position.len() {
            let (v, a) = (state.velocity[k], self.acceleration[k]);
            middle[0][k] = state.position[k] + 0.5 * h * (v + 0.25 * h * a);
            middle[1][k] = v + 0.5 * h * a;
        }
        let linearised = self.linearise(&middle[0], &middle[1]);
        self.middle = middle;
        linearised?;
        self.acceleration.copy_from_slice(&state.velocity);
        let mut train = Drivetrain {
            drives: &mut self.drives,
            lags: &self.lags,
            driven,
        };
        let solved = self.solver.integrate(state, &mut train, span);
        for (a, v) in self.acceleration.iter_mut().zip(&state.velocity) {
            *a = (v - *a) / h;
        }
        solved.map_err(|at| MotionEnds::NoInertia {
            joint: match at.checked_sub(self.motors.len()) {
                None => self.motors[at],
                Some(lag) => self.lags[lag].joint,
            },
        })
    }

    /// Bᵀ M B and Bᵀ h at (x, ẋ), torques of laws at the joints among h.
    fn linearise(&mut self, position: &[f64], velocity: &[f64]) -> Result<(), MotionEnds> {
        let n = self.constant.len();
        let size = position.len();
        let [q, dq] = &mut self.joints;
        if self.direct {
            for j in 0..n {
                q[j] = self.constant[j] + position[j];
                dq[j] = velocity[j];
            }
        } else {
            for i in 0..n {
                let along = |x: &[f64]| (0..size).map(|k| self.map[(i, k)] * x[k]).sum::<f64>();
                q[i] = self.constant[i] + along(position);
                dq[i] = along(velocity);
            }
        }
        let map = match &mut self.loops {
            None => Cow::Borrowed(&self.map),
            Some(loops) => {
                let passive = loops.close([q, dq]).map_err(MotionEnds::Open)?;
                Cow::Owned(loops.with_passive(&self.map, &passive))
            }
        };
        let equation = self.dynamics.equation(&self.tree, &self.bodies, [q, dq]);
        let entry = |i: usize, j: usize| equation.mass[i.max(j) * n + i.min(j)];
        let (mass, bias) = (&mut self.solver.mass, &mut self.solver.bias);
        let laws = &self.model.joints();
        let joint_torque =
            |j: usize| equation.bias[j] + at_joint(&laws[j], &self.values, [q[j], dq[j]]);
        if self.direct {
            for i in 0..n {
                for j in 0..n {
                    mass[i * n + j] = entry(i, j);
                }
                bias[i] = joint_torque(i);
            }
            return Ok(());
        }
        let full = DMatrix::from_fn(n, n, entry);
        let mut torque = DVector::from_fn(n, |j, _| joint_torque(j));
        if let Some(loops) = &self.loops {
            torque += &full * DVector::from_column_slice(&loops.bias);
        }
        let (projected, load) = (map.tr_mul(&(full * map.as_ref())), map.tr_mul(&torque));
        for i in 0..size {
            for j in 0..size {
                mass[i * size + j] = projected[(i, j)];
            }
            bias[i] = load[i];
        }
        for (f, lag) in self.lags.iter().enumerate() {
            let motor = self.motors.iter().position(|&m| m == lag.joint);
            let (Some(k), at) = (motor, self.motors.len() + f) else {
                continue;
            };
            let least = LEAST_ROTOR * mass[at * size + at];
            mass[k * size + k] += (least - self.drives[k].inertia).max(0.0);
        }
        Ok(())
    }
}

impl Loops<'_> {
    /// Moves the joints without a motor with the others; gives P (passive x actuated).
    fn close(&mut self, [q, dq]: [&mut Vec<f64>; 2]) -> Result<DMatrix<f64>, MechanismError> {
        let mechanism = self.mechanism;
        for &joint in mechanism.passive() {
            q[joint] = self.near[joint];
        }
        self.bias.fill(0.0);
        let map = mechanism.complete([q, dq, &mut self.bias])?;
        self.near.copy_from_slice(q);
        Ok(map)
    }

    /// B with its rows at the joints without a motor, P times those of the others.
    fn with_passive(&self, map: &DMatrix<f64>, passive: &DMatrix<f64>) -> DMatrix<f64> {
        let mut whole = map.clone();
        let moved = passive * map.select_rows(self.mechanism.actuated());
        for (row, &joint) in self.mechanism.passive().iter().enumerate() {
            whole.set_row(joint, &moved.row(row));
        }
        whole
    }
}

/// Whether an effect acts in forward simulations: what it depends on follows from the motion of its joint.
pub fn acts(effect: &Effect) -> bool {
    let is_of_motion = effect.needs.others.is_empty() && effect.needs.memory != Memory::Time;
    match effect.law {
        Law::Signal(_) => false,
        Law::Motor(law) => {
            let is_followed = effect.needs.memory == Memory::None || law.dynamics().is_some();
            is_of_motion && is_followed
        }
        Law::Joint(_) | Law::Transmission(_) => is_of_motion,
        _ => true,
    }
}

/// Torque of the laws at a joint.
fn at_joint(joint: &JointModel, values: &DVector<f64>, [q, dq]: [f64; 2]) -> f64 {
    let mut torque = [0.0];
    let width = joint.width.map_or(0.0, |at| values[at]).max(LEAST_WIDTH);
    for &(effect, first) in &joint.effects {
        let Law::Joint(law) = effect.law else {
            continue;
        };
        let count = effect.parameters.len();
        let samples = Samples {
            position: &[q],
            velocity: &[dq],
            acceleration: &[0.0],
            sign: &[sign(dq, width)],
            time: &[],
            cyclic: false,
            surroundings: Surroundings::default(),
        };
        let mut out = Contribution {
            torque: &mut torque,
            by_parameter: &mut vec![vec![0.0]; count],
            by_sign: &mut [0.0],
            by_position: &mut [0.0],
            by_velocity: &mut [0.0],
        };
        law.add(samples, &values.as_slice()[first..first + count], &mut out);
    }
    torque[0]
}
