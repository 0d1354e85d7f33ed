//! Torques of the bodies along a course and their derivatives by its motion, kept for evaluations in which
//! neither bodies nor motion change.

use crate::chain::evaluate::{Evaluator, Segment};
use std::ops::Range;
use std::rc::Rc;

/// What the bodies of a model do along a course.
#[derive(Debug, Clone, Default)]
pub struct KnownBodies {
    /// `[row of the rigid body][sample]`.
    pub torque: Vec<Vec<f64>>,
    /// By the motion of every joint; none where empty.
    pub(super) slopes: Slopes,
}

impl KnownBodies {
    /// The torques at every `stride`-th sample.
    pub fn thinned(&self, stride: usize) -> Self {
        let thin = |s: &Vec<f64>| s.iter().step_by(stride).copied().collect();
        Self {
            torque: self.torque.iter().map(thin).collect(),
            slopes: Slopes::default(),
        }
    }
}

/// Derivatives of every row of the rigid body with respect to q, q̇ and q̈ of some joints: `[order]`, sample after
/// sample, rows x joints, row after row.
#[derive(Debug, Clone, Default)]
pub(super) struct Slopes {
    rows: usize,
    joints: usize,
    pub by: [Vec<f64>; 3],
}

impl Slopes {
    pub fn zeros(rows: usize, joints: usize, samples: usize) -> Self {
        let zeros = || vec![0.0; rows * joints * samples];
        Self {
            rows,
            joints,
            by: [zeros(), zeros(), zeros()],
        }
    }

    pub fn is_empty(&self) -> bool {
        self.by[0].is_empty()
    }

    /// Position of an entry of a sample.
    pub fn at(&self, k: usize, (row, joint): (usize, usize)) -> usize {
        (k * self.rows + row) * self.joints + joint
    }

    /// Those by some of the joints.
    pub fn of_joints(&self, joints: &[usize]) -> Self {
        let pick = |by: &Vec<f64>| {
            let rows = by.chunks_exact(self.joints);
            rows.flat_map(|row| joints.iter().map(|&j| row[j]))
                .collect()
        };
        Self {
            rows: self.rows,
            joints: joints.len(),
            by: [0, 1, 2].map(|order| pick(&self.by[order])),
        }
    }
}

impl Evaluator<'_> {
    /// What the bodies do along a whole recording, without lags.
    pub fn known_bodies(&mut self, segment: Segment<'_>) -> KnownBodies {
        let range = 0..segment.motors.len();
        self.rigid.clear(range.len());
        self.move_joints(segment.motors, range.clone());
        self.rigid_body(segment, range.clone());
        let all: Vec<usize> = (0..self.model.joints().len()).collect();
        let (_, slopes) = self.slopes(segment.loaded, range, &all);
        KnownBodies {
            torque: self.rigid.values.clone(),
            slopes,
        }
    }

    /// Torques at some joints and derivatives of all rows by their motion, where the joints are now.
    pub(super) fn slopes(
        &mut self,
        loaded: bool,
        range: Range<usize>,
        joints: &[usize],
    ) -> (Vec<Vec<f64>>, Slopes) {
        let (n, samples) = (self.model.joints().len(), range.len());
        let bodies = Rc::clone(&self.bodies[usize::from(loaded)]);
        let (rows, torque_rows) = (self.rigid.values.len(), self.torque_rows());
        let mut torque = vec![vec![0.0; samples]; joints.len()];
        let mut slopes = Slopes::zeros(rows, joints.len(), samples);
        let mut state = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        for k in 0..samples {
            self.state_at(k, &mut state);
            let slices = [&state[0][..], &state[1], &state[2]];
            self.derivatives.evaluate(&self.tree, &bodies, slices);
            for (f, &joint) in joints.iter().enumerate() {
                torque[f][k] = self.derivatives.torque[joint];
                for row in 0..rows {
                    let at = slopes.at(k, (row, f));
                    let by = self.by_motion(row, torque_rows, joint);
                    for (slope, by) in slopes.by.iter_mut().zip(by) {
                        slope[at] = by;
                    }
                }
            }
        }
        (torque, slopes)
    }
}
