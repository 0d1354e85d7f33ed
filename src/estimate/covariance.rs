//! Covariance of the estimate when the residuals are coloured and correlated across channels:
//!
//! `C = A⁻¹ (M + PᵀP) A⁻¹`,   `A = XᵀX + PᵀP`,   `M = Σ_f X(f)ᴴ S(f) X(f)`
//!
//! with the weighted derivatives X, the prior's rows P and the spectral matrix S(f) of the weighted
//! residuals: the sandwich of Newey and West (1987) with a smoothed spectrum in place of a truncated
//! autocovariance (Robinson 1983). Residuals are smaller than noise where the fit follows it; their power
//! is divided by 1 − h(f), h the leverage `diag(X(f) A⁻¹ X(f)ᴴ)`, smoothed alike.

use crate::chain::dataset::Prepared;
use crate::estimate::noise::ResidualSeries;
use crate::estimate::problem::FitProblem;
use crate::estimate::rows::{Task, visit};
use crate::estimate::spectrum::{SEGMENT, Spectrum, Transform};
use crate::linalg::triangular::Triangular;
use nalgebra::{Complex, DMatrix, DVector};
use rayon::prelude::*;

/// Share of a column that is left where those before it are taken out, below which it is one of them.
const DEPENDENT: f64 = 1e-11;

/// Covariance of the unknowns at the optimum x; infinite variance of those that the derivatives do not determine
/// there, such as the shape of a law whose size has gone to zero.
pub fn of_unknowns(problem: &FitProblem<'_>, x: &DVector<f64>) -> Option<DMatrix<f64>> {
    let count = x.len();
    let whole = problem.factor(x).matrix();
    let triangular = whole.view((0, 0), (count, count)).into_owned();
    let is_open = |j: usize| {
        let own = triangular[(j, j)].abs();
        own.is_nan() || own <= DEPENDENT * triangular.column(j).norm()
    };
    let (open, kept): (Vec<usize>, Vec<usize>) = (0..count).partition(|&j| is_open(j));
    let inverse = inverse_over(&triangular, &kept)?;
    let bread = &inverse * inverse.transpose();
    let residuals = bridged(problem, problem.counted_residuals(x));
    let weighted = weigh(problem, &residuals);
    let values = problem.parameters(x);
    let mut meat = DMatrix::zeros(count, count);
    for (index, recording) in problem.recordings.iter().enumerate() {
        let part = Part {
            problem,
            values: &values,
            recording,
            index,
            residuals: &weighted[index],
        };
        meat += part.middle(&inverse);
    }
    let positions = problem.unknowns.positions();
    for (i, &p) in positions.iter().enumerate() {
        for (j, &q) in positions.iter().enumerate() {
            let rows = problem.prior.rows();
            meat[(i, j)] += rows.column(p).dot(&rows.column(q));
        }
    }
    let covariance = &bread * meat * &bread;
    let mut covariance = (&covariance + covariance.transpose()) * 0.5;
    for j in open {
        covariance[(j, j)] = f64::INFINITY;
    }
    Some(covariance)
}

/// R⁻¹ over some columns, with rows of zeros for the others.
fn inverse_over(triangular: &DMatrix<f64>, kept: &[usize]) -> Option<DMatrix<f64>> {
    let own = Triangular::of(&triangular.select_columns(kept)).matrix();
    let identity = DMatrix::identity(kept.len(), kept.len());
    let inverse = own.solve_upper_triangular(&identity)?;
    let mut whole = DMatrix::zeros(triangular.ncols(), kept.len());
    for (row, &j) in kept.iter().enumerate() {
        whole.row_mut(j).copy_from(&inverse.row(row));
    }
    Some(whole)
}

/// The residuals with straight lines over rows that a mask leaves out: a spectrum of zeros in their place would be
/// that of an error which ends at every gap.
fn bridged(problem: &FitProblem<'_>, mut residuals: ResidualSeries) -> ResidualSeries {
    for (recording, channels) in problem.recordings.iter().zip(&mut residuals) {
        let kept: Vec<usize> = (0..recording.rows())
            .filter(|&r| recording.counts(r))
            .collect();
        if kept.is_empty() || kept.len() == recording.rows() {
            continue;
        }
        for series in channels.iter_mut().filter(|s| !s.is_empty()) {
            for pair in kept.windows(2) {
                let (from, to) = (series[pair[0]], series[pair[1]]);
                for row in pair[0] + 1..pair[1] {
                    let share = (row - pair[0]) as f64 / (pair[1] - pair[0]) as f64;
                    series[row] = from + share * (to - from);
                }
            }
        }
    }
    residuals
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

/// One recording of the fit.
struct Part<'a> {
    problem: &'a FitProblem<'a>,
    values: &'a DVector<f64>,
    recording: &'a Prepared,
    index: usize,
    residuals: &'a [Vec<f64>],
}

impl Part<'_> {
    /// `Σ_f X(f)ᴴ S(f) X(f)`; `inverse` is R⁻¹ with `A = RᵀR`.
    fn middle(&self, inverse: &DMatrix<f64>) -> DMatrix<f64> {
        let rows = self.recording.rows();
        let length = rows.min(SEGMENT);
        let transform = Transform::new(length);
        let starts: Vec<usize> = (0..rows).step_by(length).collect();
        let channels = self.residuals.len();
        let frequencies = transform.frequencies() * starts.len();
        let mut spectrum = Spectrum::new(frequencies, channels);
        let leverages: Vec<Vec<Vec<f64>>> = starts
            .par_iter()
            .map(|&start| self.leverage(&transform, start, inverse))
            .collect();
        for (&start, leverage) in starts.iter().zip(&leverages) {
            let end = rows.min(start + length);
            let transformed: Vec<Vec<Complex<f64>>> = self
                .residuals
                .iter()
                .map(|e| transform.of(&e[start..end]))
                .collect();
            for f in 0..transform.frequencies() {
                let e: Vec<Complex<f64>> = transformed.iter().map(|series| series[f]).collect();
                let cell = spectrum.cell(f as f64 / transform.frequencies() as f64);
                spectrum.add(cell, transform.multiplicity(f), (&e, &leverage[f]));
            }
        }
        let cells = (0..transform.frequencies())
            .map(|f| spectrum.cell(f as f64 / transform.frequencies() as f64))
            .collect::<Vec<_>>();
        let roots = spectrum.roots();
        let parts: Vec<DMatrix<f64>> = starts
            .par_iter()
            .map(|&start| self.shaped_gram(&transform, start, (&cells, &roots)))
            .collect();
        let count = inverse.nrows();
        parts
            .iter()
            .fold(DMatrix::zeros(count, count), |sum, part| sum + part)
    }

    /// Weighted columns of a segment, transformed: `[channel][column][frequency]`, empty where absent.
    fn columns(&self, transform: &Transform, start: usize) -> Vec<Vec<Vec<Complex<f64>>>> {
        let problem = self.problem;
        let positions = problem.unknowns.positions();
        let weights = problem.weights.matrix();
        let channels = weights.nrows();
        let end = self.recording.rows().min(start + SEGMENT);
        let mut series = vec![vec![Vec::new(); positions.len()]; channels];
        let task = Task {
            recording: self.recording,
            range: start..end,
        };
        visit(problem.model, self.values, &positions, &task, |block| {
            let counts = block.counting();
            let at = block.start() - start;
            for i in 0..channels {
                for j in (0..channels).filter(|&j| weights[(i, j)] != 0.0) {
                    if !problem.model.channels()[j].active {
                        continue;
                    }
                    let factors = problem.factors.as_ref().map(|f| &f[self.index][j]);
                    for (k, column) in series[i].iter_mut().enumerate() {
                        let Some(derivative) = block.derivative(j, k) else {
                            continue;
                        };
                        column.resize(end - start, 0.0);
                        for (row, x) in derivative.iter().enumerate() {
                            let counted = counts.as_ref().is_none_or(|c| c[row]);
                            let factor = factors.map_or(1.0, |f| f[block.start() + row]);
                            if counted {
                                column[at + row] += weights[(i, j)] * factor * x;
                            }
                        }
                    }
                }
            }
        });
        let transformed = |columns: Vec<Vec<f64>>| {
            let one = |column: Vec<f64>| {
                if column.is_empty() {
                    Vec::new()
                } else {
                    transform.of(&column)
                }
            };
            columns.into_iter().map(one).collect()
        };
        series.into_iter().map(transformed).collect()
    }

    /// `diag(X(f) A⁻¹ X(f)ᴴ)` per frequency and channel.
    fn leverage(
        &self,
        transform: &Transform,
        start: usize,
        inverse: &DMatrix<f64>,
    ) -> Vec<Vec<f64>> {
        let columns = self.columns(transform, start);
        let (frequencies, count) = (transform.frequencies(), inverse.nrows());
        let mut leverage = vec![vec![0.0; columns.len()]; frequencies];
        for (c, channel) in columns.iter().enumerate() {
            let present: Vec<usize> = (0..count).filter(|&k| !channel[k].is_empty()).collect();
            // Rows: real and imaginary part of every frequency; X R⁻¹ row by row.
            let mut rows = DMatrix::zeros(2 * frequencies, count);
            for &k in &present {
                for (f, z) in channel[k].iter().enumerate() {
                    rows[(2 * f, k)] = z.re;
                    rows[(2 * f + 1, k)] = z.im;
                }
            }
            let projected = rows * inverse;
            for (f, row) in leverage.iter_mut().enumerate() {
                row[c] = projected.rows(2 * f, 2).norm_squared();
            }
        }
        leverage
    }

    /// `Σ_f ‖L(f)ᴴ X(f)‖²` of one segment.
    fn shaped_gram(
        &self,
        transform: &Transform,
        start: usize,
        (cells, roots): (&[usize], &[DMatrix<Complex<f64>>]),
    ) -> DMatrix<f64> {
        let columns = self.columns(transform, start);
        let (channels, count) = (columns.len(), columns.first().map_or(0, Vec::len));
        let frequencies = transform.frequencies();
        let mut rows = DMatrix::zeros(2 * frequencies * channels, count);
        for k in 0..count {
            for (j, channel) in columns.iter().enumerate() {
                if channel[k].is_empty() {
                    continue;
                }
                for (f, x) in channel[k].iter().enumerate() {
                    let root = &roots[cells[f]];
                    let weight = transform.multiplicity(f).sqrt();
                    // L is lower triangular: row j of X meets columns i <= j of conj(L).
                    for i in 0..=j {
                        let shaped = root[(j, i)].conj() * x * Complex::new(weight, 0.0);
                        let at = 2 * (f * channels + i);
                        rows[(at, k)] += shaped.re;
                        rows[(at + 1, k)] += shaped.im;
                    }
                }
            }
        }
        rows.tr_mul(&rows)
    }
}
