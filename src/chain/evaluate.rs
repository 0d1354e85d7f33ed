//! Predicts the signal and its derivatives with respect to parameters, block by block of samples.
//!
//! Each stage of the chain transforms a value and the columns of its derivatives alike, so that a sum,
//! a product with Vᵀ or a division is written once for both. A column that a channel cannot depend on
//! is absent and costs nothing.

use crate::chain::effect::coulomb_friction::{sign, sign_by_width};
use crate::chain::effect::{Contribution, Law, Samples};
use crate::chain::model::{Model, Signal};
use crate::chain::parameter::Role;
use crate::robot::batch::{RegressorBatch, Trajectory};
use crate::robot::derivatives::Derivatives;
use crate::robot::inertia::PER_LINK;
use nalgebra::{DMatrix, DVector, SMatrix};
use std::ops::Range;
use std::rc::Rc;

/// Samples that an evaluator takes at once: the block stays in the second-level cache.
pub const BLOCK: usize = 64;

/// Motion of the motors at joint scale, `[joint][sample]`, and what the robot carries.
#[derive(Debug, Clone, Copy)]
pub struct Segment<'a> {
    pub motors: Trajectory<'a>,
    /// The load hangs on the robot.
    pub loaded: bool,
}

/// The signal of one block and its derivatives.
#[derive(Debug, Clone)]
pub struct Block {
    samples: usize,
    columns: usize,
    values: Vec<Vec<f64>>,
    /// `[channel · columns + column]`; empty where absent.
    derivatives: Vec<Vec<f64>>,
}

impl Block {
    fn new(channels: usize, columns: usize) -> Self {
        Self {
            samples: 0,
            columns,
            values: vec![vec![0.0; BLOCK]; channels],
            derivatives: vec![Vec::new(); channels * columns],
        }
    }

    /// Predicted signal of a channel.
    pub fn value(&self, channel: usize) -> &[f64] {
        &self.values[channel][..self.samples]
    }

    /// ∂signal/∂parameter of a channel; `None` where it is zero whatever the motion.
    pub fn derivative(&self, channel: usize, column: usize) -> Option<&[f64]> {
        let series = &self.derivatives[channel * self.columns + column];
        series.get(..self.samples)
    }

    fn clear(&mut self, samples: usize) {
        self.samples = samples;
        for value in &mut self.values {
            value.fill(0.0);
        }
        for series in &mut self.derivatives {
            series.fill(0.0);
        }
    }

    fn series(&mut self, channel: usize, column: usize) -> &mut Vec<f64> {
        let series = &mut self.derivatives[channel * self.columns + column];
        if series.is_empty() {
            series.resize(BLOCK, 0.0);
        }
        series
    }

    fn add_scaled(&mut self, at: (usize, usize), factor: f64, from: &[f64]) {
        for (to, x) in self.series(at.0, at.1).iter_mut().zip(from) {
            *to += factor * x;
        }
    }
}

/// Evaluates a model over blocks; one per thread.
#[derive(Debug)]
pub struct Evaluator<'m> {
    model: &'m Model,
    /// Column of each parameter, if it has one.
    column: Vec<Option<usize>>,
    values: DVector<f64>,
    coupling: Option<DMatrix<f64>>,
    transfer: Option<SMatrix<f64, PER_LINK, PER_LINK>>,
    /// Inertial parameters of the links without and with the load.
    bodies: [Rc<[f64]>; 2],
    regressor: RegressorBatch,
    derivatives: Option<Derivatives>,
    joint_motion: [Vec<Vec<f64>>; 3],
    rigid: Block,
    block: Block,
    scratch: Scratch,
}

#[derive(Debug)]
struct Scratch {
    sign: Vec<f64>,
    by_sign: Vec<f64>,
    by_parameter: Vec<Vec<f64>>,
}

impl<'m> Evaluator<'m> {
    /// An evaluator of `model` at parameter `values`, with derivatives with respect to `columns`
    /// (positions of parameters).
    pub fn new(model: &'m Model, values: &DVector<f64>, columns: &[usize]) -> Self {
        let (tree, channels) = (model.tree(), model.channels().len());
        let n = tree.len();
        let rows = model.signal().rows();
        let mut column = vec![None; model.parameters().len()];
        for (k, &parameter) in columns.iter().enumerate() {
            column[parameter] = Some(k);
        }
        let wants_coupling = columns
            .iter()
            .any(|&p| matches!(model.parameters()[p].role, Role::Coupling { .. }));
        let motion = || vec![vec![0.0; BLOCK]; n];
        Self {
            model,
            column,
            values: values.clone(),
            coupling: (!model.is_uncoupled()).then(|| model.coupling(values)),
            transfer: model.payload().map(|(payload, _)| payload.transfer()),
            bodies: [false, true].map(|loaded| bodies(model, values, loaded).into()),
            regressor: RegressorBatch::new(tree, rows, BLOCK),
            derivatives: wants_coupling.then(|| Derivatives::new(tree)),
            joint_motion: [motion(), motion(), motion()],
            rigid: Block::new(rows.count(n), columns.len()),
            block: Block::new(channels, columns.len()),
            scratch: Scratch {
                sign: vec![0.0; BLOCK],
                by_sign: vec![0.0; BLOCK],
                by_parameter: vec![vec![0.0; BLOCK]; PER_LINK],
            },
        }
    }

    /// The signal of the samples of `range` (at most [`BLOCK`]) and its derivatives.
    pub fn evaluate(&mut self, segment: Segment<'_>, range: Range<usize>) -> &Block {
        let samples = range.len();
        self.block.clear(samples);
        self.rigid.clear(samples);
        self.move_joints(segment.motors, range.clone());
        self.rigid_body(segment.loaded, samples);
        self.carry_to_motors();
        self.coupling_derivatives(segment, range.clone());
        for j in 0..self.model.joints().len() {
            if !self.model.joints()[j].locked && self.channel_of(j).is_some() {
                self.motor_laws(j, segment.motors, range.clone());
                self.carry_to_signal(j);
            }
        }
        &self.block
    }

    /// Joint torques come first among the channels, if they are measured at all.
    fn channel_of(&self, joint: usize) -> Option<usize> {
        self.model.channels().get(joint)?.joint
    }

    /// `q = V m + offset`, and the same for the derivatives without the offset.
    fn move_joints(&mut self, motors: Trajectory<'_>, range: Range<usize>) {
        let n = self.model.joints().len();
        let inputs = [motors.q, motors.dq, motors.ddq];
        for (which, input) in inputs.into_iter().enumerate() {
            for i in 0..n {
                let out = &mut self.joint_motion[which][i];
                let constant = if which == 0 {
                    self.model.offset()[i]
                } else {
                    0.0
                };
                let last = range.len();
                match &self.coupling {
                    None => {
                        for (to, x) in out.iter_mut().zip(&input[i][range.clone()]) {
                            *to = x + constant;
                        }
                    }
                    Some(v) => {
                        out[..last].fill(constant);
                        for j in (0..n).filter(|&j| v[(i, j)] != 0.0) {
                            for (to, x) in out.iter_mut().zip(&input[j][range.clone()]) {
                                *to += v[(i, j)] * x;
                            }
                        }
                    }
                }
                let end = out[last - 1];
                out[last..].fill(end);
            }
        }
    }

    fn trajectory(&self) -> Trajectory<'_> {
        let [q, dq, ddq] = &self.joint_motion;
        Trajectory { q, dq, ddq }
    }

    /// Joint torques and base wrench of the bodies, and the columns of their parameters.
    fn rigid_body(&mut self, loaded: bool, samples: usize) {
        let tree = self.model.tree();
        let mut regressor = std::mem::replace(
            &mut self.regressor,
            RegressorBatch::new(tree, self.model.signal().rows(), 0),
        );
        regressor.evaluate(tree, self.trajectory(), 0..samples);
        let n = tree.len();
        let torque_rows = if self.model.signal() == Signal::BaseWrench {
            0
        } else {
            n
        };
        let bodies = Rc::clone(&self.bodies[usize::from(loaded)]);
        for row in 0..self.rigid.values.len() {
            for link in 0..n {
                if row < torque_rows && !tree.moves(row, link) {
                    continue;
                }
                for quantity in 0..PER_LINK {
                    let parameter = PER_LINK * link + quantity;
                    let series = regressor.column(row, parameter);
                    let weight = bodies[parameter];
                    if weight != 0.0 {
                        for (to, y) in self.rigid.values[row].iter_mut().zip(series) {
                            *to += weight * y;
                        }
                    }
                    if let Some(column) = self.column[parameter] {
                        self.rigid.add_scaled((row, column), 1.0, series);
                    }
                    if loaded {
                        self.payload_columns(row, (link, quantity), series);
                    }
                }
            }
        }
        self.regressor = regressor;
    }

    /// The load's parameters enter through the columns of the link that carries it.
    fn payload_columns(&mut self, row: usize, (link, entry): (usize, usize), series: &[f64]) {
        let (Some((payload, first)), Some(transfer)) = (self.model.payload(), self.transfer) else {
            return;
        };
        if payload.link != link {
            return;
        }
        for quantity in 0..PER_LINK {
            let weight = transfer[(entry, quantity)];
            if let (Some(column), true) = (self.column[first + quantity], weight != 0.0) {
                self.rigid.add_scaled((row, column), weight, series);
            }
        }
    }

    /// `τ_M = Vᵀ τ`; a base wrench passes unchanged.
    fn carry_to_motors(&mut self) {
        let n = self.model.joints().len();
        let torque_rows = if self.model.signal() == Signal::BaseWrench {
            0
        } else {
            n
        };
        for row in 0..self.rigid.values.len() {
            let uncoupled = row >= torque_rows || self.coupling.is_none();
            let targets: Vec<(usize, f64)> = match &self.coupling {
                Some(v) if !uncoupled => (0..n).map(|r| (r, v[(row, r)])).collect(),
                _ => vec![(row, 1.0)],
            };
            for (channel, weight) in targets {
                if weight == 0.0 {
                    continue;
                }
                for (to, x) in self.block.values[channel]
                    .iter_mut()
                    .zip(&self.rigid.values[row])
                {
                    *to += weight * x;
                }
                for column in 0..self.block.columns {
                    let at = row * self.rigid.columns + column;
                    let series = std::mem::take(&mut self.rigid.derivatives[at]);
                    if !series.is_empty() {
                        self.block.add_scaled((channel, column), weight, &series);
                    }
                    self.rigid.derivatives[at] = series;
                }
            }
        }
    }

    /// `∂τ_M/∂V_ij = Vᵀ (∂τ/∂q_i m_j + ∂τ/∂q̇_i ṁ_j + ∂τ/∂q̈_i m̈_j) + e_j τ_i`.
    fn coupling_derivatives(&mut self, segment: Segment<'_>, range: Range<usize>) {
        let (Some(mut derivatives), Some(v)) = (self.derivatives.take(), self.coupling.clone())
        else {
            return;
        };
        let n = self.model.joints().len();
        let entries: Vec<(usize, usize, usize)> = self
            .model
            .parameters()
            .iter()
            .enumerate()
            .filter_map(|(p, parameter)| match parameter.role {
                Role::Coupling { row, column } => Some((self.column[p]?, row, column)),
                _ => None,
            })
            .collect();
        let bodies = Rc::clone(&self.bodies[usize::from(segment.loaded)]);
        let motors = segment.motors;
        let mut state = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        for (k, sample) in range.enumerate() {
            for (values, motion) in state.iter_mut().zip(&self.joint_motion) {
                for i in 0..n {
                    values[i] = motion[i][k];
                }
            }
            let slices = [&state[0][..], &state[1], &state[2]];
            derivatives.evaluate(self.model.tree(), &bodies, slices);
            for &(column, i, j) in &entries {
                let (m, dm, ddm) = (
                    motors.q[j][sample],
                    motors.dq[j][sample],
                    motors.ddq[j][sample],
                );
                let moved = derivatives.position.column(i) * m
                    + derivatives.velocity.column(i) * dm
                    + derivatives.mass.column(i) * ddm;
                let mut change = v.tr_mul(&moved);
                change[j] += derivatives.torque[i];
                let [by_q, by_dq, by_ddq] = &derivatives.base;
                let wrench = by_q.column(i) * m + by_dq.column(i) * dm + by_ddq.column(i) * ddm;
                let torques = if self.model.signal() == Signal::BaseWrench {
                    0
                } else {
                    n
                };
                for channel in 0..self.block.values.len() {
                    let by_entry = match channel.checked_sub(torques) {
                        Some(component) => wrench[component],
                        None => change[channel],
                    };
                    self.block.series(channel, column)[k] += by_entry;
                }
            }
        }
        self.derivatives = Some(derivatives);
    }

    /// `τ_mot = τ_M + Σ laws`.
    fn motor_laws(&mut self, j: usize, motors: Trajectory<'_>, range: Range<usize>) {
        let joint = &self.model.joints()[j];
        let samples = range.len();
        let velocity = &motors.dq[j][range.clone()];
        let width = joint.width.map_or(0.0, |at| self.values[at]);
        for (to, v) in self.scratch.sign.iter_mut().zip(velocity) {
            *to = sign(*v, width);
        }
        self.scratch.by_sign.fill(0.0);
        let input = Samples {
            position: &motors.q[j][range.clone()],
            velocity,
            acceleration: &motors.ddq[j][range.clone()],
            sign: &self.scratch.sign[..samples],
        };
        for &(effect, first) in &joint.effects {
            let Law::Motor(law) = effect.law else {
                continue;
            };
            let count = effect.parameters.len();
            for series in &mut self.scratch.by_parameter[..count] {
                series.fill(0.0);
            }
            let mut out = Contribution {
                torque: &mut self.block.values[j],
                by_parameter: &mut self.scratch.by_parameter[..count],
                by_sign: &mut self.scratch.by_sign,
            };
            law.add(
                input,
                &self.values.as_slice()[first..first + count],
                &mut out,
            );
            for parameter in 0..count {
                if let Some(column) = self.column[first + parameter] {
                    let series = &self.scratch.by_parameter[parameter];
                    self.block.add_scaled((j, column), 1.0, series);
                }
            }
        }
        if let Some(column) = joint.width.and_then(|at| self.column[at]) {
            for (k, v) in velocity.iter().enumerate() {
                let by_width = self.scratch.by_sign[k] * sign_by_width(*v, width);
                self.block.series(j, column)[k] += by_width;
            }
        }
    }

    /// `s = τ_mot / (k · gain)`.
    fn carry_to_signal(&mut self, j: usize) {
        let joint = &self.model.joints()[j];
        let gain = joint.gain.map_or(1.0, |at| self.values[at]);
        let factor = 1.0 / (joint.torque_constant * gain);
        if factor != 1.0 {
            for value in &mut self.block.values[j] {
                *value *= factor;
            }
            for column in 0..self.block.columns {
                for x in &mut self.block.derivatives[j * self.block.columns + column] {
                    *x *= factor;
                }
            }
        }
        if let Some(column) = joint.gain.and_then(|at| self.column[at]) {
            let values = std::mem::take(&mut self.block.values[j]);
            self.block.add_scaled((j, column), -1.0 / gain, &values);
            self.block.values[j] = values;
        }
    }
}

/// Inertial parameters of all links, the load added to its link where it is carried.
pub fn bodies(model: &Model, values: &DVector<f64>, loaded: bool) -> Vec<f64> {
    let count = PER_LINK * model.tree().len();
    let mut bodies = values.as_slice()[..count].to_vec();
    if let (Some((payload, first)), true) = (model.payload(), loaded) {
        let load = SMatrix::<f64, PER_LINK, 1>::from_fn(|k, _| values[first + k]);
        let seen = payload.transfer() * load;
        for k in 0..PER_LINK {
            bodies[PER_LINK * payload.link + k] += seen[k];
        }
    }
    bodies
}
