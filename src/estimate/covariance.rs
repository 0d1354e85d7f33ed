//! Covariance of the estimate when the residuals are coloured and correlated across channels:
//!
//! `C = A⁻¹ (Σ_kl X_kᵀ Γ_{k−l} X_l + PᵀP) A⁻¹`,   `A = XᵀX + PᵀP`
//!
//! with the weighted derivatives X, the prior's rows P and the autocovariance Γ of the weighted residuals.
//! Γ is that of an autoregression per channel whose innovations are correlated across channels, so the
//! middle is `Σ_k X̃_kᵀ S X̃_k` with X̃ the columns filtered by 1/A(z) and S the covariance of the
//! innovations (the sandwich of Newey and West 1987 with a parametric spectrum, as den Haan and Levin 1997).

use crate::estimate::noise::{ResidualSeries, colour};
use crate::estimate::problem::FitProblem;
use crate::estimate::rows::{Task, visit};
use crate::stats::autoregression::Autoregression;
use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

/// Covariance of the unknowns at the optimum x, from the residuals there.
///
/// `None` where the derivatives do not determine all unknowns.
pub fn of_unknowns(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
    residuals: &ResidualSeries,
) -> Option<DMatrix<f64>> {
    let count = x.len();
    let whole = problem.factor(x).matrix();
    let triangular = whole.view((0, 0), (count, count)).into_owned();
    let inverse = triangular.solve_upper_triangular(&DMatrix::identity(count, count))?;
    let bread = &inverse * inverse.transpose();
    let weighted = weigh(problem, residuals);
    let channels = weighted.first().map_or(0, Vec::len);
    let colours = colour(&weighted, channels);
    let innovations = innovation_covariance(&colours, &weighted, count);
    let values = problem.parameters(x);
    let middles: Vec<DMatrix<f64>> = (0..problem.recordings.len())
        .into_par_iter()
        .map(|recording| middle(problem, &values, (recording, &colours, &innovations)))
        .collect();
    let mut meat = DMatrix::zeros(count, count);
    for part in middles {
        meat += part;
    }
    for i in 0..count {
        for j in 0..count {
            let (p, q) = (problem.unknowns.positions()[i], problem.unknowns.positions()[j]);
            meat[(i, j)] += problem.prior.rows().column(p).dot(&problem.prior.rows().column(q));
        }
    }
    let covariance = &bread * meat * &bread;
    Some((&covariance + covariance.transpose()) * 0.5)
}

/// The residuals times W and the factors of single rows.
fn weigh(problem: &FitProblem<'_>, residuals: &ResidualSeries) -> ResidualSeries {
    let weights = problem.weights.matrix();
    let channels = weights.nrows();
    let of = |(recording, series): (usize, &Vec<Vec<f64>>)| {
        let rows = series.first().map_or(0, Vec::len);
        let mut out = vec![vec![0.0; rows]; channels];
        for i in 0..channels {
            for j in (0..channels).filter(|&j| weights[(i, j)] != 0.0) {
                let factors = problem.factors.as_ref().map(|f| &f[recording][j]);
                for row in 0..rows {
                    let factor = factors.map_or(1.0, |f| f[row]);
                    out[i][row] += weights[(i, j)] * factor * series[j][row];
                }
            }
        }
        out
    };
    residuals.iter().enumerate().map(of).collect()
}

/// Covariance of the innovations across channels, corrected for the unknowns that the fit has spent.
fn innovation_covariance(
    colours: &[Autoregression],
    residuals: &ResidualSeries,
    unknowns: usize,
) -> DMatrix<f64> {
    let channels = colours.len();
    let mut sum = DMatrix::zeros(channels, channels);
    let mut rows = 0;
    for series in residuals {
        let white: Vec<Vec<f64>> = (0..channels).map(|c| colours[c].whiten(&series[c])).collect();
        rows += series.first().map_or(0, Vec::len);
        for i in 0..channels {
            for j in 0..channels {
                let products = white[i].iter().zip(&white[j]).map(|(a, b)| a * b);
                sum[(i, j)] += products.sum::<f64>();
            }
        }
    }
    let total = (rows * channels) as f64;
    let spent = total / (total - unknowns as f64).max(1.0);
    sum * (spent / (rows as f64).max(1.0))
}

/// `Σ_k X̃_kᵀ S X̃_k` of one recording.
fn middle(
    problem: &FitProblem<'_>,
    values: &DVector<f64>,
    (index, colours, innovations): (usize, &[Autoregression], &DMatrix<f64>),
) -> DMatrix<f64> {
    let recording = problem.recordings[index];
    let columns = problem.unknowns.positions();
    let (count, channels) = (columns.len(), colours.len());
    let weights = problem.weights.matrix();
    let task = Task {
        recording,
        range: 0..recording.rows(),
    };
    let mut filters: Vec<Shaping> = (0..channels * count)
        .map(|k| Shaping::new(&colours[k / count]))
        .collect();
    // X̃ᵀ S X̃ = ‖root ᵀ X̃‖²; the root of a covariance that is not definite is that of its diagonal.
    let root = match Cholesky::new(innovations.clone()) {
        Some(factor) => factor.l(),
        None => DMatrix::from_diagonal(&innovations.diagonal().map(f64::sqrt)),
    };
    let mut sum = DMatrix::zeros(count, count);
    visit(problem.model, values, &columns, &task, |block| {
        let rows = block.range.len();
        let counts = block.counting();
        let mut shaped = DMatrix::zeros(rows * channels, count);
        for i in 0..channels {
            for j in (0..channels).filter(|&j| weights[(i, j)] != 0.0) {
                if !problem.model.channels()[j].active {
                    continue;
                }
                let factors = problem.factors.as_ref().map(|f| &f[index][j]);
                for k in 0..count {
                    let Some(series) = block.derivative(j, k) else { continue };
                    for row in 0..rows {
                        let factor = factors.map_or(1.0, |f| f[block.start() + row]);
                        shaped[(row * channels + i, k)] += weights[(i, j)] * factor * series[row];
                    }
                }
            }
        }
        for k in 0..count {
            for i in 0..channels {
                for row in 0..rows {
                    let value = &mut shaped[(row * channels + i, k)];
                    if counts.as_ref().is_some_and(|c| !c[row]) {
                        *value = 0.0;
                    }
                    *value = filters[i * count + k].next(*value);
                }
            }
        }
        for row in 0..rows {
            let mut sample = shaped.rows_mut(row * channels, channels);
            let mixed = root.tr_mul(&sample);
            sample.copy_from(&mixed);
        }
        sum += shaped.tr_mul(&shaped);
    });
    sum
}

/// The filter 1/A(z), sample by sample.
struct Shaping<'a> {
    coefficients: &'a [f64],
    /// The last outputs, newest first.
    past: Vec<f64>,
}

impl<'a> Shaping<'a> {
    fn new(colour: &'a Autoregression) -> Self {
        Self {
            coefficients: &colour.coefficients,
            past: vec![0.0; colour.coefficients.len()],
        }
    }

    fn next(&mut self, input: f64) -> f64 {
        let fed_back: f64 = self.coefficients.iter().zip(&self.past).map(|(a, y)| a * y).sum();
        let output = input + fed_back;
        if let Some(last) = self.past.last_mut() {
            *last = output;
            self.past.rotate_right(1);
        }
        output
    }
}
