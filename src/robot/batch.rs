//! Regressors and torques of many samples at once, samples in vector lanes.
//!
//! The recursion is compiled for AVX-512, for AVX2 with FMA and for the baseline of the target; the
//! widest that the processor has is chosen at run time. The choice does not depend on threads.

use crate::robot::newton_euler::NewtonEuler;
use crate::robot::regressor::{Regressor, Rows};
use crate::robot::scalar::{LANES, Lanes};
use crate::robot::tree::Tree;
use std::ops::Range;
use std::sync::OnceLock;

/// Instruction sets that the kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstructionSet {
    Baseline,
    Avx2,
    Avx512,
}

impl InstructionSet {
    /// The widest that this processor has.
    pub fn detect() -> Self {
        static FOUND: OnceLock<InstructionSet> = OnceLock::new();
        *FOUND.get_or_init(|| {
            #[cfg(target_arch = "x86_64")]
            {
                let fma = std::arch::is_x86_feature_detected!("fma");
                if fma
                    && std::arch::is_x86_feature_detected!("avx512f")
                    && std::arch::is_x86_feature_detected!("avx512dq")
                    && std::arch::is_x86_feature_detected!("avx512vl")
                {
                    return Self::Avx512;
                }
                if fma && std::arch::is_x86_feature_detected!("avx2") {
                    return Self::Avx2;
                }
            }
            Self::Baseline
        })
    }
}

/// Position, velocity and acceleration of every joint over time: `[joint][sample]`.
#[derive(Clone, Copy, Debug)]
pub struct Trajectory<'a> {
    pub q: &'a [Vec<f64>],
    pub dq: &'a [Vec<f64>],
    pub ddq: &'a [Vec<f64>],
}

impl<'a> Trajectory<'a> {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.q.first().map_or(0, Vec::len)
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Regressor rows of a block of samples; reused from block to block.
#[derive(Clone, Debug)]
pub struct RegressorBatch {
    rows: usize,
    columns: usize,
    capacity: usize,
    set: InstructionSet,
    rows_kind: Rows,
    values: Vec<f64>,
}

impl RegressorBatch {
    /// Room for `capacity` samples, rounded up to whole lanes.
    pub fn new(tree: &Tree, rows: Rows, capacity: usize) -> Self {
        Self::with_instructions(tree, rows, capacity, InstructionSet::detect())
    }

    /// As [`RegressorBatch::new`], with an instruction set that the processor must have.
    pub fn with_instructions(
        tree: &Tree,
        rows: Rows,
        capacity: usize,
        set: InstructionSet,
    ) -> Self {
        let set = match InstructionSet::detect() {
            InstructionSet::Avx512 => set,
            InstructionSet::Avx2 if set == InstructionSet::Avx512 => InstructionSet::Avx2,
            InstructionSet::Avx2 => set,
            InstructionSet::Baseline => InstructionSet::Baseline,
        };
        let capacity = capacity.next_multiple_of(LANES);
        let (count, columns) = (rows.count(tree.len()), 10 * tree.len());
        Self {
            rows: count,
            columns,
            capacity,
            set,
            rows_kind: rows,
            values: vec![0.0; count * columns * capacity],
        }
    }

    /// Evaluates the samples of `range` (at most the capacity).
    pub fn evaluate(&mut self, tree: &Tree, trajectory: Trajectory<'_>, range: Range<usize>) {
        match self.set {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the constructor admits a set only where the processor has it.
            InstructionSet::Avx512 => unsafe { self.evaluate_avx512(tree, trajectory, range) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            InstructionSet::Avx2 => unsafe { self.evaluate_avx2(tree, trajectory, range) },
            _ => self.evaluate_lanes::<false>(tree, trajectory, range),
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,fma")]
    fn evaluate_avx512(&mut self, tree: &Tree, trajectory: Trajectory<'_>, range: Range<usize>) {
        self.evaluate_lanes::<true>(tree, trajectory, range);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn evaluate_avx2(&mut self, tree: &Tree, trajectory: Trajectory<'_>, range: Range<usize>) {
        self.evaluate_lanes::<true>(tree, trajectory, range);
    }

    #[inline(always)]
    fn evaluate_lanes<const FUSED: bool>(
        &mut self,
        tree: &Tree,
        trajectory: Trajectory<'_>,
        range: Range<usize>,
    ) {
        let n = tree.len();
        let mut recursion = Regressor::<Lanes<FUSED>>::new(tree, self.rows_kind);
        let mut state = LaneState::new(n);
        for (group, start) in range.clone().step_by(LANES).enumerate() {
            state.load(trajectory, start..range.end);
            let at = group * LANES;
            recursion.blocks(tree, state.slices(), |row, link, columns| {
                let first = (row * self.columns + 10 * link) * self.capacity + at;
                for (k, lanes) in columns.iter().enumerate() {
                    let to = first + k * self.capacity;
                    self.values[to..to + LANES].copy_from_slice(&lanes.0);
                }
            });
        }
    }

    /// Number of rows per sample.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// One column (parameter) of one row over the samples of the block.
    pub fn column(&self, row: usize, column: usize) -> &[f64] {
        let first = (row * self.columns + column) * self.capacity;
        &self.values[first..first + self.capacity]
    }
}

struct LaneState<const FUSED: bool> {
    q: Vec<Lanes<FUSED>>,
    dq: Vec<Lanes<FUSED>>,
    ddq: Vec<Lanes<FUSED>>,
}

impl<const FUSED: bool> LaneState<FUSED> {
    fn new(n: usize) -> Self {
        let rest = vec![Lanes([0.0; LANES]); n];
        Self {
            q: rest.clone(),
            dq: rest.clone(),
            ddq: rest,
        }
    }

    #[inline(always)]
    fn load(&mut self, t: Trajectory<'_>, range: Range<usize>) {
        for j in 0..self.q.len() {
            self.q[j] = Lanes::load(&t.q[j][..range.end], range.start);
            self.dq[j] = Lanes::load(&t.dq[j][..range.end], range.start);
            self.ddq[j] = Lanes::load(&t.ddq[j][..range.end], range.start);
        }
    }

    #[inline(always)]
    fn slices(&self) -> [&[Lanes<FUSED>]; 3] {
        [&self.q, &self.dq, &self.ddq]
    }
}

/// Inverse dynamics of the samples of a trajectory: torques `[joint][sample]`.
pub fn torques(tree: &Tree, parameters: &[f64], trajectory: Trajectory<'_>) -> Vec<Vec<f64>> {
    match InstructionSet::detect() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: detected.
        InstructionSet::Avx512 => unsafe { torques_avx512(tree, parameters, trajectory) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: detected.
        InstructionSet::Avx2 => unsafe { torques_avx2(tree, parameters, trajectory) },
        _ => torques_lanes::<false>(tree, parameters, trajectory),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,fma")]
fn torques_avx512(tree: &Tree, parameters: &[f64], trajectory: Trajectory<'_>) -> Vec<Vec<f64>> {
    torques_lanes::<true>(tree, parameters, trajectory)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn torques_avx2(tree: &Tree, parameters: &[f64], trajectory: Trajectory<'_>) -> Vec<Vec<f64>> {
    torques_lanes::<true>(tree, parameters, trajectory)
}

#[inline(always)]
fn torques_lanes<const FUSED: bool>(
    tree: &Tree,
    parameters: &[f64],
    trajectory: Trajectory<'_>,
) -> Vec<Vec<f64>> {
    let (n, samples) = (tree.len(), trajectory.len());
    let mut recursion = NewtonEuler::<Lanes<FUSED>>::new(tree);
    let mut state = LaneState::new(n);
    let mut lanes = vec![Lanes([0.0; LANES]); n];
    let mut torque = vec![Vec::with_capacity(samples); n];
    for start in (0..samples).step_by(LANES) {
        state.load(trajectory, start..samples);
        recursion.torque(tree, parameters, state.slices(), &mut lanes);
        let count = LANES.min(samples - start);
        for (series, value) in torque.iter_mut().zip(&lanes) {
            series.extend_from_slice(&value.0[..count]);
        }
    }
    torque
}
