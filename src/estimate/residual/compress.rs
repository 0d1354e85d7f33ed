//! Compresses the weighted residual and its derivatives, `[W J, W (ŝ − s)]`, to their triangular factor
//! by QR, block by block: memory does not grow with the number of samples.
//!
//! Every row is compressed over the columns that it depends on: with one weight per channel, which for a
//! serial arm saves half of the work, and as well with a full weight, whose rows mix channels first. Tasks
//! run in parallel and are merged in their order, so the result is the same for any number of threads.

use crate::chain::dataset::Prepared;
use crate::chain::evaluate::KnownBodies;
use crate::chain::model::Model;
use crate::estimate::residual::rows::{RowBlock, Task, tasks, visit_errors};
use crate::estimate::residual::weights::{RowFactors, Weights};
use crate::linalg::triangular::Triangular;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// What is compressed: a model at parameter values, derivatives with respect to some parameters.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// Predicts ŝ, and has the parameters of the columns.
    pub model: &'a Model,
    /// Values of all its parameters, at which derivatives are taken.
    pub values: &'a DVector<f64>,
    /// Positions of the parameters whose derivatives are columns of the factor.
    pub columns: &'a [usize],
    /// What rows are multiplied by.
    pub weights: &'a Weights,
    /// Factors of single rows of the recordings, in their order.
    pub factors: Option<&'a RowFactors>,
    /// What the bodies do along the recordings, in their order, where it is known.
    pub bodies: &'a [Option<KnownBodies>],
}

/// The triangular factor of `[W J, W (ŝ − s)]`, order p + 1.
pub fn factor(request: &Request<'_>, recordings: &[&Prepared]) -> Triangular {
    let order = request.columns.len() + 1;
    let rows = Row::all(request);
    let parts: Vec<Vec<Part>> = indexed_tasks(request, recordings)
        .par_iter()
        .map(|(recording, task)| compressed(request, &rows, *recording, task))
        .collect();
    let mut alike: Vec<Vec<Part>> = Vec::new();
    for part in parts.into_iter().flatten() {
        match alike.iter_mut().find(|parts| parts[0].is_over(&part)) {
            Some(same) => same.push(part),
            None => alike.push(vec![part]),
        }
    }
    let merged = alike.into_iter().map(Part::merged);
    let spread: Vec<DMatrix<f64>> = merged
        .map(|part| spread(&part, order) * rows[part.row].after)
        .collect();
    let mut whole = Triangular::new(order);
    whole.absorb(stacked(&spread, order).as_slice());
    whole
}

/// Matrices of as many columns one below the other.
pub(in crate::estimate) fn stacked(matrices: &[DMatrix<f64>], columns: usize) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(matrices.iter().map(DMatrix::nrows).sum(), columns);
    let mut first = 0;
    for matrix in matrices {
        all.rows_mut(first, matrix.nrows()).copy_from(matrix);
        first += matrix.nrows();
    }
    all
}

/// Sum of squares of the weighted residual.
pub fn sum_of_squares(request: &Request<'_>, recordings: &[&Prepared]) -> f64 {
    let weights = request.weights.matrix();
    let parts: Vec<f64> = indexed_tasks(request, recordings)
        .par_iter()
        .map(|(recording, task)| {
            let mut sum = 0.0;
            visit_errors(request.model, request.values, &[], task, |block| {
                sum += Residuals::of(request, *recording, block).squares(&weights);
            });
            sum
        })
        .collect();
    parts.iter().sum()
}

fn indexed_tasks<'a>(request: &Request<'a>, recordings: &[&'a Prepared]) -> Vec<(usize, Task<'a>)> {
    let indexed = recordings.iter().enumerate();
    indexed
        .flat_map(|(k, recording)| {
            let bodies = request.bodies.get(k).and_then(Option::as_ref);
            let tasks = tasks(request.model, std::iter::once(*recording)).into_iter();
            tasks.map(move |task| (k, Task { bodies, ..task }))
        })
        .collect()
}

/// One row of W over the active channels.
struct Row {
    /// Channels and their weights.
    terms: Vec<(usize, f64)>,
    /// Weight of the whole row, which its factor is given at the end.
    after: f64,
}

impl Row {
    fn all(request: &Request<'_>) -> Vec<Self> {
        let channels = request.model.channels();
        let active: Vec<usize> = (0..channels.len())
            .filter(|&c| channels[c].active)
            .collect();
        let of = |&row: &usize| match request.weights {
            Weights::PerChannel(weights) => Self {
                terms: vec![(row, 1.0)],
                after: weights[row],
            },
            Weights::Full(weights) => Self {
                terms: active
                    .iter()
                    .filter(|&&c| weights[(row, c)] != 0.0)
                    .map(|&c| (c, weights[(row, c)]))
                    .collect(),
                after: 1.0,
            },
        };
        active.iter().map(of).collect()
    }
}

/// The factor of some rows of the recordings over the columns that they depend on.
struct Part {
    /// Row of W.
    row: usize,
    /// Columns of J that the rows depend on; the residual comes after them.
    columns: Vec<usize>,
    factor: Triangular,
}

impl Part {
    fn is_over(&self, other: &Self) -> bool {
        self.row == other.row && self.columns == other.columns
    }

    /// The factor of all rows of parts over the same columns, taken up together.
    fn merged(mut parts: Vec<Self>) -> Self {
        let mut first = parts.remove(0);
        let rest: Vec<DMatrix<f64>> = parts.iter().map(|p| p.factor.matrix()).collect();
        first
            .factor
            .absorb(stacked(&rest, first.factor.columns()).as_slice());
        first
    }
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

/// The factors of a task, of every row of W over the columns that it turns out to depend on.
fn compressed(request: &Request<'_>, rows: &[Row], recording: usize, task: &Task<'_>) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    let mut mixed: Vec<Vec<f64>> = Vec::new();
    let mut residuals = vec![Vec::new(); request.model.channels().len()];
    let (model, wanted) = (request.model, request.columns);
    visit_errors(model, request.values, wanted, task, |block| {
        let keep = block.counting();
        for (channel, to) in residuals.iter_mut().enumerate() {
            to.clear();
            if model.channels()[channel].active {
                to.extend(difference(block, channel));
            }
        }
        for (number, row) in rows.iter().enumerate() {
            let part = part_of(&mut parts, number, row, block, wanted.len());
            let Part {
                columns, factor, ..
            } = &mut parts[part];
            let series = |c: usize, k: usize| match columns.get(k) {
                Some(&column) => block.derivative(c, column),
                None => Some(residuals[c].as_slice()),
            };
            let count = columns.len() + 1;
            let mut slices: Vec<&[f64]> = Vec::with_capacity(count);
            match row.terms.as_slice() {
                [(c, 1.0)] if keep.is_none() && request.factors.is_none() => {
                    slices.extend((0..count).filter_map(|k| series(*c, k)));
                }
                _ => {
                    mixed.resize_with(count.max(mixed.len()), Vec::new);
                    for (k, to) in mixed.iter_mut().enumerate().take(count) {
                        to.clear();
                        to.resize(block.range.len(), 0.0);
                        for &(c, weight) in &row.terms {
                            let factors = factors_of(request, recording, c, block);
                            if let Some(from) = series(c, k) {
                                add(to, weight, factors, from);
                            }
                        }
                        only(to, keep.as_deref());
                    }
                    slices.extend(mixed.iter().take(count).map(Vec::as_slice));
                }
            }
            factor.absorb_columns(&slices);
        }
    });
    parts
}

/// Position of the part of a row of W over the columns that it depends on in a block, appended where it is new.
fn part_of(
    parts: &mut Vec<Part>,
    number: usize,
    row: &Row,
    block: &RowBlock<'_>,
    wanted: usize,
) -> usize {
    let depends = |k: &usize| (row.terms.iter()).any(|&(c, _)| block.derivative(c, *k).is_some());
    let columns = (0..wanted).filter(depends);
    let is_same = |p: &Part| p.row == number && columns.clone().eq(p.columns.iter().copied());
    let known = parts.iter().position(is_same);
    known.unwrap_or_else(|| {
        let columns: Vec<usize> = columns.collect();
        parts.push(Part {
            row: number,
            factor: Triangular::new(columns.len() + 1),
            columns,
        });
        parts.len() - 1
    })
}

/// Adds a series times a weight and the factors of single rows.
fn add(to: &mut [f64], weight: f64, factors: Option<&[f64]>, from: &[f64]) {
    match factors {
        None => to
            .iter_mut()
            .zip(from)
            .for_each(|(to, x)| *to += weight * x),
        Some(factors) => {
            let weighted = factors.iter().zip(from).map(|(f, x)| weight * f * x);
            to.iter_mut().zip(weighted).for_each(|(to, x)| *to += x);
        }
    }
}

/// Leaves the rows that count.
fn only(series: &mut Vec<f64>, keep: Option<&[bool]>) {
    if let Some(keep) = keep {
        let mut counts = keep.iter();
        series.retain(|_| *counts.next().unwrap_or(&false));
    }
}

fn difference(block: &RowBlock<'_>, channel: usize) -> impl Iterator<Item = f64> {
    let pairs = block.predicted(channel).iter().zip(block.recorded(channel));
    pairs.map(|(p, r)| p - r)
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
                let mut series: Vec<f64> = difference(block, c).collect();
                if let Some(factors) = factors {
                    series.iter_mut().zip(factors).for_each(|(e, f)| *e *= f);
                }
                only(&mut series, keep.as_deref());
                series
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
