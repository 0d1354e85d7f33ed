//! Forward dynamics of the whole chain, linearised at each state.
//!
//! ```text
//! u = H(m) m̈ + b(m, ṁ)        u: commanded torque, m: motors at joint scale
//! ```
//!
//! Column j of H is the difference of the chain's signal at m̈ + e_j and at m̈, so that mass matrix,
//! coupling, rotors, gains and every friction law are those of the chain, whatever it holds. The states
//! lie side by side in one block, which costs little more than a single one.
//!
//! Friction near standstill is stiff: its slope Fc/w over the inertia of a wrist gives rates of 1e5 1/s.
//! So the integrator is ROS2, an L-stable Rosenbrock method of order two for any approximate Jacobian
//! (Verwer, Spee, Blom and Hundsdorfer 1999, eq. 1.3), with the slope of friction as the Jacobian.

use crate::chain::evaluate::{BLOCK, Evaluator, Segment};
use crate::chain::model::Model;
use crate::mechanism::error::MechanismError;
use crate::mechanism::loops::Mechanism;
use crate::robot::batch::Trajectory;

/// γ = 1 − 1/√2: ROS2 is L-stable.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Step of the difference that gives the slope of friction, rad/s or m/s: well below any w, and large
/// enough that rounding of torques (1e-13) leaves seven digits.
const SPEED_STEP: f64 = 1e-6;

/// A pivot below this share of the largest inertia is rounding.
const SINGULAR: f64 = 1e-12;

/// States that the block holds besides one per joint: the state itself, and with other speeds.
const EXTRA_STATES: usize = 2;

/// Why no acceleration follows from a torque.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoAcceleration {
    /// The mass matrix is singular at this joint, counted from 0.
    #[error(
        "the mass matrix is singular at joint {joint} (pivot {pivot:e}); give it a body or a rotor inertia"
    )]
    SingularMass {
        /// Index of the joint.
        joint: usize,
        /// The pivot of the factorisation there, kg·m² (kg).
        pivot: f64,
    },
    /// The loops of the mechanism do not close.
    #[error(transparent)]
    Open(MechanismError),
}

/// Positions and speeds of all motors.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// At joint scale, rad (m).
    pub position: Vec<f64>,
    /// rad/s (m/s).
    pub velocity: Vec<f64>,
}

/// The chain about one state: `u = torque + H (m̈ − at)`, for the joints that move.
#[derive(Debug, Clone)]
pub struct Linearised {
    at: Vec<f64>,
    torque: Vec<f64>,
    /// H, row after row.
    mass: Vec<f64>,
    /// ∂u/∂ṁ of each motor's own speed, not negative.
    slope: Vec<f64>,
}

/// Forward dynamics of a model whose signal is the commanded torque.
#[derive(Debug)]
pub struct Plant<'m> {
    evaluator: Evaluator<'m>,
    moving: Vec<usize>,
    mechanism: Option<&'m Mechanism>,
    /// All joints where the loops closed last.
    closed: Option<Vec<f64>>,
    loaded: bool,
    /// Last known acceleration of the joints that move: where the chain is linearised.
    about: Vec<f64>,
    states: [Vec<Vec<f64>>; 3],
}

/// A step of the integration.
pub struct Step {
    /// At its end.
    pub state: State,
    /// Largest difference of a speed from the method of order one, h |k₁ + k₂|/2, which bounds its error.
    pub error: f64,
}

impl<'m> Plant<'m> {
    /// The plant of a model, or `None` where it has more joints than a block has room for.
    pub fn new(model: &'m Model, loaded: bool) -> Option<Self> {
        let joints = model.joints();
        let moving: Vec<usize> = (0..joints.len()).filter(|&j| !joints[j].locked).collect();
        let width = moving.len() + EXTRA_STATES;
        (width <= BLOCK).then(|| Self {
            evaluator: Evaluator::new(model, &model.values(), &[]),
            mechanism: model.mechanism(),
            closed: None,
            loaded,
            about: vec![0.0; moving.len()],
            states: std::array::from_fn(|_| vec![vec![0.0; width]; joints.len()]),
            moving,
        })
    }

    /// The commanded torque that a motion takes, for the joints that move.
    ///
    /// # Errors
    /// Loops that do not close.
    pub fn torque(
        &mut self,
        [q, dq, ddq]: [&[f64]; 3],
        out: &mut [f64],
    ) -> Result<(), NoAcceleration> {
        for (series, from) in self.states.iter_mut().zip([q, dq, ddq]) {
            for (values, x) in series.iter_mut().zip(from) {
                values[0] = *x;
            }
        }
        self.close_loops(1)?;
        let [q, dq, ddq] = &self.states;
        let motors = Trajectory { q, dq, ddq };
        let loaded = self.loaded;
        let block = self
            .evaluator
            .evaluate(Segment::states(motors, loaded), 0..1);
        for (slot, &j) in out.iter_mut().zip(&self.moving) {
            *slot = block.value(j)[0];
        }
        Ok(())
    }

    /// Moves the joints without a motor with the motors, in the first `count` of the states side by side.
    fn close_loops(&mut self, count: usize) -> Result<(), NoAcceleration> {
        let Some(mechanism) = self.mechanism else {
            return Ok(());
        };
        let n = self.states[0].len();
        for state in 0..count {
            let take = |series: &[Vec<f64>]| series.iter().map(|x| x[state]).collect::<Vec<f64>>();
            let [mut q, mut dq, mut ddq] = [0, 1, 2].map(|order| take(&self.states[order]));
            // Where the loops close is sought from where they closed last.
            match &self.closed {
                None => mechanism
                    .close_from_home(&mut q)
                    .map_err(NoAcceleration::Open)?,
                Some(near) => mechanism
                    .passive()
                    .iter()
                    .for_each(|&joint| q[joint] = near[joint]),
            }
            mechanism
                .complete([&mut q, &mut dq, &mut ddq])
                .map_err(NoAcceleration::Open)?;
            for (series, values) in self.states.iter_mut().zip([&q, &dq, &ddq]) {
                (0..n).for_each(|joint| series[joint][state] = values[joint]);
            }
            self.closed = Some(q);
        }
        Ok(())
    }

    /// The chain about a state.
    ///
    /// # Errors
    /// Loops that do not close.
    pub fn linearise(&mut self, state: &State) -> Result<Linearised, NoAcceleration> {
        let count = self.moving.len();
        let width = count + EXTRA_STATES;
        for (j, values) in self.states[0].iter_mut().enumerate() {
            values.fill(state.position[j]);
        }
        for (j, values) in self.states[1].iter_mut().enumerate() {
            values.fill(state.velocity[j]);
        }
        for (k, &j) in self.moving.iter().enumerate() {
            self.states[1][j][1] += SPEED_STEP;
            self.states[2][j].fill(self.about[k]);
            self.states[2][j][EXTRA_STATES + k] += 1.0;
        }
        self.close_loops(width)?;
        let [q, dq, ddq] = &self.states;
        let motors = Trajectory { q, dq, ddq };
        let segment = Segment::states(motors, self.loaded);
        let block = self.evaluator.evaluate(segment, 0..width);
        let mut out = Linearised {
            at: self.about.clone(),
            torque: Vec::with_capacity(count),
            mass: Vec::with_capacity(count * count),
            slope: Vec::with_capacity(count),
        };
        for &j in &self.moving {
            let value = block.value(j);
            out.torque.push(value[0]);
            out.slope
                .push(((value[1] - value[0]) / SPEED_STEP).max(0.0));
            let columns = value[EXTRA_STATES..].iter();
            out.mass.extend(columns.map(|x| x - value[0]));
        }
        Ok(out)
    }

    /// m̈ of the joints that move under commanded torques.
    pub fn acceleration(
        &self,
        chain: &Linearised,
        command: &[f64],
    ) -> Result<Vec<f64>, NoAcceleration> {
        let mut right: Vec<f64> = command
            .iter()
            .zip(&chain.torque)
            .map(|(u, t)| u - t)
            .collect();
        self.solve(chain.mass.clone(), &mut right)?;
        Ok(right.iter().zip(&chain.at).map(|(d, a)| a + d).collect())
    }

    /// One step of length `h` (s) under commanded torques held constant.
    ///
    /// With A = −H⁻¹D in the speeds and zero in the positions, `(1 − γhA) k₁ = F(y)`,
    /// `(1 − γhA) k₂ = F(y + h k₁) − 2 k₁` and `y⁺ = y + h (3 k₁ + k₂)/2`.
    pub fn step(
        &mut self,
        state: &State,
        chain: &Linearised,
        command: &[f64],
        h: f64,
    ) -> Result<Step, NoAcceleration> {
        let count = self.moving.len();
        let mut implicit = chain.mass.clone();
        for k in 0..count {
            implicit[k * count + k] += GAMMA * h * chain.slope[k];
        }
        let first = self.acceleration(chain, command)?;
        self.about.copy_from_slice(&first);
        let mut k1 = times(&chain.mass, &first);
        self.solve(implicit.clone(), &mut k1)?;
        let mut trial = state.clone();
        for (k, &j) in self.moving.iter().enumerate() {
            trial.position[j] += h * state.velocity[j];
            trial.velocity[j] += h * k1[k];
        }
        let ahead = self.linearise(&trial)?;
        let second = self.acceleration(&ahead, command)?;
        let difference: Vec<f64> = second.iter().zip(&k1).map(|(f, k)| f - 2.0 * k).collect();
        let mut k2 = times(&chain.mass, &difference);
        self.solve(implicit, &mut k2)?;
        let mut next = state.clone();
        let mut error = 0.0_f64;
        for (k, &j) in self.moving.iter().enumerate() {
            error = error.max(0.5 * h * (k1[k] + k2[k]).abs());
            next.position[j] += 0.5 * h * (state.velocity[j] + trial.velocity[j]);
            next.velocity[j] += 0.5 * h * (3.0 * k1[k] + k2[k]);
        }
        Ok(Step { state: next, error })
    }

    /// Gaussian elimination without pivoting: the matrix is positive definite, or nearly symmetric where
    /// losses depend on load; `right` becomes the solution.
    fn solve(&self, mut matrix: Vec<f64>, right: &mut [f64]) -> Result<(), NoAcceleration> {
        let n = right.len();
        let largest = (0..n).fold(0.0_f64, |m, k| m.max(matrix[k * n + k]));
        for k in 0..n {
            let pivot = matrix[k * n + k];
            // Also false for a pivot that is not a number.
            let regular = pivot > SINGULAR * largest;
            if !regular {
                let joint = self.moving[k];
                return Err(NoAcceleration::SingularMass { joint, pivot });
            }
            for i in k + 1..n {
                let factor = matrix[i * n + k] / pivot;
                for j in k..n {
                    matrix[i * n + j] -= factor * matrix[k * n + j];
                }
                right[i] -= factor * right[k];
            }
        }
        for k in (0..n).rev() {
            for j in k + 1..n {
                right[k] -= matrix[k * n + j] * right[j];
            }
            right[k] /= matrix[k * n + k];
        }
        Ok(())
    }

    /// Joints that move, in the order of their torques.
    pub fn moving(&self) -> &[usize] {
        &self.moving
    }
}

fn times(matrix: &[f64], x: &[f64]) -> Vec<f64> {
    let rows = matrix.chunks(x.len());
    rows.map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum())
        .collect()
}
