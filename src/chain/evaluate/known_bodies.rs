//! Torques of bodies with known parameters along a motion, and their derivatives by it.

use std::ops::Range;

/// What the bodies of a model do along a motion.
#[derive(Debug, Clone, Default)]
pub struct KnownBodies {
    /// Of everything but the parameters that have columns below, `[row of the rigid body][sample]`.
    pub(super) torque: Vec<Vec<f64>>,
    /// Parameters, by their position, and what one unit of each takes of the motors, `[channel][sample]`; empty where a
    /// channel does not depend on it or does not count.
    pub(super) columns: Vec<(usize, Vec<Vec<f64>>)>,
    /// By the motion of every joint; none where empty.
    pub(super) slopes: Slopes,
    /// Where the joints are, `[order][joint][sample]`, and nothing that is still to be known moves them any more.
    pub(super) joints: Option<[Vec<Vec<f64>>; 3]>,
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
    pub fn at(&self, k: usize, row: usize, joint: usize) -> usize {
        (k * self.rows + row) * self.joints + joint
    }

    /// Writes an entry over some samples.
    pub fn put(&mut self, row: usize, joint: usize, samples: Range<usize>, by: [&[f64]; 3]) {
        for (order, by) in by.into_iter().enumerate() {
            for (k, by) in samples.clone().zip(by) {
                let at = self.at(k, row, joint);
                self.by[order][at] = *by;
            }
        }
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
