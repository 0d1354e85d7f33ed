//! Compresses the weighted residual and its derivatives, `[W J, W (ŝ − s)]`, to their triangular factor
//! by QR, block by block: memory does not grow with the number of samples.
//!
//! With one weight per channel every channel is compressed by itself over the columns that it depends on,
//! which for a serial arm saves half of the work; a full weight mixes the channels of a row first. Tasks
//! run in parallel and are merged in their order, so the result is the same for any number of threads.

use crate::chain::dataset::Prepared;
use crate::chain::model::Model;
use crate::estimate::rows::{RowBlock, Task, tasks, visit};
use crate::estimate::weights::{RowFactors, Weights};
use crate::linalg::triangular::Triangular;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// What is compressed: a model at parameter values, derivatives with respect to some parameters.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    pub model: &'a Model,
    pub values: &'a DVector<f64>,
    pub columns: &'a [usize],
    pub weights: &'a Weights,
    /// Factors of single rows of the recordings, in their order.
    pub factors: Option<&'a RowFactors>,
}

/// The triangular factor of `[W J, W (ŝ − s)]`, order p + 1.
pub fn factor(request: &Request<'_>, recordings: &[&Prepared]) -> Triangular {
    let order = request.columns.len() + 1;
    let parts: Vec<Vec<Part>> = indexed_tasks(request.model, recordings)
        .par_iter()
        .map(|(recording, task)| match request.weights {
            Weights::PerChannel(_) => by_channel(request, *recording, task),
            Weights::Full(weights) => vec![mixed(request, weights, *recording, task)],
        })
        .collect();
    let mut whole = Triangular::new(order);
    let mut merged: Vec<Part> = Vec::new();
    for part in parts.into_iter().flatten() {
        match merged
            .iter_mut()
            .find(|m| m.columns == part.columns && m.channel == part.channel)
        {
            Some(same) => same.factor.merge(&part.factor),
            None => merged.push(part),
        }
    }
    for part in merged {
        let weight = match request.weights {
            Weights::PerChannel(weights) => weights[part.channel],
            Weights::Full(_) => 1.0,
        };
        whole.absorb((spread(&part, order) * weight).as_slice());
    }
    whole
}

/// Sum of squares of the weighted residual.
pub fn sum_of_squares(request: &Request<'_>, recordings: &[&Prepared]) -> f64 {
    let weights = request.weights.matrix();
    let parts: Vec<f64> = indexed_tasks(request.model, recordings)
        .par_iter()
        .map(|(recording, task)| {
            let mut sum = 0.0;
            visit(request.model, request.values, &[], task, |block| {
                sum += Residuals::of(request, *recording, block).squares(&weights);
            });
            sum
        })
        .collect();
    parts.iter().sum()
}

fn indexed_tasks<'a>(model: &Model, recordings: &[&'a Prepared]) -> Vec<(usize, Task<'a>)> {
    let indexed = recordings.iter().enumerate();
    indexed
        .flat_map(|(k, recording)| {
            tasks(model, std::iter::once(*recording))
                .into_iter()
                .map(move |task| (k, task))
        })
        .collect()
}

/// The factor of some rows over the columns that they depend on, before the channel's weight.
struct Part {
    /// Channel whose rows these are; not looked at for rows that mix channels.
    channel: usize,
    /// Columns of J that the rows depend on; the residual comes after them.
    columns: Vec<usize>,
    factor: Triangular,
}

/// Rows of a factor over some columns, as rows over all of them.
fn spread(part: &Part, order: usize) -> DMatrix<f64> {
    let mut rows = DMatrix::zeros(part.factor.columns(), order);
    for i in 0..part.factor.columns() {
        for (k, &column) in part.columns.iter().enumerate() {
            rows[(i, column)] = part.factor.entry(i, k);
        }
        rows[(i, order - 1)] = part.factor.entry(i, part.columns.len());
    }
    rows
}

fn by_channel(request: &Request<'_>, recording: usize, task: &Task<'_>) -> Vec<Part> {
    let mut parts: Vec<Option<Part>> = Vec::new();
    parts.resize_with(request.model.channels().len(), || None);
    visit(
        request.model,
        request.values,
        request.columns,
        task,
        |block| {
            for (c, channel) in request.model.channels().iter().enumerate() {
                if !channel.active {
                    continue;
                }
                let part = parts[c].get_or_insert_with(|| {
                    let depends = |k: &usize| block.derivative(c, *k).is_some();
                    let columns: Vec<usize> = (0..request.columns.len()).filter(depends).collect();
                    Part {
                        channel: c,
                        factor: Triangular::new(columns.len() + 1),
                        columns,
                    }
                });
                let residual = difference(block, c);
                let zero = vec![0.0; block.range.len()];
                let series = part
                    .columns
                    .iter()
                    .map(|&k| block.derivative(c, k).unwrap_or(&zero));
                let slices: Vec<&[f64]> = series.chain([residual.as_slice()]).collect();
                let keep = block.counting();
                let row_factors = factors_of(request, recording, c, block);
                if keep.is_none() && row_factors.is_none() {
                    part.factor.absorb_columns(&slices);
                    continue;
                }
                let weighted: Vec<Vec<f64>> = slices
                    .iter()
                    .map(|series| weigh(series, row_factors, keep.as_deref()))
                    .collect();
                let slices: Vec<&[f64]> = weighted.iter().map(Vec::as_slice).collect();
                part.factor.absorb_columns(&slices);
            }
        },
    );
    parts.into_iter().flatten().collect()
}

fn mixed(request: &Request<'_>, weights: &DMatrix<f64>, recording: usize, task: &Task<'_>) -> Part {
    let order = request.columns.len() + 1;
    let mut part = Part {
        channel: 0,
        columns: (0..request.columns.len()).collect(),
        factor: Triangular::new(order),
    };
    visit(
        request.model,
        request.values,
        request.columns,
        task,
        |block| {
            let rows = block.range.len();
            let keep = block.counting();
            let active: Vec<usize> = (0..weights.nrows())
                .filter(|&c| request.model.channels()[c].active)
                .collect();
            let residuals: Vec<Vec<f64>> =
                (0..weights.nrows()).map(|c| difference(block, c)).collect();
            for &row in &active {
                let mut columns = vec![vec![0.0; rows]; order];
                for &c in active.iter().filter(|&&c| weights[(row, c)] != 0.0) {
                    let weight = weights[(row, c)];
                    let factors = factors_of(request, recording, c, block);
                    let add = |to: &mut Vec<f64>, from: &[f64]| {
                        for (k, (to, x)) in to.iter_mut().zip(from).enumerate() {
                            *to += weight * factors.map_or(1.0, |f| f[k]) * x;
                        }
                    };
                    for k in 0..request.columns.len() {
                        if let Some(series) = block.derivative(c, k) {
                            add(&mut columns[k], series);
                        }
                    }
                    add(&mut columns[order - 1], &residuals[c]);
                }
                let kept: Vec<Vec<f64>> = match &keep {
                    None => columns,
                    Some(keep) => columns.iter().map(|s| weigh(s, None, Some(keep))).collect(),
                };
                let slices: Vec<&[f64]> = kept.iter().map(Vec::as_slice).collect();
                part.factor.absorb_columns(&slices);
            }
        },
    );
    part
}

fn difference(block: &RowBlock<'_>, channel: usize) -> Vec<f64> {
    let pairs = block.predicted(channel).iter().zip(block.recorded(channel));
    pairs.map(|(p, r)| p - r).collect()
}

fn factors_of<'a>(
    request: &Request<'a>,
    recording: usize,
    channel: usize,
    block: &RowBlock<'_>,
) -> Option<&'a [f64]> {
    let series = &request.factors?[recording][channel];
    Some(&series[block.start()..block.start() + block.range.len()])
}

/// The rows that count, each times its factor.
fn weigh(series: &[f64], factors: Option<&[f64]>, keep: Option<&[bool]>) -> Vec<f64> {
    let weighted: Vec<f64> = match factors {
        None => series.to_vec(),
        Some(factors) => series.iter().zip(factors).map(|(x, f)| f * x).collect(),
    };
    match keep {
        None => weighted,
        Some(keep) => {
            let kept = weighted.iter().zip(keep).filter(|(_, keep)| **keep);
            kept.map(|(x, _)| *x).collect()
        }
    }
}

/// Residuals of the rows of a block that count, factors of single rows included.
pub(crate) struct Residuals {
    channels: Vec<Vec<f64>>,
    pub rows: usize,
}

impl Residuals {
    pub fn of(request: &Request<'_>, recording: usize, block: &RowBlock<'_>) -> Self {
        let keep = block.counting();
        let channels: Vec<Vec<f64>> = (0..request.model.channels().len())
            .map(|c| {
                if !request.model.channels()[c].active {
                    return Vec::new();
                }
                let factors = factors_of(request, recording, c, block);
                weigh(&difference(block, c), factors, keep.as_deref())
            })
            .collect();
        let rows = channels.iter().map(Vec::len).max().unwrap_or(0);
        Self { channels, rows }
    }

    /// Σ |W e|² over the rows.
    fn squares(&self, weights: &DMatrix<f64>) -> f64 {
        let mut sum = 0.0;
        let mut mixed = vec![0.0; self.rows];
        for w in weights.row_iter() {
            mixed.fill(0.0);
            for (series, weight) in self.channels.iter().zip(w.iter()) {
                if *weight != 0.0 {
                    mixed
                        .iter_mut()
                        .zip(series)
                        .for_each(|(m, e)| *m += weight * e);
                }
            }
            sum += mixed.iter().map(|m| m * m).sum::<f64>();
        }
        sum
    }
}
