//! The observation matrix W of a motion, its information `M = WᵀW`, and the gradient of any function of M with respect to the
//! motion.
//!
//! With `F = ∂f/∂M` (symmetric) the gradient with respect to W is `G = 2 W F`, and `⟨G, ∂W⟩` is what
//! [`crate::robot::regressor_gradient`] carries back to q, q̇ and q̈. Samples lie in vector lanes.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;

use crate::chain::model::Model;
use crate::design::information::columns::{Channel, Columns, Entries, Recipe};
use crate::design::information::torque_laws::{Evaluated, Laws, SpeedScale};
use crate::design::trajectory::finite_differences::AlongMotion;
use crate::design::trajectory::motion::{Motion, of_motors};
use crate::linalg::lanes::instructions::{self, InstructionSet, Kernel};
use crate::linalg::lanes::lane::{LANES, Lanes};
use crate::robot::batch::{LaneState, Trajectory};
use crate::robot::regressor::{BlockSink, Regressor, Rows};
use crate::robot::regressor_gradient::RegressorGradient;
use crate::robot::tree::Tree;

/// What the observation matrix is made from.
#[derive(Debug)]
pub struct Observation<'m> {
    model: &'m Model,
    columns: &'m Columns,
    /// V⁻¹, where V is not the identity.
    to_motors: Option<DMatrix<f64>>,
    laws: Vec<Laws<'m>>,
}

/// Memory of one evaluation, reused.
#[derive(Debug, Clone)]
pub struct Workspace {
    samples: usize,
    /// Samples rounded up to whole lanes; what is beyond stays zero.
    stride: usize,
    entries: Vec<f64>,
    entry_slopes: Vec<f64>,
    /// Rows of each channel, column by column.
    rows: Vec<Vec<f64>>,
    slopes: Vec<f64>,
    gram: Vec<f64>,
    motors: Motion,
    laws: Vec<Evaluated>,
}

impl<'m> Observation<'m> {
    /// The observation matrix of some columns, laws at parameter values; `speeds` are those of the joints.
    pub fn new(
        model: &'m Model,
        columns: &'m Columns,
        values: &'m [f64],
        speeds: &[SpeedScale],
    ) -> Self {
        let n = model.joints().len();
        let to_motors = (!model.is_uncoupled())
            .then(|| model.coupling(&model.values()).try_inverse())
            .flatten();
        Self {
            model,
            columns,
            to_motors,
            laws: (0..n)
                .map(|j| Laws::of(model, j, values, speeds[j]))
                .collect(),
        }
    }

    /// The model whose parameters the columns are of.
    pub fn model(&self) -> &'m Model {
        self.model
    }

    /// The columns of W.
    pub fn columns(&self) -> &'m Columns {
        self.columns
    }

    /// The torque laws, motor by motor.
    pub fn laws(&self) -> &[Laws<'m>] {
        &self.laws
    }

    /// V⁻¹, where V is not the identity.
    pub fn to_motors(&self) -> Option<&DMatrix<f64>> {
        self.to_motors.as_ref()
    }

    /// Memory for motions of this many samples.
    pub fn workspace(&self, samples: usize) -> Workspace {
        let stride = samples.next_multiple_of(LANES);
        let n = self.model.joints().len();
        let channels = &self.columns.channels;
        let widest = channels.iter().map(|c| c.columns.len()).max().unwrap_or(0);
        let none = || vec![vec![0.0; samples]; n];
        Workspace {
            samples,
            stride,
            entries: vec![0.0; self.columns.entries.count() * stride],
            entry_slopes: vec![0.0; self.columns.entries.count() * stride],
            rows: channels
                .iter()
                .map(|c| vec![0.0; c.columns.len() * stride])
                .collect(),
            slopes: vec![0.0; widest * stride],
            gram: vec![0.0; widest * widest],
            motors: Motion::of_values([none(), none(), none()]),
            laws: vec![Evaluated::default(); n],
        }
    }

    /// W of a motion of the joints, kept in the workspace.
    fn observe(&self, motion: &Motion, work: &mut Workspace) {
        let set = InstructionSet::detect();
        let kernel = EntriesKernel {
            tree: self.model.tree(),
            motion: motion.trajectory(),
            entries: &self.columns.entries,
            stride: work.stride,
            values: &mut work.entries,
        };
        instructions::run(kernel, set);
        self.motors(motion, work);
        self.fill_rows(motion, work);
    }

    /// M of a motion of the joints; the workspace keeps W for [`Observation::pull`].
    pub fn information(&self, motion: &Motion, work: &mut Workspace) -> DMatrix<f64> {
        self.observe(motion, work);
        let p = self.columns.len();
        let mut information = DMatrix::zeros(p, p);
        for (channel, rows) in self.columns.channels.iter().zip(&work.rows) {
            let count = channel.columns.len();
            let w = MatRef::from_column_major_slice(rows, work.stride, count);
            let gram = &mut work.gram[..count * count];
            triangular::matmul(
                MatMut::from_column_major_slice_mut(gram, count, count),
                BlockStructure::TriangularLower,
                Accum::Replace,
                w.transpose(),
                BlockStructure::Rectangular,
                w,
                BlockStructure::Rectangular,
                1.0,
                Par::Seq,
            );
            for (b, &column) in channel.columns.iter().enumerate() {
                for (a, &row) in channel.columns.iter().enumerate().skip(b) {
                    information[(row, column)] += gram[b * count + a];
                }
            }
        }
        // Columns of a channel are in the order of the whole, so only the lower triangle was filled.
        for j in 0..p {
            for i in j..p {
                let value = information[(i, j)] * self.columns.multiplicity[(i, j)];
                information[(i, j)] = value;
                information[(j, i)] = value;
            }
        }
        information
    }

    /// Motion of the motors as laws see it.
    fn motors(&self, motion: &Motion, work: &mut Workspace) {
        if self.laws.iter().all(Laws::is_empty) {
            return;
        }
        work.motors = of_motors(motion, self.to_motors(), self.model.offset());
    }

    fn fill_rows(&self, motion: &Motion, work: &mut Workspace) {
        let (stride, samples) = (work.stride, work.samples);
        for (c, channel) in self.columns.channels.iter().enumerate() {
            let laws = &self.laws[channel.joint];
            if !laws.is_empty() {
                let [q, dq, ddq] = &work.motors.values;
                let j = channel.joint;
                laws.evaluate([&q[j], &dq[j], &ddq[j]], &mut work.laws[j]);
            }
            for (k, recipe) in channel.recipes.iter().enumerate() {
                let out = &mut work.rows[c][k * stride..(k + 1) * stride];
                match recipe {
                    Recipe::Bodies(parts) => {
                        out.fill(0.0);
                        for part in parts {
                            let (entry, weight) = (part.entry, part.weight);
                            let series = &work.entries[entry * stride..(entry + 1) * stride];
                            let pairs = out[..samples].iter_mut().zip(series);
                            match part.carried {
                                None => pairs.for_each(|(to, y)| *to += weight * y),
                                Some(by) => {
                                    let turns = motion.carried.iter();
                                    let turns = turns.map(|map| map[(by.passive, by.motor)]);
                                    pairs
                                        .zip(turns)
                                        .for_each(|((to, y), p)| *to += weight * p * y);
                                }
                            }
                        }
                    }
                    Recipe::Law { effect, parameter } => {
                        let series = &work.laws[channel.joint].by_parameter[*effect][*parameter];
                        for (to, y) in out.iter_mut().zip(series) {
                            *to = channel.weight * y;
                        }
                    }
                }
            }
        }
    }

    /// 2F, every product of columns as often as it counts.
    fn row_weights(&self, by_information: &DMatrix<f64>) -> DMatrix<f64> {
        by_information.component_mul(&self.columns.multiplicity) * 2.0
    }

    /// G of every channel, column by column like its rows, for `∂f/∂M` at the motion that was evaluated last with this
    /// workspace.
    fn row_gradient(&self, by_information: &DMatrix<f64>, work: &Workspace) -> Vec<Vec<f64>> {
        let weights = self.row_weights(by_information);
        let channels = self.columns.channels.iter().zip(&work.rows);
        let of_channel = |(channel, rows): (&Channel, &Vec<f64>)| {
            let mut gradient = vec![0.0; rows.len()];
            channel_gradient(channel, &weights, rows, &mut gradient);
            gradient
        };
        channels.map(of_channel).collect()
    }

    /// `⟨G, W⟩` sample by sample, for `∂f/∂M` at the motion that was evaluated last with the workspace: how f changes with a
    /// motion is how this does while G stays.
    pub fn weighted(&self, by_information: &DMatrix<f64>, work: &Workspace) -> Weighted<'_, 'm> {
        Weighted {
            observation: self,
            gradient: self.row_gradient(by_information, work),
            work: work.clone(),
        }
    }

    /// Adds to `slopes` the gradient of f with respect to the motion of the joints, for `∂f/∂M` at the
    /// motion that was evaluated last with this workspace. A tree's: loops have [`Observation::weighted`].
    pub fn pull(
        &self,
        motion: &Motion,
        by_information: &DMatrix<f64>,
        work: &mut Workspace,
        slopes: &mut Motion,
    ) {
        let stride = work.stride;
        work.entry_slopes.fill(0.0);
        let weights = self.row_weights(by_information);
        for (c, channel) in self.columns.channels.iter().enumerate() {
            let rows = &work.rows[c];
            channel_gradient(channel, &weights, rows, &mut work.slopes[..rows.len()]);
            for (k, recipe) in channel.recipes.iter().enumerate() {
                let Recipe::Bodies(parts) = recipe else {
                    continue;
                };
                let g = &work.slopes[k * stride..(k + 1) * stride];
                for part in parts {
                    let first = part.entry * stride;
                    let out = &mut work.entry_slopes[first..first + stride];
                    for (to, y) in out.iter_mut().zip(g) {
                        *to += part.weight * y;
                    }
                }
            }
            self.pull_laws(c, work, slopes);
        }
        let kernel = SlopesKernel {
            tree: self.model.tree(),
            motion: motion.trajectory(),
            entries: &self.columns.entries,
            stride,
            slopes: &work.entry_slopes,
            out: slopes,
        };
        instructions::run(kernel, InstructionSet::detect());
    }

    /// The part of the gradient that comes through the laws of a channel's motor.
    fn pull_laws(&self, c: usize, work: &Workspace, slopes: &mut Motion) {
        let channel = &self.columns.channels[c];
        let of_law = |(k, recipe): (usize, &Recipe)| match recipe {
            Recipe::Law { effect, parameter } => Some((k, *effect, *parameter)),
            Recipe::Bodies(_) => None,
        };
        let own: Vec<_> = channel
            .recipes
            .iter()
            .enumerate()
            .filter_map(of_law)
            .collect();
        if own.is_empty() {
            return;
        }
        let (stride, j) = (work.stride, channel.joint);
        let [q, dq, ddq] = &work.motors.values;
        let motion = [&q[j][..], &dq[j], &ddq[j]];
        self.laws[j].differences(motion, |difference| {
            let factor = difference.factor;
            let mut by_motor = vec![0.0; work.samples];
            for &(k, effect, parameter) in &own {
                let g = &work.slopes[k * stride..(k + 1) * stride];
                let after = &difference.after.by_parameter[effect][parameter];
                let before = &difference.before.by_parameter[effect][parameter];
                for (s, to) in by_motor.iter_mut().enumerate() {
                    *to += channel.weight * factor * g[s] * (after[s] - before[s]);
                }
            }
            self.to_joints(j, difference.order, &by_motor, slopes);
        });
    }

    /// Carries slopes along a motor's motion to the joints that turn with it.
    pub fn to_joints(&self, motor: usize, order: usize, by_motor: &[f64], slopes: &mut Motion) {
        for i in 0..self.model.joints().len() {
            let factor = match &self.to_motors {
                Some(inverse) => inverse[(motor, i)],
                None => f64::from(u8::from(i == motor)),
            };
            if factor != 0.0 {
                for (to, s) in slopes.values[order][i].iter_mut().zip(by_motor) {
                    *to += factor * s;
                }
            }
        }
    }
}

/// `G = W 2F` of one channel, column by column like its rows.
fn channel_gradient(channel: &Channel, weights: &DMatrix<f64>, rows: &[f64], out: &mut [f64]) {
    let count = channel.columns.len();
    let stride = rows.len() / count.max(1);
    let own = DMatrix::from_fn(count, count, |a, b| {
        weights[(channel.columns[a], channel.columns[b])]
    });
    matmul(
        MatMut::from_column_major_slice_mut(out, stride, count),
        Accum::Replace,
        MatRef::from_column_major_slice(rows, stride, count),
        MatRef::from_column_major_slice(own.as_slice(), count, count),
        1.0,
        Par::Seq,
    );
}

/// Rows of motions, weighted by what a function of the information asks of them.
#[derive(Debug)]
pub struct Weighted<'o, 'm> {
    observation: &'o Observation<'m>,
    gradient: Vec<Vec<f64>>,
    work: Workspace,
}

impl AlongMotion for Weighted<'_, '_> {
    fn series(&mut self, motion: &Motion) -> Vec<Vec<f64>> {
        let (stride, samples) = (self.work.stride, self.work.samples);
        self.observation.observe(motion, &mut self.work);
        let mut sum = vec![0.0; samples];
        for (gradient, rows) in self.gradient.iter().zip(&self.work.rows) {
            for (g, w) in gradient.chunks(stride).zip(rows.chunks(stride)) {
                let terms = sum.iter_mut().zip(g.iter().zip(w));
                terms.for_each(|(sum, (g, w))| *sum += g * w);
            }
        }
        vec![sum]
    }
}

/// The entries of the regressor along a motion.
struct EntriesKernel<'a> {
    tree: &'a Tree,
    motion: Trajectory<'a>,
    entries: &'a Entries,
    stride: usize,
    values: &'a mut [f64],
}

struct EntrySink<'a> {
    entries: &'a Entries,
    stride: usize,
    at: usize,
    values: &'a mut [f64],
}

impl<L: Lanes> BlockSink<L> for EntrySink<'_> {
    #[inline(always)]
    fn put(&mut self, row: usize, link: usize, block: &[L; 10]) {
        let numbers = self.entries.of(row, link);
        for (number, lanes) in numbers.into_iter().zip(block) {
            if let Some(number) = number {
                lanes.store(self.values, number * self.stride + self.at);
            }
        }
    }
}

impl Kernel for EntriesKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut recursion = Regressor::<L>::new(self.tree, Rows::Torque);
        let mut state = LaneState::<L>::new(self.tree.len());
        for at in (0..self.motion.len()).step_by(LANES) {
            state.load(self.motion, at..self.motion.len());
            let mut sink = EntrySink {
                entries: self.entries,
                stride: self.stride,
                at,
                values: &mut self.values[..],
            };
            recursion.blocks(self.tree, state.slices(), &mut sink);
        }
    }
}

/// The gradient of `Σ slope · entry` along a motion.
struct SlopesKernel<'a> {
    tree: &'a Tree,
    motion: Trajectory<'a>,
    entries: &'a Entries,
    stride: usize,
    slopes: &'a [f64],
    out: &'a mut Motion,
}

impl Kernel for SlopesKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let n = self.tree.len();
        let mut recursion = RegressorGradient::<L>::new(self.tree);
        let mut state = LaneState::<L>::new(n);
        let samples = self.motion.len();
        for at in (0..samples).step_by(LANES) {
            state.load(self.motion, at..self.motion.len());
            let gradient = recursion.evaluate(
                self.tree,
                state.slices(),
                #[inline(always)]
                |row, link| {
                    let mut weights = [L::constant(0.0); 10];
                    let numbers = self.entries.of(row, link);
                    for (number, weight) in numbers.into_iter().zip(&mut weights) {
                        if let Some(number) = number {
                            *weight = L::load(self.slopes, number * self.stride + at);
                        }
                    }
                    weights
                },
            );
            let count = LANES.min(samples - at);
            for j in 0..n {
                let parts = [&gradient.q[j], &gradient.dq[j], &gradient.ddq[j]];
                for (order, lanes) in parts.into_iter().enumerate() {
                    let out = &mut self.out.values[order][j][at..at + count];
                    for (to, g) in out.iter_mut().zip(lanes.to_array()) {
                        *to += g;
                    }
                }
            }
        }
    }
}
