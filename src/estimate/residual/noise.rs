//! The residuals of a fit over time, and the covariance of a row.

use crate::chain::dataset::Prepared;
use crate::chain::model::Model;
use crate::estimate::residual::rows::{tasks, torque_gains, visit};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Residuals `ŝ − s` of recordings, `[recording][channel][row]`; rows that do not count are zero.
pub type ResidualSeries = Vec<Vec<Vec<f64>>>;

/// Predicted signal of every used row of a recording, `[channel][row]`.
pub fn predict(model: &Model, values: &DVector<f64>, recording: &Prepared) -> Vec<Vec<f64>> {
    let parts: Vec<Vec<Vec<f64>>> = tasks(model, std::iter::once(recording))
        .par_iter()
        .map(|task| {
            let mut out = vec![Vec::with_capacity(task.range.len()); model.channels().len()];
            visit(model, values, &[], task, |block| {
                for (c, series) in out.iter_mut().enumerate() {
                    series.extend_from_slice(block.predicted(c));
                }
            });
            out
        })
        .collect();
    let mut whole = vec![Vec::with_capacity(recording.rows()); model.channels().len()];
    for part in parts {
        for (to, from) in whole.iter_mut().zip(part) {
            to.extend(from);
        }
    }
    whole
}

/// Residuals of recordings at parameter values; as torques where these err and not the currents.
pub fn residuals(model: &Model, values: &DVector<f64>, recordings: &[&Prepared]) -> ResidualSeries {
    let of = |recording: &&Prepared| {
        let mut series = predict(model, values, recording);
        let gains = torque_gains(model, recording);
        for (c, predicted) in series.iter_mut().enumerate() {
            let active = model.channels()[c].active;
            let gain = gains[c].map_or(1.0, |at| values[at]);
            for (row, value) in predicted.iter_mut().enumerate() {
                *value = if active && recording.counts(row) {
                    gain * (*value - recording.signal(c)[row])
                } else {
                    0.0
                };
            }
        }
        series
    };
    recordings.iter().map(of).collect()
}

/// Covariance of one row of the residuals over the rows that count, `e_iᵀe_j / √(n_i n_j)` with `n_i = N_i −
/// unknowns/channels`: positive definite also where channels count in different rows. A residual of exactly zero is a
/// row left out. Channels that are not active have unit variance, so that the matrix stays invertible.
pub fn row_covariance(model: &Model, residuals: &ResidualSeries, unknowns: usize) -> DMatrix<f64> {
    let channels = model.channels().len();
    let active = model.channels().iter().filter(|c| c.active).count().max(1);
    let spent = unknowns as f64 / active as f64;
    let free = |c: usize| {
        let all = residuals.iter().flat_map(|r| &r[c]);
        (all.filter(|e| **e != 0.0).count() as f64 - spent).max(1.0)
    };
    let free: Vec<f64> = (0..channels).map(free).collect();
    let mut covariance = DMatrix::zeros(channels, channels);
    for i in 0..channels {
        for j in 0..=i {
            let pairs = residuals.iter().flat_map(|r| r[i].iter().zip(&r[j]));
            let sum: f64 = pairs.map(|(a, b)| a * b).sum();
            covariance[(i, j)] = sum / (free[i] * free[j]).sqrt();
            covariance[(j, i)] = covariance[(i, j)];
        }
    }
    for (c, channel) in model.channels().iter().enumerate() {
        if !channel.active {
            covariance[(c, c)] = 1.0;
        }
    }
    covariance
}

/// Rows of recordings that count.
pub fn counting_rows(recordings: &[&Prepared]) -> usize {
    let of = |r: &&Prepared| r.counting().count();
    recordings.iter().map(of).sum()
}
