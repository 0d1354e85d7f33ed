//! Torque constraints: motor torques along a motion against their limits, and derivatives by the motion:
//!
//! ```text
//! τ_M = Vᵀ (τ + Pᵀ τ_p)(q, q̇, q̈) + laws(m, ṁ, m̈)    P and τ_p of joints without a motor, where loops are closed
//! margin = 1 − |τ_M| / τ_max            as two rows, one for each sign
//! ```

use nalgebra::{DMatrix, DMatrixViewMut, DVector};

use crate::chain::evaluate::{BLOCK, bodies};
use crate::chain::model::Model;
use crate::design::information::observation_matrix::Observation;
use crate::design::information::torque_laws::{CentralDifference, Evaluated, Laws};
use crate::design::trajectory::fourier_series::Basis;
use crate::design::trajectory::motion::{Joints, MOTION, Motion, of_motors};
use crate::robot::batch;
use crate::robot::derivative_batch::DerivativeBatch;
use std::ops::Range;

/// A motor whose torque is limited, under one of the loads.
#[derive(Debug, Clone, PartialEq)]
pub struct Limited {
    /// The motor's joint in the tree.
    pub joint: usize,
    /// Position in the list of loads.
    pub load: usize,
    /// N·m or N.
    pub limit: f64,
}

/// The torque rows of a design.
#[derive(Debug)]
pub struct Torques<'m> {
    model: &'m Model,
    laws: Vec<Laws<'m>>,
    to_motors: Option<DMatrix<f64>>,
    coupling: DMatrix<f64>,
    /// Inertial parameters of the links with each load.
    bodies: Vec<Vec<f64>>,
    /// One row per sample of each.
    pub limited: Vec<Limited>,
}

impl<'m> Torques<'m> {
    /// Rows for the joints that have a limit; `values` are the parameters that torques are predicted with.
    pub fn new(
        observation: &Observation<'m>,
        values: &DVector<f64>,
        loads: &[bool],
        limits: &[Option<f64>],
    ) -> Self {
        let model = observation.model();
        let of = |load: usize| {
            let each = limits.iter().enumerate();
            each.filter_map(move |(joint, limit)| {
                let moves = !model.joints()[joint].locked;
                (*limit)
                    .filter(|_| moves)
                    .map(|limit| Limited { joint, load, limit })
            })
        };
        Self {
            model,
            laws: observation.laws().to_vec(),
            to_motors: observation.to_motors().cloned(),
            coupling: model.coupling(values),
            bodies: loads.iter().map(|l| bodies(model, values, *l)).collect(),
            limited: (0..loads.len()).flat_map(of).collect(),
        }
    }

    /// Number of rows for this many samples.
    pub fn rows(&self, samples: usize) -> usize {
        2 * self.limited.len() * samples
    }

    /// Torque of every limited motor `[limited][sample]`.
    pub fn values(&self, motion: &Motion) -> Vec<Vec<f64>> {
        if self.limited.is_empty() {
            return Vec::new();
        }
        let tree = self.model.tree();
        let of_joints: Vec<Vec<Vec<f64>>> = self
            .bodies
            .iter()
            .map(|bodies| batch::torques(tree, bodies, motion.trajectory()))
            .collect();
        let mut scratch = Evaluated::default();
        let motors = self.motors(motion);
        let of = |limited: &Limited| {
            let j = limited.joint;
            let mut torque = vec![0.0; motion.len()];
            for (i, series) in of_joints[limited.load].iter().enumerate() {
                let v = self.coupling[(i, j)];
                if v != 0.0 {
                    for (to, t) in torque.iter_mut().zip(series) {
                        *to += v * t;
                    }
                }
            }
            if let Some(mechanism) = self.model.mechanism() {
                for (a, &i) in mechanism.actuated().iter().enumerate() {
                    let v = self.coupling[(i, j)];
                    for (p, &passive) in mechanism.passive().iter().enumerate() {
                        let turns = motion.carried.iter().map(|map| map[(p, a)]);
                        let terms = of_joints[limited.load][passive].iter().zip(turns);
                        let pairs = torque.iter_mut().zip(terms);
                        pairs.for_each(|(to, (t, turns))| *to += v * turns * t);
                    }
                }
            }
            if !self.laws[j].is_empty() {
                let [q, dq, ddq] = &motors.values;
                self.laws[j].evaluate([&q[j], &dq[j], &ddq[j]], &mut scratch);
                for (to, t) in torque.iter_mut().zip(&scratch.torque) {
                    *to += t;
                }
            }
            torque
        };
        self.limited.iter().map(of).collect()
    }

    fn motors(&self, motion: &Motion) -> Motion {
        of_motors(motion, self.to_motors.as_ref(), self.model.offset())
    }

    /// Margins `1 ∓ τ/τ_max`: for each limited motor the rows of the upper limit, then of the lower.
    pub fn margins(&self, torques: &[Vec<f64>], shrink: f64) -> Vec<f64> {
        let mut margins = Vec::new();
        for (limited, torque) in self.limited.iter().zip(torques) {
            let limit = shrink * limited.limit;
            margins.extend(torque.iter().map(|t| 1.0 - t / limit));
            margins.extend(torque.iter().map(|t| 1.0 + t / limit));
        }
        margins
    }

    /// Writes `∂margin/∂x` of all rows into `jacobian`.
    pub fn jacobian(
        &self,
        motion: &Motion,
        shrink: f64,
        joints: &Joints,
        basis: &Basis,
        mut jacobian: DMatrixViewMut<'_, f64>,
    ) {
        if self.limited.is_empty() {
            return;
        }
        let slopes = self.slopes(motion);
        let samples = motion.len();
        let width = joints.series.width();
        for (l, limited) in self.limited.iter().enumerate() {
            let base = 2 * l * samples;
            let factor = -1.0 / (shrink * limited.limit);
            for trajectory in 0..joints.trajectories {
                for (m, &i) in joints.moving.iter().enumerate() {
                    let first = trajectory * basis.samples;
                    let slopes: [&[f64]; MOTION] =
                        std::array::from_fn(|order| &slopes[l][order][i][first..]);
                    for c in 0..width {
                        let functions: [&[f64]; MOTION] =
                            std::array::from_fn(|order| basis.function(order, c));
                        let mut column = jacobian.column_mut(joints.first(trajectory, m) + c);
                        for k in 0..basis.samples {
                            let mut slope = 0.0;
                            for order in 0..MOTION {
                                slope += slopes[order][k] * functions[order][k];
                            }
                            column[base + first + k] = factor * slope;
                            column[base + samples + first + k] = -factor * slope;
                        }
                    }
                }
            }
        }
    }

    /// `∂τ_M/∂(q, q̇, q̈)` of every limited motor: `[limited][order][joint][sample]`.
    fn slopes(&self, motion: &Motion) -> Vec<[Vec<Vec<f64>>; MOTION]> {
        let (n, samples) = (self.coupling.nrows(), motion.len());
        let empty = || std::array::from_fn(|_| vec![vec![0.0; samples]; n]);
        let mut all: Vec<[Vec<Vec<f64>>; MOTION]> = self.limited.iter().map(|_| empty()).collect();
        let mut derivatives = DerivativeBatch::new(self.model.tree(), BLOCK);
        for (load, bodies) in self.bodies.iter().enumerate() {
            for start in (0..samples).step_by(BLOCK) {
                let part = start..samples.min(start + BLOCK);
                let tree = self.model.tree();
                derivatives.evaluate(tree, bodies, motion.trajectory(), part.clone());
                let own = self.limited.iter().zip(&mut all);
                for (limited, slopes) in own.filter(|(l, _)| l.load == load) {
                    self.carry_slopes(limited.joint, &derivatives, part.clone(), slopes);
                }
            }
        }
        let motors = self.motors(motion);
        for (limited, slopes) in self.limited.iter().zip(&mut all) {
            self.law_slopes(limited.joint, &motors, slopes);
        }
        all
    }

    /// Adds `∂τ_M/∂(q, q̇, q̈)` of the bodies over some samples, through the column of V of a motor.
    fn carry_slopes(
        &self,
        motor: usize,
        derivatives: &DerivativeBatch,
        part: Range<usize>,
        slopes: &mut [Vec<Vec<f64>>; MOTION],
    ) {
        let shares = self.coupling.column(motor);
        for (row, share) in shares
            .iter()
            .enumerate()
            .filter(|(_, share)| **share != 0.0)
        {
            for (order, slopes) in slopes.iter_mut().enumerate() {
                for (i, slopes) in slopes.iter_mut().enumerate() {
                    let by = derivatives.slope(order, row, i);
                    let pairs = slopes[part.clone()].iter_mut().zip(by);
                    pairs.for_each(|(to, by)| *to += share * by);
                }
            }
        }
    }

    fn law_slopes(&self, j: usize, motors: &Motion, slopes: &mut [Vec<Vec<f64>>; MOTION]) {
        let [q, dq, ddq] = &motors.values;
        self.laws[j].differences([&q[j], &dq[j], &ddq[j]], |difference| {
            let CentralDifference { order, factor, .. } = difference;
            for i in 0..slopes[order].len() {
                let turn = match &self.to_motors {
                    Some(inverse) => inverse[(j, i)],
                    None => f64::from(u8::from(i == j)),
                };
                if turn != 0.0 {
                    let pairs = difference
                        .after
                        .torque
                        .iter()
                        .zip(&difference.before.torque);
                    for (to, (a, b)) in slopes[order][i].iter_mut().zip(pairs) {
                        *to += turn * factor * (a - b);
                    }
                }
            }
        });
    }
}
