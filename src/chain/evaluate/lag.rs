//! Links that lag their motors: elastic gears and gears with play, friction behind them.
//!
//! ```text
//! q = V m + offset − δ,   c(δ, δ̇) = τ(q, q̇, q̈)     at the joints that lag
//! c = K (δ ∓ gap/2) + D δ̇  where |δ| > gap/2, else 0
//! ```
//!
//! Friction at a joint is friction of the link, on the far side of spring and play: `f sign(q̇)` with q̇ = V ṁ − δ̇ switches with the
//! lag itself, so that it is part of what every sample is solved for, beside c.
//!
//! The equation holds at every sample, with δ̇ and δ̈ from δ by backward differences ([`march`]); before
//! the first sample of a motion that does not repeat, δ is at rest. Torque and contact are linearised
//! about the last δ, which is Newton's method over the whole motion; the same matrices carry the columns
//! of the derivatives, which are exact for the solution as computed.
//!
//! [`march`]: super::march

use crate::chain::effect::law::signum;
use crate::chain::effect::sign::{sign, sign_by_velocity};
use crate::chain::effect::{Contribution, Law};
use crate::chain::evaluate::contact_march::{Twist, solve_with};
use crate::chain::evaluate::known_bodies::{KnownBodies, Slopes};
use crate::chain::evaluate::march::{Coefficients, March, Response, TimeGrid, largest};
use crate::chain::evaluate::rigid::{at_joint, of_others};
use crate::chain::evaluate::{Evaluator, Segment};
use crate::chain::flank::Flank;
use crate::robot::batch::torques;

/// Passes over the motion; the matrices change little with δ, so that those about the motion without lag usually do.
const PASSES: usize = 24;

/// A pass that moves δ by more than this share of the pass before leads nowhere.
const RATTLES: f64 = 0.9;

/// Bodies are linearised anew where a pass moves δ by more than this share of the pass before.
const FAST: f64 = 0.1;

/// Passes end when δ moves by less than this share of its largest value.
const PASS_TOLERANCE: f64 = 1e-11;

/// A joint that lags.
#[derive(Debug, Clone, Copy)]
struct Lagging {
    joint: usize,
    flank: Flank,
    /// Positions of K, D and gap among the columns.
    columns: [Option<usize>; 3],
}

/// Friction of a link that changes sides with its speed: `f sign(V ṁ − δ̇)`.
#[derive(Debug, Clone, Default)]
struct Switch {
    /// f at every sample, N·m (N); empty where there is none.
    level: Vec<f64>,
    /// Speed of the joint without lag.
    speed: Vec<f64>,
    width: f64,
}

impl Switch {
    fn is_there(&self) -> bool {
        !self.level.is_empty()
    }

    /// Torque at a sample where the link lags at a rate, and its derivative by that rate.
    fn torque(&self, k: usize, rate: f64) -> [f64; 2] {
        let velocity = self.speed[k] - rate;
        let slope = sign_by_velocity(velocity, self.width);
        [
            self.level[k] * sign(velocity, self.width),
            -self.level[k] * slope,
        ]
    }
}

/// The lag along a motion, and what carries derivatives through it.
#[derive(Debug)]
pub(super) struct Lag {
    members: Vec<Lagging>,
    switches: Vec<Switch>,
    motion: Response,
    slopes: Slopes,
    march: Option<March>,
}

impl Lag {
    fn rows(&self) -> Vec<usize> {
        self.members.iter().map(|m| m.joint).collect()
    }

    fn samples(&self) -> usize {
        self.motion[0].first().map_or(0, Vec::len)
    }

    /// M, V and Q of the bodies at every sample.
    fn bodies(&self) -> Coefficients {
        let (rows, count) = (self.rows(), self.members.len());
        let mut bodies = Coefficients::zeros(count, self.samples());
        for k in 0..self.samples() {
            for (f, g) in (0..count).flat_map(|f| (0..count).map(move |g| (f, g))) {
                let (from, to) = (self.slopes.at(k, rows[f], g), bodies.at(k, f, g));
                bodies.stiffness[to] = self.slopes.by[0][from];
                bodies.damping[to] = self.slopes.by[1][from];
                bodies.mass[to] = self.slopes.by[2][from];
            }
        }
        bodies
    }

    /// The equation of a change of δ about the present one.
    fn equation(&self, grid: TimeGrid) -> Option<March> {
        let mut coefficients = self.bodies();
        for k in 0..self.samples() {
            for (f, member) in self.members.iter().enumerate() {
                let contact = member
                    .flank
                    .contact(self.motion[0][f][k], self.motion[1][f][k]);
                let at = coefficients.at(k, f, f);
                coefficients.stiffness[at] += contact.by_lag;
                coefficients.damping[at] += contact.by_rate;
            }
        }
        March::new(coefficients, grid)
    }

    /// δ where the bodies stay linearised about the present one; `None` where there is no solution.
    fn next(&self, torque: &[Vec<f64>], grid: TimeGrid) -> Option<Response> {
        let is_linear = |(member, switch): (&Lagging, &Switch)| {
            member.flank.half_gap == 0.0 && !switch.is_there()
        };
        if self.members.iter().zip(&self.switches).all(is_linear) {
            let march = self.equation(grid)?;
            return Some(march.solve(&self.drive(torque, true)));
        }
        let resistance = |twist: Twist| {
            let contact = self.members[twist.member]
                .flank
                .contact(twist.lag, twist.rate);
            let switch = &self.switches[twist.member];
            let [friction, by_rate] = match switch.is_there() {
                true => switch.torque(twist.sample, twist.rate),
                false => [0.0; 2],
            };
            [
                contact.torque - friction,
                contact.by_lag,
                contact.by_rate - by_rate,
            ]
        };
        let source = self.drive(torque, false);
        Some(solve_with(
            &self.bodies(),
            grid,
            &source,
            &resistance,
            &self.motion,
        ))
    }

    /// Right-hand side of the equation of δ, `τ* + Q δ* + V δ̇* + M δ̈*`, and with contacts that are linearised too
    /// `− c* + ∂c/∂δ δ* + ∂c/∂δ̇ δ̇*`.
    fn drive(&self, torque: &[Vec<f64>], with_contact: bool) -> Vec<Vec<f64>> {
        let rows = self.rows();
        let of = |(f, member): (usize, &Lagging)| {
            let at = |(k, torque): (usize, &f64)| {
                let [lag, rate, _] = [0, 1, 2].map(|order: usize| self.motion[order][f][k]);
                let mut drive = *torque;
                if with_contact {
                    let contact = member.flank.contact(lag, rate);
                    drive += contact.by_lag * lag + contact.by_rate * rate - contact.torque;
                }
                for (slope, motion) in self.slopes.by.iter().zip(&self.motion) {
                    for (g, series) in motion.iter().enumerate() {
                        drive += slope[self.slopes.at(k, rows[f], g)] * series[k];
                    }
                }
                drive
            };
            torque[f].iter().enumerate().map(at).collect()
        };
        self.members.iter().enumerate().map(of).collect()
    }

    /// Friction that changes sides, as it is along the present motion.
    fn take_levels(&mut self, springs: Vec<AtJoint>) {
        for (switch, spring) in self.switches.iter_mut().zip(springs) {
            let switches = spring.level.iter().any(|level| *level != 0.0);
            switch.level = if switches { spring.level } else { Vec::new() };
            switch.width = spring.width;
        }
    }

    /// Adds what friction that changes sides makes of the derivatives by speed, where the links are now.
    fn add_switches(&mut self) {
        let rows = self.rows();
        for (f, switch) in self.switches.iter().enumerate() {
            if !switch.is_there() {
                continue;
            }
            for k in 0..switch.level.len() {
                let [_, by_rate] = switch.torque(k, self.motion[1][f][k]);
                let own = self.slopes.at(k, rows[f], f);
                self.slopes.by[1][own] -= by_rate;
            }
        }
    }

    /// With play, the flank on which the torque of the motion without lag rests.
    fn rest_on_flanks(&mut self, torque: &[Vec<f64>]) {
        for (f, member) in self.members.iter().enumerate() {
            if member.flank.half_gap == 0.0 {
                continue;
            }
            for (lag, torque) in self.motion[0][f].iter_mut().zip(&torque[f]) {
                *lag = member.flank.half_gap * signum(*torque) + torque / member.flank.stiffness;
            }
        }
    }
}

/// What laws at a joint do along a motion, without what changes sides with the speed.
struct AtJoint {
    torque: Vec<f64>,
    /// ∂torque/∂sign(q̇).
    level: Vec<f64>,
    width: f64,
    /// ∂torque/∂position and ∂torque/∂velocity.
    stiffness: Vec<f64>,
    damping: Vec<f64>,
}

impl Evaluator<'_> {
    /// Finds the lag of the links and moves the joints by it; `None` where no link lags. Where the bodies are known,
    /// the derivatives are those of bodies linearised about the motion without lag.
    pub(super) fn lag_of_links(&mut self, segment: Segment<'_>, samples: usize) -> Option<Lag> {
        let members = self.lagging();
        if !self.along || members.is_empty() || segment.time.len() < 2 || self.torque_rows() == 0 {
            return None;
        }
        let grid = TimeGrid {
            step: segment.step(),
            cyclic: segment.cyclic,
        };
        let series = || vec![vec![0.0; samples]; members.len()];
        let mut lag = Lag {
            motion: [series(), series(), series()],
            slopes: Slopes::default(),
            march: None,
            switches: vec![Switch::default(); members.len()],
            members,
        };
        let without = self.joint_motion.clone();
        for (switch, member) in lag.switches.iter_mut().zip(&lag.members) {
            switch.speed = without[1][member.joint][..samples].to_vec();
        }
        let known = segment.bodies.filter(|known| !known.slopes.is_empty());
        let mut torque = match known {
            Some(known) => self.recall(segment, samples, known, &mut lag),
            None => self.linearise(segment, samples, &mut lag),
        };
        lag.rest_on_flanks(&torque);
        let mut before = f64::INFINITY;
        for _ in 0..PASSES {
            let Some(next) = lag.next(&torque, grid) else {
                break;
            };
            let change = largest_difference(&next[0], &lag.motion[0]);
            let size = largest(next[0].iter().flatten());
            lag.motion = next;
            self.move_by_lag(&lag, &without);
            // Far from any motion that repeats a link rattles, and no pass comes closer to one.
            if change <= PASS_TOLERANCE * size || change > RATTLES * before {
                break;
            }
            torque = match change <= FAST * before {
                true => self.torque_of_members(segment, samples, &mut lag),
                false => self.linearise(segment, samples, &mut lag),
            };
            before = change;
        }
        if self.rigid.columns > 0 {
            if known.is_none() {
                self.linearise(segment, samples, &mut lag);
            }
            lag.add_switches();
            lag.march = lag.equation(grid);
        }
        Some(lag)
    }

    /// Joints where motors and the lag have them.
    fn move_by_lag(&mut self, lag: &Lag, without: &[Vec<Vec<f64>>; 3]) {
        for (order, moved) in self.joint_motion.iter_mut().enumerate() {
            for (f, member) in lag.members.iter().enumerate() {
                let from = without[order][member.joint]
                    .iter()
                    .zip(&lag.motion[order][f]);
                let to = moved[member.joint].iter_mut().zip(from);
                to.for_each(|(to, (q, lag))| *to = q - lag);
            }
        }
    }

    /// Torques at the joints that lag where the joints are now.
    fn torque_of_members(
        &self,
        segment: Segment<'_>,
        samples: usize,
        lag: &mut Lag,
    ) -> Vec<Vec<f64>> {
        let bodies = &self.bodies[usize::from(segment.loaded)];
        let all = torques(&self.tree, bodies, self.trajectory());
        let members = lag.rows();
        let springs = self.springs(segment, samples, &members);
        let of = |(joint, spring): (&usize, &AtJoint)| {
            let pairs = all[*joint].iter().zip(&spring.torque);
            pairs.map(|(body, spring)| body + spring).collect()
        };
        let torque = members.iter().zip(&springs).map(of).collect();
        lag.take_levels(springs);
        torque
    }

    fn lagging(&self) -> Vec<Lagging> {
        let joints = self.model.joints().iter().enumerate();
        joints
            .filter(|(_, joint)| !joint.locked)
            .filter_map(|(j, joint)| {
                Some(Lagging {
                    joint: j,
                    flank: Flank::of_joint(joint, &self.values)?,
                    columns: [
                        joint.elasticity.and_then(|at| self.column[at]),
                        joint.elasticity.and_then(|at| self.column[at + 1]),
                        joint.play.and_then(|at| self.column[at]),
                    ],
                })
            })
            .collect()
    }

    /// Torques at the joints that lag, and the derivatives of all rows by their motion, where the joints
    /// are now.
    fn linearise(&mut self, segment: Segment<'_>, samples: usize, lag: &mut Lag) -> Vec<Vec<f64>> {
        let members = lag.rows();
        let (mut torque, slopes) = self.slopes(segment.loaded, samples, &members);
        lag.slopes = slopes;
        self.add_springs(segment, samples, lag, &mut torque);
        torque
    }

    /// The same where the bodies are known and no link lags yet.
    fn recall(
        &self,
        segment: Segment<'_>,
        samples: usize,
        known: &KnownBodies,
        lag: &mut Lag,
    ) -> Vec<Vec<f64>> {
        let members = lag.rows();
        let mut torque: Vec<Vec<f64>> = members.iter().map(|&j| known.torque[j].clone()).collect();
        lag.slopes = known.slopes.of_joints(&members);
        self.add_springs(segment, samples, lag, &mut torque);
        torque
    }

    fn add_springs(
        &self,
        segment: Segment<'_>,
        samples: usize,
        lag: &mut Lag,
        torque: &mut [Vec<f64>],
    ) {
        let members = lag.rows();
        let springs = self.springs(segment, samples, &members);
        for (f, spring) in springs.iter().enumerate() {
            for k in 0..samples {
                torque[f][k] += spring.torque[k];
                let own = lag.slopes.at(k, members[f], f);
                lag.slopes.by[0][own] += spring.stiffness[k];
                lag.slopes.by[1][own] += spring.damping[k];
            }
        }
        lag.take_levels(springs);
    }

    /// Torque, stiffness and damping of laws at the given joints, with what changes sides with the speed apart.
    fn springs(&self, segment: Segment<'_>, samples: usize, joints: &[usize]) -> Vec<AtJoint> {
        let of = |&j: &usize| {
            let zeros = || vec![0.0; samples];
            let joint = &self.model.joints()[j];
            let width = joint.width.map_or(0.0, |at| self.values[at]);
            let mut at = AtJoint {
                torque: zeros(),
                level: zeros(),
                width,
                stiffness: zeros(),
                damping: zeros(),
            };
            let velocity = &self.joint_motion[1][j][..samples];
            let signs: Vec<f64> = velocity.iter().map(|v| sign(*v, width)).collect();
            for (index, &(effect, first)) in joint.effects.iter().enumerate() {
                let Law::Joint(law) = effect.law else {
                    continue;
                };
                let count = effect.parameters.len();
                let others = of_others(&joint.others[index], &self.joint_motion, 0..samples);
                let mut input = at_joint(&self.joint_motion, j, &signs, segment, 0..samples);
                input.surroundings.others = &others;
                input.surroundings.period = self.model.period();
                let mut by_sign = zeros();
                let mut out = Contribution {
                    torque: &mut at.torque,
                    by_parameter: &mut vec![zeros(); count],
                    by_sign: &mut by_sign,
                    by_position: &mut at.stiffness,
                    by_velocity: &mut at.damping,
                };
                law.add(
                    input,
                    &self.values.as_slice()[first..first + count],
                    &mut out,
                );
                for (k, by_sign) in by_sign.iter().enumerate() {
                    at.torque[k] -= by_sign * signs[k];
                    at.level[k] += by_sign;
                }
            }
            at
        };
        joints.iter().map(of).collect()
    }

    /// Carries every column through the lag: what changes the torque changes the lag, which changes the
    /// motion of the link.
    pub(super) fn lag_columns(&mut self, lag: &Lag, samples: usize) {
        let Some(march) = &lag.march else { return };
        let rows = self.rigid.values.len();
        let rows: Vec<usize> = (0..rows).filter(|&row| self.reaches_signal(row)).collect();
        for column in 0..self.rigid.columns {
            let mut present = false;
            let source: Vec<Vec<f64>> = lag
                .members
                .iter()
                .enumerate()
                .map(|(f, member)| {
                    let series = self.rigid.lend(member.joint, column);
                    let mut source = match series.is_empty() {
                        true => vec![0.0; samples],
                        false => series[..samples].to_vec(),
                    };
                    present |= !series.is_empty();
                    self.rigid.give_back(member.joint, column, series);
                    if let Some(which) = member.columns.iter().position(|c| *c == Some(column)) {
                        present = true;
                        for (k, to) in source.iter_mut().enumerate() {
                            let contact = member
                                .flank
                                .contact(lag.motion[0][f][k], lag.motion[1][f][k]);
                            *to -= contact.by_parameters[which];
                        }
                    }
                    source
                })
                .collect();
            if !present {
                continue;
            }
            let change = march.solve(&source);
            for &row in &rows {
                let series = self.rigid.series(row, column);
                for (k, to) in series[..samples].iter_mut().enumerate() {
                    for (slope, change) in lag.slopes.by.iter().zip(&change) {
                        for (f, by) in change.iter().enumerate() {
                            *to -= slope[lag.slopes.at(k, row, f)] * by[k];
                        }
                    }
                }
            }
        }
    }
}

fn largest_difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
}
