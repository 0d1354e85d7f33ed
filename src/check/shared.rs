//! One robot behind all channels: `min_β Σ_c ‖(s_c − Y_row(c) β) / σ_c‖²`, the same base parameters β in every
//! row, and σ_c the residual deviation of channel c, iterated.
//!
//! With parameters of its own every row would explain the small torques of the wrist, whatever the order.

use crate::chain::base_parameters::BaseParameters;
use crate::chain::model::Model;
use crate::check::regression::{Comparison, Sampled, columns, factor, rest};
use crate::linalg::triangular::Triangular;
use nalgebra::{DMatrix, DVector};

/// Rounds of reweighting.
const ROUNDS: usize = 3;

/// Weight of β = 0 over a column's norm: decides what the motion leaves open, and nothing else.
const RIDGE: f64 = 1e-6;

/// Share of a signal below which its residual is rounding: simulated signals without noise tell no order.
const EXACT: f64 = 1e-6;

/// The rows of all joints for one motion, compressed with every signal as right-hand side.
pub(super) struct Rows {
    rows: Vec<Row>,
    /// Norms of the signals.
    sizes: Vec<f64>,
    samples: usize,
    unknowns: usize,
}

struct Row {
    /// Base parameters that the row depends on.
    columns: Vec<usize>,
    /// Columns, then signals.
    factor: Triangular,
}

/// Base parameters of a free model, with its load or without.
pub(super) fn base(model: &Model, loaded: bool) -> Vec<usize> {
    let no_prior = DMatrix::zeros(0, model.parameters().len());
    BaseParameters::structural(model, &[loaded], &no_prior).kept()
}

impl Rows {
    /// Rows of a model over a motion; `channels` are those that are judged.
    pub fn new(
        comparison: &Comparison,
        model: &Model,
        sampled: &Sampled,
        channels: &[usize],
        base: &[usize],
    ) -> Self {
        let signals: Vec<&[f64]> = channels
            .iter()
            .map(|&c| comparison.torque[c].as_slice())
            .collect();
        let all = columns(model, sampled, base);
        let row = |&c: &usize| Row {
            columns: all[c]
                .iter()
                .filter_map(|(p, _)| base.iter().position(|b| b == p))
                .collect(),
            factor: factor(&all[c], &signals),
        };
        let norm = |s: &&[f64]| s.iter().map(|x| x * x).sum::<f64>().sqrt();
        Self {
            rows: channels.iter().map(row).collect(),
            sizes: signals.iter().map(norm).collect(),
            samples: sampled.len(),
            unknowns: base.len(),
        }
    }

    /// ln σ of every signal where signal k belongs to row `order[k]`.
    pub fn deviations(&self, order: &[usize]) -> Vec<f64> {
        let floor = |k: usize| (EXACT * self.sizes[k]).max(f64::MIN_POSITIVE);
        let mut left: Vec<f64> = (0..order.len())
            .map(|k| self.sizes[k].max(floor(k)))
            .collect();
        for _ in 0..ROUNDS {
            let solution = self.solve(order, &left);
            left = (0..order.len())
                .map(|k| self.left(order[k], k, &solution).max(floor(k)))
                .collect();
        }
        let freedom = (self.samples as f64 - self.unknowns as f64 / order.len() as f64).max(1.0);
        left.iter()
            .map(|norm| (norm / freedom.sqrt()).ln())
            .collect()
    }

    fn solve(&self, order: &[usize], scales: &[f64]) -> DVector<f64> {
        let count = self.unknowns;
        let mut whole = Triangular::new(count + 1);
        for (signal, &row) in order.iter().enumerate() {
            let Row { columns, factor } = &self.rows[row];
            let mut block = DMatrix::zeros(columns.len().max(count + 1), count + 1);
            for i in 0..columns.len() {
                for (k, &column) in columns.iter().enumerate().skip(i) {
                    block[(i, column)] = factor.entry(i, k) / scales[signal];
                }
                block[(i, count)] = factor.entry(i, columns.len() + signal) / scales[signal];
            }
            whole.absorb(block.as_slice());
        }
        let norms = whole.column_norms();
        let largest = norms.rows(0, count).amax();
        let ridge = |k: usize| RIDGE * norms[k].max(RIDGE * largest);
        let open = DMatrix::from_fn(count + 1, count + 1, |i, j| {
            if i == j && i < count { ridge(i) } else { 0.0 }
        });
        whole.absorb(open.as_slice());
        let zeros = || DVector::zeros(count);
        whole
            .system()
            .and_then(|system| system.matrix.solve_upper_triangular(&system.right))
            .unwrap_or_else(zeros)
    }

    /// Norm of what a solution leaves of a signal in a row.
    fn left(&self, row: usize, signal: usize, solution: &DVector<f64>) -> f64 {
        let Row { columns, factor } = &self.rows[row];
        let count = columns.len();
        let of = |i: usize| {
            let entries = (i..count).map(|k| factor.entry(i, k) * solution[columns[k]]);
            entries.sum::<f64>() - factor.entry(i, count + signal)
        };
        let reached: f64 = (0..count).map(|i| of(i).powi(2)).sum();
        reached.sqrt().hypot(rest(factor, count, signal))
    }
}
