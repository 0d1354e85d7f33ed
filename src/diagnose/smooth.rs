//! A smooth model of what no effect of the vocabulary explains: a sum of piecewise linear functions of speed, of
//! position and of load, the latter two for either direction of motion.
//!
//! ```text
//! e ≈ Σ_k a_k h_k(v) + Σ_k b_k h_k(q) + c_k h_k(q) d + Σ_k p_k h_k(τ) + r_k h_k(τ) d,    d = sign(v)
//! ```
//!
//! and of one variable more, another joint's motion for example, where that alone leaves much and forecasts the rest;
//! with hat functions h over knots at quantiles; a generalised additive model (Hastie and Tibshirani 1986)
//! with a ridge that keeps what the rows do not determine at zero.

use crate::diagnose::bench::Bench;
use crate::diagnose::evidence::{Evidence, Samples, encompassing};
use crate::diagnose::refit::Refit;
use crate::diagnose::regime::Regimes;
use crate::diagnose::rows::{Series, rms};
use crate::linalg::triangular::Triangular;
use crate::recording::split::Split;
use nalgebra::{DMatrix, DVector};

/// Knots of a variable.
const KNOTS: usize = 12;

/// Ridge as a share of the mean square of a column.
const RIDGE: f64 = 1e-3;

/// Variables that every smooth model takes: the first three of a joint's regimes.
const VARIABLES: usize = 3;

/// A residual of so many times the variance of the noise is looked at over one variable more.
const MUCH: f64 = 1.5;

/// A smooth model of one channel.
#[derive(Debug, Clone)]
pub struct Smooth {
    pub channel: usize,
    /// Names of its variables.
    pub over: Vec<String>,
    /// Models of the channel that it was chosen from.
    pub tried: usize,
    pub evidence: Evidence,
    /// Share by which the held-out RMS error falls.
    pub relief: f64,
    /// RMS of what it takes from the held-out rows over that of what it leaves.
    pub taken: f64,
    /// To be subtracted from the residual, over the fitted and over the held-out rows.
    pub train: Vec<f64>,
    pub validation: Vec<f64>,
    curves: Curves,
}

/// Factors of hat functions over some variables of a joint.
#[derive(Debug, Clone)]
struct Curves {
    /// Numbers of the variables among the regimes of the joint.
    variables: Vec<usize>,
    knots: Vec<Vec<f64>>,
    factors: DVector<f64>,
}

impl Curves {
    fn at(&self, regimes: &Regimes) -> Vec<f64> {
        let forecast = design(&regimes.of_some(&self.variables), &self.knots) * &self.factors;
        forecast.as_slice().to_vec()
    }
}

impl Smooth {
    /// The same correction over other rows than those by which it was chosen, with the evidence of these.
    pub fn on(&self, bench: &Bench<'_>, refit: &Refit) -> Self {
        let model = &refit.model;
        let Some(joint) = model.channels()[self.channel].joint else {
            return self.clone();
        };
        let [train, validation] = [Split::Train, Split::Validation].map(|split| {
            let recordings = bench.recordings(split);
            let series = Series::of(model, &refit.values, &[], &recordings);
            self.curves
                .at(&Regimes::of(model, (joint, &series.predicted), &recordings))
        });
        let before = &refit.validation[self.channel];
        let after: Vec<f64> = before.iter().zip(&validation).map(|(e, f)| e - f).collect();
        Self {
            relief: 1.0 - rms(&after) / rms(before),
            taken: taken(before, &after),
            evidence: encompassing(
                (std::slice::from_ref(before), &[after]),
                None,
                bench.samples(),
            ),
            train,
            validation,
            over: self.over.clone(),
            curves: self.curves.clone(),
            ..*self
        }
    }
}

/// RMS of what a correction takes over that of what it leaves.
fn taken(before: &[f64], after: &[f64]) -> f64 {
    let squares = rms(before).powi(2) - rms(after).powi(2);
    squares.max(0.0).sqrt() / rms(after)
}

/// Smooth models of what a fit leaves, one per channel of a joint.
pub fn of_all(bench: &Bench<'_>, refit: &Refit) -> Vec<Smooth> {
    let recordings = [Split::Train, Split::Validation].map(|split| bench.recordings(split));
    let model = &refit.model;
    let series = [0, 1].map(|k| Series::of(model, &refit.values, &[], &recordings[k]));
    let mut all = Vec::new();
    for (c, channel) in model.channels().iter().enumerate() {
        let Some(joint) = channel.joint.filter(|_| channel.active) else {
            continue;
        };
        let regimes =
            [0, 1].map(|k| Regimes::of(model, (joint, &series[k].predicted), &recordings[k]));
        let noise = bench.noise.as_ref().map_or(0.0, |noise| noise[c]);
        let residuals = [&refit.train[c][..], &refit.validation[c]];
        if let Some(smooth) = best(&regimes, residuals, (noise, bench.samples())) {
            all.push(Smooth {
                channel: c,
                ..smooth
            });
        }
    }
    all
}

/// The model over the first variables, or the one with the least held-out error among those with one variable more.
fn best(
    regimes: &[Regimes; 2],
    residuals: [&[f64]; 2],
    (noise, samples): (f64, Samples),
) -> Option<Smooth> {
    let [train, held_out] = [0, 1].map(|k| (&regimes[k], residuals[k]));
    let first: Vec<usize> = (0..VARIABLES).collect();
    let plain = one(train, held_out, (&first, samples))?;
    let left = rms(held_out.1) * (1.0 - plain.relief);
    if left * left <= MUCH * noise * noise {
        return Some(plain);
    }
    let count = regimes[0].variables.len();
    let more = (VARIABLES..count).filter_map(|extra| {
        let variables = [&first[..], &[extra]].concat();
        one(train, held_out, (&variables, samples))
    });
    let all = std::iter::once(plain).chain(more);
    let mut best = all.max_by(|a, b| a.relief.total_cmp(&b.relief))?;
    best.tried = count - VARIABLES + 1;
    Some(best)
}

fn one(
    train: (&Regimes, &[f64]),
    held_out: (&Regimes, &[f64]),
    (variables, samples): (&[usize], Samples),
) -> Option<Smooth> {
    let of_train = train.0.of_some(variables);
    let knots: Vec<Vec<f64>> = of_train
        .variables
        .iter()
        .map(|v| knots(&v.values))
        .collect();
    let design = design(&of_train, &knots);
    let factors = ridge(&design, train.1)?;
    let fitted = &design * &factors;
    let curves = Curves {
        variables: variables.to_vec(),
        knots,
        factors,
    };
    let validation = curves.at(held_out.0);
    let pairs = held_out.1.iter().zip(&validation);
    let after: Vec<f64> = pairs.map(|(e, f)| e - f).collect();
    Some(Smooth {
        channel: 0,
        over: of_train.variables.iter().map(|v| v.name.clone()).collect(),
        tried: 1,
        relief: 1.0 - rms(&after) / rms(held_out.1),
        taken: taken(held_out.1, &after),
        evidence: encompassing((&[held_out.1.to_vec()], &[after]), None, samples),
        train: fitted.as_slice().to_vec(),
        validation,
        curves,
    })
}

fn knots(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    let mut knots: Vec<f64> = (0..KNOTS)
        .map(|k| sorted.get(k * last / (KNOTS - 1)).copied().unwrap_or(0.0))
        .collect();
    knots.dedup();
    knots
}

/// Hat functions at all rows; outside the knots the outermost hats are 1.
fn design(regimes: &Regimes, knots: &[Vec<f64>]) -> DMatrix<f64> {
    let rows = regimes.direction.len();
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for (variable, knots) in regimes.variables.iter().zip(knots) {
        for k in 0..knots.len() {
            let hat = DVector::from_fn(rows, |row, _| hat(knots, k, variable.values[row]));
            if variable.by_direction {
                let turned = DVector::from_fn(rows, |row, _| hat[row] * regimes.direction[row]);
                columns.push(turned);
            }
            columns.push(hat);
        }
    }
    DMatrix::from_columns(&columns)
}

fn hat(knots: &[f64], k: usize, x: f64) -> f64 {
    let x = x.clamp(knots[0], knots[knots.len() - 1]);
    if k > 0 && x < knots[k] {
        return ((x - knots[k - 1]) / (knots[k] - knots[k - 1])).max(0.0);
    }
    if k + 1 < knots.len() && x > knots[k] {
        return ((knots[k + 1] - x) / (knots[k + 1] - knots[k])).max(0.0);
    }
    1.0
}

/// `min ‖D x − e‖² + λ ‖x‖²`.
fn ridge(design: &DMatrix<f64>, residual: &[f64]) -> Option<DVector<f64>> {
    let count = design.ncols();
    let weight = (RIDGE * design.norm_squared() / count as f64).sqrt();
    let right = DVector::from_column_slice(residual);
    let mut factor = Triangular::of_system(design, &right);
    let mut rows = DMatrix::zeros(count, count + 1);
    for k in 0..count {
        rows[(k, k)] = weight;
    }
    factor.absorb(rows.as_slice());
    let system = factor.system()?;
    system.matrix.solve_upper_triangular(&system.right)
}
