//! Derivatives of many samples at once, samples in vector lanes.

use crate::linalg::lanes::instructions::{self, InstructionSet, Kernel};
use crate::linalg::lanes::lane::{LANES, Lanes};
use crate::robot::batch::{LaneState, Trajectory};
use crate::robot::derivatives::Derivatives;
use crate::robot::tree::Tree;
use std::ops::Range;

/// Torques and derivatives of a block of samples; reused from block to block.
#[derive(Clone, Debug)]
pub struct DerivativeBatch {
    joints: usize,
    capacity: usize,
    set: InstructionSet,
    /// Torques of the joints, then the slopes: order after order, row after row, joint after joint.
    values: Vec<f64>,
}

impl DerivativeBatch {
    /// Room for `capacity` samples, rounded up to whole lanes.
    pub fn new(tree: &Tree, capacity: usize) -> Self {
        Self::with_instructions(tree, capacity, InstructionSet::detect())
    }

    /// As [`DerivativeBatch::new`], with at most the given instruction set.
    pub fn with_instructions(tree: &Tree, capacity: usize, set: InstructionSet) -> Self {
        let capacity = capacity.next_multiple_of(LANES);
        let n = tree.len();
        Self {
            joints: n,
            capacity,
            set,
            values: vec![0.0; (n + 3 * (n + 6) * n) * capacity],
        }
    }

    /// Evaluates the samples of `range` (at most the capacity) with the 10 n inertial parameters.
    pub fn evaluate(
        &mut self,
        tree: &Tree,
        parameters: &[f64],
        trajectory: Trajectory<'_>,
        range: Range<usize>,
    ) {
        let set = self.set;
        let kernel = DerivativeKernel {
            batch: self,
            tree,
            parameters,
            trajectory,
            range,
        };
        instructions::run(kernel, set);
    }

    /// Torque of a joint over the samples of the block, N·m (N).
    pub fn torque(&self, joint: usize) -> &[f64] {
        self.series(joint)
    }

    /// Derivative of a row (as in [`Derivatives::slope`]) by a joint's position, velocity or acceleration.
    pub fn slope(&self, order: usize, row: usize, joint: usize) -> &[f64] {
        let n = self.joints;
        self.series(n + (order * (n + 6) + row) * n + joint)
    }

    fn series(&self, index: usize) -> &[f64] {
        &self.values[index * self.capacity..][..self.capacity]
    }
}

struct DerivativeKernel<'a> {
    batch: &'a mut DerivativeBatch,
    tree: &'a Tree,
    parameters: &'a [f64],
    trajectory: Trajectory<'a>,
    range: Range<usize>,
}

impl Kernel for DerivativeKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut recursion = Derivatives::<L>::new(self.tree);
        let mut state = LaneState::<L>::new(self.tree.len());
        let (values, capacity) = (&mut self.batch.values[..], self.batch.capacity);
        for (group, start) in self.range.clone().step_by(LANES).enumerate() {
            state.load(self.trajectory, start..self.range.end);
            recursion.evaluate(self.tree, self.parameters, state.slices());
            let mut at = group * LANES;
            for series in recursion.all() {
                for lanes in series {
                    lanes.store(values, at);
                    at += capacity;
                }
            }
        }
    }
}
