//! Regressors and torques of many samples at once, samples in vector lanes.
//!
//! The lanes are those of the widest instruction set that the processor has, chosen at run time. The
//! choice does not depend on threads.

use crate::linalg::lanes::instructions::{self, InstructionSet, Kernel};
use crate::linalg::lanes::lane::{LANES, Lanes};
use crate::robot::newton_euler::NewtonEuler;
use crate::robot::regressor::{BlockSink, Regressor, Rows};
use crate::robot::tree::Tree;
use std::ops::Range;

/// Position, velocity and acceleration of every joint over time: `[joint][sample]`.
#[derive(Clone, Copy, Debug)]
pub struct Trajectory<'a> {
    /// Positions, rad (m).
    pub q: &'a [Vec<f64>],
    /// Velocities, rad/s (m/s).
    pub dq: &'a [Vec<f64>],
    /// Accelerations, rad/s² (m/s²).
    pub ddq: &'a [Vec<f64>],
}

impl Trajectory<'_> {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.q.first().map_or(0, Vec::len)
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Which entries of a regressor are asked for.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// Links whose columns are.
    pub links: &'a [bool],
    /// Joints whose torques are; the rows of the base reaction always are.
    pub joints: &'a [bool],
}

/// Regressor rows of a block of samples; reused from block to block.
#[derive(Clone, Debug)]
pub struct RegressorBatch {
    kind: Rows,
    columns: usize,
    capacity: usize,
    set: InstructionSet,
    values: Vec<f64>,
}

impl RegressorBatch {
    /// Room for `capacity` samples, rounded up to whole lanes.
    pub fn new(tree: &Tree, rows: Rows, capacity: usize) -> Self {
        Self::with_instructions(tree, rows, capacity, InstructionSet::detect())
    }

    /// As [`RegressorBatch::new`], with at most the given instruction set.
    pub fn with_instructions(
        tree: &Tree,
        rows: Rows,
        capacity: usize,
        set: InstructionSet,
    ) -> Self {
        let capacity = capacity.next_multiple_of(LANES);
        let (count, columns) = (rows.count(tree.len()), 10 * tree.len());
        Self {
            kind: rows,
            columns,
            capacity,
            set,
            values: vec![0.0; count * columns * capacity],
        }
    }

    /// Evaluates the samples of `range` (at most the capacity).
    pub fn evaluate(&mut self, tree: &Tree, trajectory: Trajectory<'_>, range: Range<usize>) {
        let all = vec![true; tree.len()];
        let wanted = Wanted {
            links: &all,
            joints: &all,
        };
        self.evaluate_wanted(tree, trajectory, range, wanted);
    }

    /// The same for some entries; the others stay what they were.
    pub fn evaluate_wanted(
        &mut self,
        tree: &Tree,
        trajectory: Trajectory<'_>,
        range: Range<usize>,
        wanted: Wanted<'_>,
    ) {
        let set = self.set;
        let kernel = RegressorKernel {
            batch: self,
            tree,
            trajectory,
            range,
            wanted,
        };
        instructions::run(kernel, set);
    }

    /// One column (parameter) of one row over the samples of the block.
    pub fn column(&self, row: usize, column: usize) -> &[f64] {
        let first = (row * self.columns + column) * self.capacity;
        &self.values[first..first + self.capacity]
    }
}

struct RegressorKernel<'a> {
    batch: &'a mut RegressorBatch,
    tree: &'a Tree,
    trajectory: Trajectory<'a>,
    range: Range<usize>,
    wanted: Wanted<'a>,
}

impl Kernel for RegressorKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let RegressorBatch {
            kind,
            columns,
            capacity,
            values,
            ..
        } = self.batch;
        let mut recursion = Regressor::<L>::new(self.tree, *kind);
        let mut state = LaneState::<L>::new(self.tree.len());
        for (group, start) in self.range.clone().step_by(LANES).enumerate() {
            state.load(self.trajectory, start..self.range.end);
            let mut sink = BatchSink {
                columns: *columns,
                capacity: *capacity,
                at: group * LANES,
                wanted: self.wanted,
                values: &mut values[..],
            };
            recursion.blocks(self.tree, state.slices(), &mut sink);
        }
    }
}

/// Blocks of one group of lanes into the series of the batch.
struct BatchSink<'a> {
    columns: usize,
    capacity: usize,
    at: usize,
    wanted: Wanted<'a>,
    values: &'a mut [f64],
}

impl<L: Lanes> BlockSink<L> for BatchSink<'_> {
    #[inline(always)]
    fn wants(&self, link: usize) -> bool {
        self.wanted.links[link]
    }

    #[inline(always)]
    fn wants_torque(&self, joint: usize) -> bool {
        self.wanted.joints[joint]
    }

    #[inline(always)]
    fn put(&mut self, row: usize, link: usize, block: &[L; 10]) {
        let first = (row * self.columns + 10 * link) * self.capacity + self.at;
        for (k, lanes) in block.iter().enumerate() {
            lanes.store(self.values, first + k * self.capacity);
        }
    }
}

/// Some samples of a motion of the joints.
pub(crate) struct LaneState<L> {
    q: Vec<L>,
    dq: Vec<L>,
    ddq: Vec<L>,
}

impl<L: Lanes> LaneState<L> {
    pub fn new(n: usize) -> Self {
        let rest = || (0..n).map(|_| L::constant(0.0)).collect();
        Self {
            q: rest(),
            dq: rest(),
            ddq: rest(),
        }
    }

    #[inline(always)]
    pub fn load(&mut self, t: Trajectory<'_>, range: Range<usize>) {
        for j in 0..self.q.len() {
            self.q[j] = L::load(&t.q[j][..range.end], range.start);
            self.dq[j] = L::load(&t.dq[j][..range.end], range.start);
            self.ddq[j] = L::load(&t.ddq[j][..range.end], range.start);
        }
    }

    #[inline(always)]
    pub fn slices(&self) -> [&[L]; 3] {
        [&self.q, &self.dq, &self.ddq]
    }
}

/// Inverse dynamics of the samples of a trajectory: torques `[joint][sample]`.
pub fn torques(tree: &Tree, parameters: &[f64], trajectory: Trajectory<'_>) -> Vec<Vec<f64>> {
    let samples = trajectory.len();
    let mut torque = vec![vec![0.0; samples]; tree.len()];
    let dynamics = InverseDynamics {
        tree,
        parameters,
        trajectory,
        samples,
        wanted: &vec![true; tree.len()],
    };
    dynamics.put_into(&mut torque);
    torque
}

/// Inverse dynamics of the first samples of a trajectory.
#[derive(Clone, Copy, Debug)]
pub struct InverseDynamics<'a> {
    /// The robot.
    pub tree: &'a Tree,
    /// Its 10 n inertial parameters.
    pub parameters: &'a [f64],
    /// How it moves.
    pub trajectory: Trajectory<'a>,
    /// So many of its samples.
    pub samples: usize,
    /// Joints whose torques are asked for.
    pub wanted: &'a [bool],
}

impl InverseDynamics<'_> {
    /// Puts the torques that are asked for into the first places of `[joint][sample]`; the others stay what they were.
    pub fn put_into(self, torque: &mut [Vec<f64>]) {
        let kernel = TorqueKernel { of: self, torque };
        instructions::run(kernel, InstructionSet::detect());
    }
}

struct TorqueKernel<'a> {
    of: InverseDynamics<'a>,
    torque: &'a mut [Vec<f64>],
}

impl Kernel for TorqueKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let InverseDynamics {
            tree,
            parameters,
            trajectory,
            samples,
            wanted,
        } = self.of;
        let mut recursion = NewtonEuler::<L>::of_joints(tree, wanted);
        let mut state = LaneState::<L>::new(tree.len());
        let mut lanes: Vec<L> = (0..tree.len()).map(|_| L::constant(0.0)).collect();
        for start in (0..samples).step_by(LANES) {
            state.load(trajectory, start..samples);
            recursion.torque(tree, parameters, state.slices(), &mut lanes);
            let count = LANES.min(samples - start);
            let series = self.torque.iter_mut().zip(&lanes).zip(wanted);
            for ((series, value), _) in series.filter(|(_, wanted)| **wanted) {
                series[start..start + count].copy_from_slice(&value.to_array()[..count]);
            }
        }
    }
}
