//! Joint motion, torques of the bodies and of laws at the joints, and the way to the motors.

use crate::chain::effect::sign::{sign, sign_by_velocity, sign_by_width};
use crate::chain::effect::tilt::tilted_by_angles;
use crate::chain::effect::{Contribution, Law, Samples, Surroundings};
use crate::chain::evaluate::block::SeriesPart;
use crate::chain::evaluate::{BLOCK, Evaluator, Segment};
use crate::robot::batch::{InverseDynamics, RegressorBatch, Trajectory, Wanted};
use crate::robot::inertia::PER_LINK;
use std::ops::Range;
use std::rc::Rc;

/// What laws at a joint are given, over the samples of `range`; `sign` is that of its velocity.
pub(super) fn at_joint<'a>(
    motion: &'a [Vec<Vec<f64>>; 3],
    j: usize,
    sign: &'a [f64],
    segment: Segment<'a>,
    range: Range<usize>,
) -> Samples<'a> {
    let [position, velocity, acceleration] = motion;
    Samples {
        position: &position[j][..range.len()],
        velocity: &velocity[j][..range.len()],
        acceleration: &acceleration[j][..range.len()],
        sign: &sign[..range.len()],
        surroundings: Surroundings {
            temperature: segment.temperatures(j, range.clone()),
            ..Surroundings::default()
        },
        time: segment.times(range),
        cyclic: segment.cyclic,
    }
}

/// Position and velocity of other joints over the samples of a range.
pub(super) fn of_others<'a>(
    others: &[usize],
    motion: &'a [Vec<Vec<f64>>; 3],
    range: Range<usize>,
) -> Vec<[&'a [f64]; 2]> {
    let of = |&j: &usize| [0, 1].map(|order| &motion[order][j][range.clone()]);
    others.iter().map(of).collect()
}

impl Evaluator<'_> {
    /// `q = V m + offset`, that of the encoder with it, and the same for the derivatives without offsets.
    pub(super) fn move_joints(&mut self, motors: Trajectory<'_>, range: Range<usize>) {
        let n = self.model.joints().len();
        let last = range.len();
        let inputs = [motors.q, motors.dq, motors.ddq];
        for (which, input) in inputs.into_iter().enumerate() {
            for i in 0..n {
                let out = &mut self.joint_motion[which][i];
                let constant = if which == 0 {
                    self.model.offset()[i] + self.model.encoder_offset(i, &self.values)
                } else {
                    0.0
                };
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
            }
        }
    }

    /// Joint torques and base wrench of the bodies, and the columns of their parameters.
    ///
    /// Torques come from the recursion of Newton and Euler, which costs a tenth of the columns; the columns of
    /// links of which nothing is unknown are left out, and the joints that nothing asked for depends on.
    pub(super) fn rigid_body(&mut self, segment: Segment<'_>, range: Range<usize>) {
        let (loaded, samples) = (segment.loaded, range.len());
        if let Some(known) = segment.bodies {
            for (to, torque) in self.rigid.values.iter_mut().zip(&known.torque) {
                to[..samples].copy_from_slice(&torque[range.clone()]);
            }
            return;
        }
        let sums = self.has_sums();
        let bodies = Rc::clone(&self.bodies[usize::from(loaded)]);
        let joints = self.joints_asked_for();
        if !sums {
            let [q, dq, ddq] = &self.joint_motion;
            let dynamics = InverseDynamics {
                tree: &self.tree,
                parameters: &bodies,
                trajectory: Trajectory { q, dq, ddq },
                samples,
                wanted: &joints,
            };
            dynamics.put_into(&mut self.rigid.values);
        }
        let links: Vec<bool> = (0..self.tree.len())
            .map(|link| sums || self.has_columns(link, loaded))
            .collect();
        if !links.contains(&true) {
            return;
        }
        let wanted = Wanted {
            links: &links,
            joints: &joints,
        };
        let mut regressor = self.lend_regressor();
        for start in (0..samples).step_by(BLOCK) {
            let range = start..samples.min(start + BLOCK);
            regressor.evaluate_wanted(&self.tree, self.trajectory(), range.clone(), wanted);
            if sums {
                self.sum_bodies(&regressor, &bodies, range.clone());
            }
            self.body_columns(&regressor, segment, wanted, range);
        }
        self.regressor = Some(regressor);
    }

    /// Whether a parameter of a link, or of the load on it, has a column.
    fn has_columns(&self, link: usize, loaded: bool) -> bool {
        let any = |first: usize| (first..first + PER_LINK).any(|p| self.column[p].is_some());
        let load = self
            .model
            .payload()
            .filter(|(p, _)| loaded && p.link == link);
        any(PER_LINK * link) || load.is_some_and(|(_, first)| any(first))
    }

    fn lend_regressor(&mut self) -> RegressorBatch {
        let anew = || RegressorBatch::new(&self.tree, self.model.signal().rows(), BLOCK);
        self.regressor.take().unwrap_or_else(anew)
    }

    /// Σ column · parameter of every row.
    fn sum_bodies(&mut self, regressor: &RegressorBatch, bodies: &[f64], range: Range<usize>) {
        let torque_rows = self.torque_rows();
        for row in 0..self.rigid.values.len() {
            for (parameter, weight) in bodies.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                if row < torque_rows && !self.tree.moves(row, parameter / PER_LINK) {
                    continue;
                }
                let series = &regressor.column(row, parameter)[..range.len()];
                let values = &mut self.rigid.values[row][range.clone()];
                for (to, y) in values.iter_mut().zip(series) {
                    *to += weight * y;
                }
            }
        }
    }

    fn body_columns(
        &mut self,
        regressor: &RegressorBatch,
        segment: Segment<'_>,
        wanted: Wanted<'_>,
        range: Range<usize>,
    ) {
        let torque_rows = self.torque_rows();
        let is_wanted = |row: &usize| *row >= torque_rows || wanted.joints[*row];
        for row in (0..self.rigid.values.len()).filter(is_wanted) {
            for link in (0..wanted.links.len()).filter(|&link| wanted.links[link]) {
                if row < torque_rows && !self.tree.moves(row, link) {
                    continue;
                }
                for quantity in 0..PER_LINK {
                    let parameter = PER_LINK * link + quantity;
                    let part = SeriesPart {
                        channel: row,
                        start: range.start,
                        samples: &regressor.column(row, parameter)[..range.len()],
                    };
                    if let Some(column) = self.column[parameter] {
                        self.rigid.add_part(column, 1.0, part);
                    }
                    if segment.loaded {
                        self.payload_columns(link, quantity, part);
                    }
                }
            }
        }
    }

    /// The load's parameters enter through the columns of the link that carries it.
    fn payload_columns(&mut self, link: usize, entry: usize, part: SeriesPart<'_>) {
        let (Some((payload, first)), Some(transfer)) = (self.model.payload(), self.transfer) else {
            return;
        };
        if payload.link != link {
            return;
        }
        for quantity in 0..PER_LINK {
            let weight = transfer[(entry, quantity)];
            if let (Some(column), true) = (self.column[first + quantity], weight != 0.0) {
                self.rigid.add_part(column, weight, part);
            }
        }
    }

    /// ∂τ/∂roll and ∂τ/∂pitch: the torque that the change of gravity alone would take at rest.
    pub(super) fn tilt_columns(&mut self, loaded: bool, samples: usize) {
        let Some(at) = self.model.tilt() else { return };
        if self.column[at].is_none() && self.column[at + 1].is_none() {
            return;
        }
        let angles = [self.values[at], self.values[at + 1]];
        let changes = tilted_by_angles(&self.model.tree().gravity(), angles);
        let bodies = Rc::clone(&self.bodies[usize::from(loaded)]);
        let still = vec![vec![0.0; samples]; self.tree.len()];
        let mut regressor = self.lend_regressor();
        for (angle, change) in changes.into_iter().enumerate() {
            let Some(column) = self.column[at + angle] else {
                continue;
            };
            let turned = self.model.tree().clone().with_gravity(change.into());
            for start in (0..samples).step_by(BLOCK) {
                let range = start..samples.min(start + BLOCK);
                let motion = Trajectory {
                    q: &self.joint_motion[0],
                    dq: &still,
                    ddq: &still,
                };
                regressor.evaluate(&turned, motion, range.clone());
                for row in 0..self.rigid.values.len() {
                    for (parameter, weight) in bodies.iter().enumerate() {
                        if *weight != 0.0 {
                            let part = SeriesPart {
                                channel: row,
                                start: range.start,
                                samples: &regressor.column(row, parameter)[..range.len()],
                            };
                            self.rigid.add_part(column, *weight, part);
                        }
                    }
                }
            }
        }
        self.regressor = Some(regressor);
    }

    /// Torques of laws at the joints.
    pub(super) fn joint_laws(&mut self, segment: Segment<'_>, range: Range<usize>) {
        let has_none = self.stiffness.is_empty();
        if has_none || self.torque_rows() == 0 {
            return;
        }
        for series in self.stiffness.iter_mut().chain(&mut self.damping) {
            series.fill(0.0);
        }
        let asked_for = self.joints_asked_for();
        for j in (0..self.model.joints().len()).filter(|&j| asked_for[j]) {
            let joint = &self.model.joints()[j];
            let width = joint.width.map_or(0.0, |at| self.values[at]);
            for (index, &(effect, first)) in joint.effects.iter().enumerate() {
                let Law::Joint(law) = effect.law else {
                    continue;
                };
                if joint.locked || !self.acts(effect.needs.memory) {
                    continue;
                }
                let count = effect.parameters.len();
                let scratch = &mut self.scratch;
                for series in &mut scratch.by_parameter[..count] {
                    series.fill(0.0);
                }
                scratch.by_sign.fill(0.0);
                let velocity = &self.joint_motion[1][j][..range.len()];
                for (to, v) in scratch.sign.iter_mut().zip(velocity) {
                    *to = sign(*v, width);
                }
                let others = of_others(&joint.others[index], &self.joint_motion, 0..range.len());
                let mut input =
                    at_joint(&self.joint_motion, j, &scratch.sign, segment, range.clone());
                input.surroundings.others = &others;
                input.surroundings.period = self.model.period();
                let mut out = Contribution {
                    torque: &mut self.rigid.values[j],
                    by_parameter: &mut scratch.by_parameter[..count],
                    by_sign: &mut scratch.by_sign,
                    by_position: &mut self.stiffness[j],
                    by_velocity: &mut self.damping[j],
                };
                law.add(
                    input,
                    &self.values.as_slice()[first..first + count],
                    &mut out,
                );
                for parameter in 0..count {
                    if let Some(column) = self.column[first + parameter] {
                        let series = &self.scratch.by_parameter[parameter];
                        self.rigid.add_scaled(j, column, 1.0, series);
                    }
                }
                for (k, by_sign) in self.scratch.by_sign[..range.len()].iter().enumerate() {
                    let slope = sign_by_velocity(self.joint_motion[1][j][k], width);
                    self.damping[j][k] += by_sign * slope;
                }
                if let Some(column) = joint.width.and_then(|at| self.column[at]) {
                    let pairs = self.scratch.by_sign.iter().zip(&self.joint_motion[1][j]);
                    let series: Vec<f64> = pairs
                        .take(range.len())
                        .map(|(by_sign, v)| by_sign * sign_by_width(*v, width))
                        .collect();
                    if series.iter().any(|x| *x != 0.0) {
                        self.rigid.add_scaled(j, column, 1.0, &series);
                    }
                }
            }
        }
    }

    /// `τ_M = Vᵀ τ`; a base wrench goes to the frame of its sensor.
    pub(super) fn carry_to_motors(&mut self) {
        let n = self.model.joints().len();
        let torque_rows = self.torque_rows();
        for row in 0..self.rigid.values.len() {
            let targets: Vec<(usize, f64)> = match (&self.coupling, row.checked_sub(torque_rows)) {
                (_, Some(component)) => {
                    let column = self.model.platform().transfer.column(component);
                    let weights = column.iter().enumerate();
                    weights.map(|(c, w)| (torque_rows + c, *w)).collect()
                }
                (Some(v), None) => (0..n).map(|r| (r, v[(row, r)])).collect(),
                (None, None) => vec![(row, 1.0)],
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
                if !self.is_needed(channel) {
                    continue;
                }
                for column in 0..self.block.columns {
                    let series = self.rigid.lend(row, column);
                    if !series.is_empty() {
                        self.block.add_scaled(channel, column, weight, &series);
                    }
                    self.rigid.give_back(row, column, series);
                }
            }
        }
    }
}
