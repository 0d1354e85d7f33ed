//! The residuals of a fit over time: covariance of a row, and how far they are from white.

use crate::chain::model::Model;
use crate::chain::dataset::Prepared;
use crate::estimate::rows::{tasks, visit};
use crate::stats::autoregression::{Autoregression, OrderCriterion};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Residuals `ŝ − s` of recordings, `[recording][channel][row]`; rows that do not count are zero.
pub type ResidualSeries = Vec<Vec<Vec<f64>>>;

/// Predicted signal of every used row of a recording, `[channel][row]`.
pub fn predict(model: &Model, values: &DVector<f64>, recording: &Prepared) -> Vec<Vec<f64>> {
    let parts: Vec<Vec<Vec<f64>>> = tasks(std::iter::once(recording))
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

/// Residuals of recordings at parameter values.
pub fn residuals(
    model: &Model,
    values: &DVector<f64>,
    recordings: &[&Prepared],
) -> ResidualSeries {
    let of = |recording: &&Prepared| {
        let mut series = predict(model, values, recording);
        for (c, predicted) in series.iter_mut().enumerate() {
            let active = model.channels()[c].active;
            for (row, value) in predicted.iter_mut().enumerate() {
                *value = if active && recording.counts(row) {
                    *value - recording.signal(c)[row]
                } else {
                    0.0
                };
            }
        }
        series
    };
    recordings.iter().map(of).collect()
}

/// Covariance of one row of the residuals, `eᵀe / (N − unknowns/channels)`; channels that are not active
/// have unit variance, so that the matrix stays invertible.
pub fn row_covariance(
    model: &Model,
    residuals: &ResidualSeries,
    (recordings, unknowns): (&[&Prepared], usize),
) -> DMatrix<f64> {
    let channels = model.channels().len();
    let active = model.channels().iter().filter(|c| c.active).count().max(1);
    let mut sum = DMatrix::zeros(channels, channels);
    for series in residuals {
        for i in 0..channels {
            for j in 0..=i {
                let products = series[i].iter().zip(&series[j]).map(|(a, b)| a * b);
                sum[(i, j)] += products.sum::<f64>();
            }
        }
    }
    let rows = counting_rows(recordings) as f64;
    let freedom = (rows - unknowns as f64 / active as f64).max(1.0);
    for i in 0..channels {
        for j in 0..i {
            sum[(j, i)] = sum[(i, j)];
        }
    }
    sum /= freedom;
    for (c, channel) in model.channels().iter().enumerate() {
        if !channel.active {
            sum[(c, c)] = 1.0;
        }
    }
    sum
}

/// Rows of recordings that count.
pub fn counting_rows(recordings: &[&Prepared]) -> usize {
    let of = |r: &&Prepared| (0..r.rows()).filter(|&row| r.counts(row)).count();
    recordings.iter().map(of).sum()
}

/// Largest order of the autoregression of residuals: a pole pair for each of ten resonances or filters.
const MAX_ORDER: usize = 40;

/// Rows per coefficient that an autoregression needs to be worth its estimate.
const ROWS_PER_COEFFICIENT: usize = 20;

/// Colour of the residuals of each channel: an autoregression, order by the Bayesian criterion.
pub fn colour(residuals: &ResidualSeries, channels: usize) -> Vec<Autoregression> {
    (0..channels)
        .map(|c| {
            let segments: Vec<&[f64]> = residuals.iter().map(|r| r[c].as_slice()).collect();
            let rows: usize = segments.iter().map(|s| s.len()).sum();
            let order = MAX_ORDER.min(rows / ROWS_PER_COEFFICIENT);
            Autoregression::fit(&segments, order, OrderCriterion::Bic)
                .unwrap_or_else(|| Autoregression::white(0.0))
        })
        .collect()
}
