//! From the transmitted torque to the signal: losses of the gear, laws of the motor, the current.

use crate::chain::effect::current_polynomial::{COEFFICIENTS, current};
use crate::chain::effect::sign::{sign, sign_by_width};
use crate::chain::effect::{
    Contribution, Effect, Law, Samples, Surroundings, TransmissionLaw, Transmitted,
};
use crate::chain::evaluate::{Evaluator, Segment};
use crate::robot::batch::Trajectory;
use std::ops::Range;

/// Where a law that depends on a torque acts.
#[derive(Debug, Clone, Copy)]
enum Stage {
    Gear,
    Signal,
}

impl Stage {
    fn law(self, effect: &Effect) -> Option<&'static dyn TransmissionLaw> {
        match (self, effect.law) {
            (Self::Gear, Law::Transmission(law)) | (Self::Signal, Law::Signal(law)) => Some(law),
            _ => None,
        }
    }
}

/// What laws at a motor are given of its motion over some samples, without the rounded-off sign of its velocity.
fn at_motor<'a>(segment: Segment<'a>, j: usize, range: Range<usize>) -> Samples<'a> {
    let motors = segment.motors;
    Samples {
        position: &motors.q[j][range.clone()],
        velocity: &motors.dq[j][range.clone()],
        acceleration: &motors.ddq[j][range.clone()],
        sign: &[],
        surroundings: Surroundings {
            temperature: segment.temperatures(j, range.clone()),
            ..Surroundings::default()
        },
        time: segment.times(range),
        cyclic: segment.cyclic,
    }
}

/// Position and velocity of other motors over some samples.
fn of_others<'a>(
    others: &[usize],
    motors: Trajectory<'a>,
    range: Range<usize>,
) -> Vec<[&'a [f64]; 2]> {
    let of = |&j: &usize| [&motors.q[j][range.clone()], &motors.dq[j][range.clone()]];
    others.iter().map(of).collect()
}

impl Evaluator<'_> {
    /// `v/(|v| + w)` of a motor.
    pub(super) fn motor_sign(&mut self, j: usize, motors: Trajectory<'_>, range: Range<usize>) {
        let width = self.model.joints()[j]
            .width
            .map_or(0.0, |at| self.values[at]);
        for (to, v) in self.scratch.sign.iter_mut().zip(&motors.dq[j][range]) {
            *to = sign(*v, width);
        }
        self.scratch.by_sign.fill(0.0);
    }

    /// `τ_in = τ_M + losses(τ_M)`.
    pub(super) fn transmission(&mut self, j: usize, segment: Segment<'_>, range: Range<usize>) {
        self.laws_of_load(j, segment, range, Stage::Gear);
    }

    /// What the signal shows beyond the torque of the motor.
    pub(super) fn signal_laws(&mut self, j: usize, segment: Segment<'_>, range: Range<usize>) {
        self.laws_of_load(j, segment, range, Stage::Signal);
    }

    /// Adds laws that depend on the torque of the channel.
    fn laws_of_load(&mut self, j: usize, segment: Segment<'_>, range: Range<usize>, stage: Stage) {
        let joint = &self.model.joints()[j];
        let (samples, motors) = (range.len(), segment.motors);
        if !joint.effects.iter().any(|(e, _)| stage.law(e).is_some()) {
            return;
        }
        let load = self.block.values[j][..samples].to_vec();
        self.scratch.by_load.fill(0.0);
        let before = std::mem::take(&mut self.scratch.by_sign);
        self.scratch.by_sign = vec![0.0; before.len()];
        let mut added: Vec<(usize, Vec<f64>)> = Vec::new();
        for (index, &(effect, first)) in joint.effects.iter().enumerate() {
            let Some(law) = stage.law(effect) else {
                continue;
            };
            let count = effect.parameters.len();
            let others = of_others(&joint.others[index], motors, range.clone());
            let scratch = &mut self.scratch;
            let mut input = at_motor(segment, j, range.clone());
            input.sign = &scratch.sign[..samples];
            input.surroundings.others = &others;
            input.surroundings.period = self.model.period();
            input.surroundings.torque_constant = Some(joint.torque_constant);
            let mut out = Transmitted {
                torque: &mut self.block.values[j],
                by_load: &mut scratch.by_load,
                by_parameter: &mut scratch.by_parameter[..count],
                by_sign: &mut scratch.by_sign,
                rounding: joint.rounding,
            };
            let own = &self.values.as_slice()[first..first + count];
            law.add(input, &load, own, &mut out);
            for parameter in 0..count {
                if let Some(column) = self.column[first + parameter] {
                    added.push((column, scratch.by_parameter[parameter][..samples].to_vec()));
                }
            }
        }
        for series in self.block.written(j) {
            for (x, slope) in series.iter_mut().zip(&self.scratch.by_load) {
                *x *= 1.0 + slope;
            }
        }
        let pairs = before.iter().zip(&self.scratch.by_load);
        for (by_sign, (before, slope)) in self.scratch.by_sign.iter_mut().zip(pairs) {
            *by_sign += before * (1.0 + slope);
        }
        for (column, series) in added {
            self.block.add_scaled(j, column, 1.0, &series);
        }
    }

    /// `τ_mot = τ_in + Σ laws`.
    pub(super) fn motor_laws(&mut self, j: usize, segment: Segment<'_>, range: Range<usize>) {
        let joint = &self.model.joints()[j];
        let (samples, motors) = (range.len(), segment.motors);
        for (index, &(effect, first)) in joint.effects.iter().enumerate() {
            let Law::Motor(law) = effect.law else {
                continue;
            };
            // Of states that stand alone a law with memory says nothing: what it replaces stays.
            let replaced = joint.replaced[index] && self.along;
            if replaced || !self.acts(effect.needs.memory) {
                continue;
            }
            let scratch = &mut self.scratch;
            let positions = first..first + effect.parameters.len();
            let positions = positions.chain(joint.borrowed[index].iter().copied());
            scratch.parameters.clear();
            scratch
                .parameters
                .extend(positions.clone().map(|p| self.values[p]));
            let count = scratch.parameters.len();
            for series in &mut scratch.by_parameter[..count] {
                series.fill(0.0);
            }
            let others = of_others(&joint.others[index], motors, range.clone());
            let mut input = at_motor(segment, j, range.clone());
            input.sign = &scratch.sign[..samples];
            input.surroundings.others = &others;
            input.surroundings.period = self.model.period();
            let mut out = Contribution {
                torque: &mut self.block.values[j],
                by_parameter: &mut scratch.by_parameter[..count],
                by_sign: &mut scratch.by_sign,
                by_position: &mut scratch.by_position,
                by_velocity: &mut scratch.by_velocity,
            };
            law.add(input, &scratch.parameters, &mut out);
            for (parameter, position) in positions.enumerate() {
                if let Some(column) = self.column[position] {
                    let series = &self.scratch.by_parameter[parameter];
                    self.block.add_scaled(j, column, 1.0, series);
                }
            }
        }
    }

    /// ∂τ_mot/∂w, by way of the sign of ṁ.
    pub(super) fn width_column(&mut self, j: usize, motors: Trajectory<'_>, range: Range<usize>) {
        let Some(at) = self.model.joints()[j].width else {
            return;
        };
        let (Some(column), width) = (self.column[at], self.values[at]) else {
            return;
        };
        let series = self.block.series(j, column);
        for (k, v) in motors.dq[j][range].iter().enumerate() {
            series[k] += self.scratch.by_sign[k] * sign_by_width(*v, width);
        }
    }

    /// `s = τ_mot / (k · gain)`, the current at which the polynomial gives τ_mot / gain, or the error at which the
    /// controller does.
    pub(super) fn carry_to_signal(&mut self, j: usize, segment: Segment<'_>, range: Range<usize>) {
        let joint = &self.model.joints()[j];
        let gain = joint.gain.map_or(1.0, |at| self.values[at]);
        if let Some(column) = joint.gain.and_then(|at| self.column[at]) {
            // ∂(τ_mot/gain)/∂gain, before the division by the gain below.
            let values = std::mem::take(&mut self.block.values[j]);
            self.block.add_scaled(j, column, -1.0 / gain, &values);
            self.block.values[j] = values;
        }
        let factor = match joint.polynomial {
            Some(_) => 1.0 / gain,
            None => 1.0 / (joint.torque_constant * gain),
        };
        if factor != 1.0 {
            for value in &mut self.block.values[j] {
                *value *= factor;
            }
            for series in self.block.written(j) {
                series.iter_mut().for_each(|x| *x *= factor);
            }
        }
        if let Some(first) = joint.polynomial {
            self.currents(j, first, range.len());
        }
        if let Some(kp) = joint.controller {
            self.errors(j, kp, segment, range);
        }
    }

    /// Torques become errors of the controller: `s = (τ + kd (ṁ − v_c) − u) / kp`.
    fn errors(&mut self, j: usize, at: usize, segment: Segment<'_>, range: Range<usize>) {
        let (kp, kd) = (self.values[at], self.values[at + 1]);
        let mut rate = segment.motors.dq[j][range.clone()].to_vec();
        let commands = segment.commands.map(|all| all.later(range.start));
        if let Some(commands) = commands {
            let pairs = rate.iter_mut().zip(commands.velocity(j));
            pairs.for_each(|(rate, commanded)| *rate -= commanded);
            let pairs = self.block.values[j]
                .iter_mut()
                .zip(commands.feed_forward(j));
            pairs.for_each(|(torque, fed)| *torque -= fed);
        }
        let pairs = self.block.values[j].iter_mut().zip(&rate);
        pairs.for_each(|(torque, rate)| *torque += kd * rate);
        if let Some(column) = self.column[at + 1] {
            self.block.add_scaled(j, column, 1.0, &rate);
        }
        if let Some(column) = self.column[at] {
            let values = std::mem::take(&mut self.block.values[j]);
            self.block.add_scaled(j, column, -1.0 / kp, &values);
            self.block.values[j] = values;
        }
        self.block.values[j].iter_mut().for_each(|x| *x /= kp);
        for series in self.block.written(j) {
            series.iter_mut().for_each(|x| *x /= kp);
        }
    }

    /// Torques become currents.
    fn currents(&mut self, j: usize, first: usize, samples: usize) {
        let c: [f64; COEFFICIENTS] = std::array::from_fn(|k| self.values[first + k]);
        let inverse: Vec<_> = self.block.values[j][..samples]
            .iter()
            .map(|torque| current(c, *torque))
            .collect();
        for series in self.block.written(j) {
            for (x, inverse) in series.iter_mut().zip(&inverse) {
                *x *= inverse.by_torque;
            }
        }
        for k in 0..COEFFICIENTS {
            let Some(column) = self.column[first + k] else {
                continue;
            };
            let series = self.block.series(j, column);
            for (x, inverse) in series.iter_mut().zip(&inverse) {
                *x += inverse.by_coefficient[k];
            }
        }
        for (value, inverse) in self.block.values[j].iter_mut().zip(&inverse) {
            *value = inverse.current;
        }
    }
}
