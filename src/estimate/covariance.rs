//! Covariance of the estimate when the residuals are coloured and correlated across channels:
//!
//! `C = A⁻¹ (M + PᵀP) A⁻¹`,   `A = XᵀX + PᵀP`,   `M = Σ_f X(f)ᴴ S(f) X(f)`
//!
//! with the weighted derivatives X, the prior's rows P and the spectral matrix S(f) of the weighted
//! residuals: the sandwich of Newey and West (1987) with a smoothed spectrum in place of a truncated
//! autocovariance (Robinson 1983). Residuals are smaller than noise where the fit follows it; their power
//! is divided by 1 − h(f), h the leverage `diag(X(f) A⁻¹ X(f)ᴴ)`, smoothed alike.

use crate::chain::dataset::Prepared;
use crate::estimate::gaps::Gapped;
use crate::estimate::problem::FitProblem;
use crate::estimate::rows::{Task, visit_errors};
use crate::estimate::spectrum::{SEGMENT, Spectrum, Transform};
use crate::linalg::triangular::Triangular;
use nalgebra::{Complex, DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// Share of a column that is left where those before it are taken out, below which it is one of them.
const DEPENDENT: f64 = 1e-11;

/// Leverage of all unknowns together over the power of one cell of frequencies, below which it is not computed: the
/// variances are then off by less than this share even if one cell of one channel had it all.
const NEGLIGIBLE: f64 = 0.02;

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
    let residuals = problem.counted_residuals(x);
    let values = problem.parameters(x);
    let mut meat = DMatrix::zeros(count, count);
    for (index, recording) in problem.recordings.iter().enumerate() {
        let part = Part {
            problem,
            values: &values,
            recording,
            index,
            counted: counted(problem, index, &residuals[index]),
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

/// Residuals times the factors of their rows, and which rows of them count: `[channel][row]`.
fn counted(problem: &FitProblem<'_>, index: usize, residuals: &[Vec<f64>]) -> Counted {
    let recording = problem.recordings[index];
    let factors = problem.factors.as_ref().map(|factors| &factors[index]);
    let mut counted = Counted::default();
    for (channel, series) in residuals.iter().enumerate() {
        let factor = |row: usize| match (recording.counts(row), factors) {
            (false, _) => 0.0,
            (true, None) => 1.0,
            (true, Some(factors)) => factors[channel][row],
        };
        let all = 0..series.len();
        let own: Vec<f64> = all.map(factor).collect();
        counted.counts.push(own.iter().map(|f| *f != 0.0).collect());
        let scaled = series.iter().zip(own).map(|(e, f)| e * f);
        counted.residuals.push(scaled.collect());
    }
    counted
}

#[derive(Default)]
struct Counted {
    residuals: Vec<Vec<f64>>,
    counts: Vec<Vec<bool>>,
}

/// One recording of the fit.
struct Part<'a> {
    problem: &'a FitProblem<'a>,
    values: &'a DVector<f64>,
    recording: &'a Prepared,
    index: usize,
    counted: Counted,
}

impl Part<'_> {
    /// `Σ_f X(f)ᴴ S(f) X(f)`; `inverse` is R⁻¹ with `A = RᵀR`.
    fn middle(&self, inverse: &DMatrix<f64>) -> DMatrix<f64> {
        let rows = self.recording.rows();
        // Segments of one length: zeros behind a shorter one would pass for residuals.
        let length = rows.div_ceil(rows.div_ceil(SEGMENT).max(1));
        let transform = Transform::new(length);
        let starts: Vec<usize> = (0..rows).step_by(length.max(1)).collect();
        let channels = self.counted.residuals.len();
        let mut spectrum = Spectrum::new(transform.frequencies() * starts.len(), channels);
        let cells = spectrum.cells_of(transform.frequencies());
        let count = inverse.nrows();
        let taken = count as f64 * spectrum.count() as f64 / rows as f64;
        let leverages: Vec<Option<Vec<Vec<f64>>>> = starts
            .par_iter()
            .map(|&start| {
                (taken > NEGLIGIBLE).then(|| self.leverage(&transform, (start, &cells), inverse))
            })
            .collect();
        let none = vec![0.0; channels];
        for (&start, leverage) in starts.iter().zip(&leverages) {
            let powers = self.powers(&transform, start..rows.min(start + length));
            for (cell, range) in cells.iter().enumerate() {
                for f in range.clone() {
                    let leverage = leverage.as_ref().map_or(&none, |l| &l[f]);
                    spectrum.add(cell, transform.multiplicity(f), (&powers[f], leverage));
                }
            }
        }
        let weights = self.weights();
        let roots = spectrum.roots();
        let mixing: Vec<_> = roots.iter().map(|root| root.adjoint() * &weights).collect();
        let parts: Vec<DMatrix<f64>> = starts
            .par_iter()
            .map(|&start| gram(&self.mixed(&transform, (start, &cells), &mixing)))
            .collect();
        parts
            .iter()
            .fold(DMatrix::zeros(count, count), |sum, part| sum + part)
    }

    fn weights(&self) -> DMatrix<Complex<f64>> {
        let weights = self.problem.weights().matrix();
        weights.map(|w| Complex::new(w, 0.0))
    }

    /// Power of the weighted residuals of a segment at every frequency.
    fn powers(&self, transform: &Transform, rows: Range<usize>) -> Vec<DMatrix<Complex<f64>>> {
        let weights = self.weights();
        let part = |series: &Vec<f64>| series[rows.clone()].to_vec();
        let residuals: Vec<Vec<f64>> = self.counted.residuals.iter().map(part).collect();
        let counts = self.counted.counts.iter();
        let counts: Vec<Vec<bool>> = counts.map(|series| series[rows.clone()].to_vec()).collect();
        if counts.iter().flatten().all(|counts| *counts) {
            let spectra: Vec<_> = residuals.iter().map(|e| transform.of(e)).collect();
            let at = |f: usize| &weights * DVector::from_fn(spectra.len(), |c, _| spectra[c][f]);
            let periodogram = |e: DVector<Complex<f64>>| &e * e.adjoint();
            let frequencies = 0..transform.frequencies();
            return frequencies.map(|f| periodogram(at(f))).collect();
        }
        let gapped = Gapped {
            residuals: &residuals,
            counts: &counts,
        };
        let powers = gapped.powers(transform).into_iter();
        powers.map(|p| &weights * p * weights.transpose()).collect()
    }

    /// Columns of a segment before the weights of the channels: `[channel][column][row]`, empty where absent.
    fn columns(&self, rows: Range<usize>) -> Vec<Vec<Vec<f64>>> {
        let (start, end) = (rows.start, rows.end);
        let problem = self.problem;
        let positions = problem.unknowns.positions();
        let channels = problem.model.channels();
        let mut series = vec![vec![Vec::new(); positions.len()]; channels.len()];
        let task = Task {
            recording: self.recording,
            range: start..end,
            bodies: None,
        };
        visit_errors(problem.model, self.values, &positions, &task, |block| {
            let counts = block.counting();
            let at = block.start() - start;
            for (j, columns) in series.iter_mut().enumerate() {
                if !channels[j].active {
                    continue;
                }
                let factors = problem.factors.as_ref().map(|f| &f[self.index][j]);
                for (k, column) in columns.iter_mut().enumerate() {
                    let Some(derivative) = block.derivative(j, k) else {
                        continue;
                    };
                    column.resize(end - start, 0.0);
                    let own = &mut column[at..at + derivative.len()];
                    own.copy_from_slice(derivative);
                    if let Some(factors) = factors {
                        let factors = &factors[block.start()..];
                        own.iter_mut().zip(factors).for_each(|(x, f)| *x *= f);
                    }
                    if let Some(counts) = &counts {
                        let left_out = own.iter_mut().zip(counts).filter(|(_, c)| !**c);
                        left_out.for_each(|(x, _)| *x = 0.0);
                    }
                }
            }
        });
        series
    }

    /// `B(f) X(f)` of a segment with a matrix B for every cell of frequencies, times the root of how often a
    /// frequency counts: real parts of all frequencies of the first channel, imaginary parts, then the next channel's.
    fn mixed(
        &self,
        transform: &Transform,
        (start, cells): (usize, &[Range<usize>]),
        mixing: &[DMatrix<Complex<f64>>],
    ) -> DMatrix<f64> {
        let end = self.recording.rows().min(start + transform.length());
        let columns = self.columns(start..end);
        let (channels, count) = (columns.len(), columns.first().map_or(0, Vec::len));
        let frequencies = transform.frequencies();
        let mut rows = DMatrix::zeros(2 * frequencies * channels, count);
        for (j, channel) in columns.iter().enumerate() {
            for (k, series) in channel.iter().enumerate().filter(|(_, s)| !s.is_empty()) {
                let mut x = transform.of(series);
                for (f, x) in x.iter_mut().enumerate() {
                    *x *= Complex::new(transform.multiplicity(f).sqrt(), 0.0);
                }
                let mut column = rows.column_mut(k);
                let parts = column.as_mut_slice().chunks_exact_mut(2 * frequencies);
                for (i, parts) in parts.enumerate() {
                    let (real, imaginary) = parts.split_at_mut(frequencies);
                    for (range, b) in cells.iter().zip(mixing) {
                        let b = b[(i, j)];
                        if b == Complex::new(0.0, 0.0) {
                            continue;
                        }
                        let to = real[range.clone()]
                            .iter_mut()
                            .zip(&mut imaginary[range.clone()]);
                        for ((re, im), x) in to.zip(&x[range.clone()]) {
                            *re += b.re * x.re - b.im * x.im;
                            *im += b.re * x.im + b.im * x.re;
                        }
                    }
                }
            }
        }
        rows
    }

    /// `diag(X(f) A⁻¹ X(f)ᴴ)` of the weighted columns per frequency and channel.
    fn leverage(
        &self,
        transform: &Transform,
        (start, cells): (usize, &[Range<usize>]),
        inverse: &DMatrix<f64>,
    ) -> Vec<Vec<f64>> {
        let weights = vec![self.weights(); cells.len()];
        let projected = self.mixed(transform, (start, cells), &weights) * inverse;
        let frequencies = transform.frequencies();
        let squares = |f: usize, c: usize| {
            let real = projected.row(2 * frequencies * c + f).norm_squared();
            let imaginary = projected
                .row(2 * frequencies * c + frequencies + f)
                .norm_squared();
            (real + imaginary) / transform.multiplicity(f)
        };
        // Of the power in rows that count: gaps have none.
        let share = |counts: &Vec<bool>| {
            let kept = counts.iter().filter(|c| **c).count().max(1);
            counts.len() as f64 / kept as f64
        };
        let shares: Vec<f64> = self.counted.counts.iter().map(share).collect();
        let of = |f: usize| {
            let shares = shares.iter().enumerate();
            shares.map(|(c, share)| share * squares(f, c)).collect()
        };
        (0..frequencies).map(of).collect()
    }
}

/// `XᵀX`, some rows at a time: a product of matrices is many times faster than one of columns, and the transpose of
/// all rows would take as much memory again.
fn gram(rows: &DMatrix<f64>) -> DMatrix<f64> {
    let (length, count) = rows.shape();
    let mut product = DMatrix::zeros(count, count);
    for start in (0..length).step_by(SEGMENT) {
        let part = rows.rows(start, SEGMENT.min(length - start));
        product.gemm(1.0, &part.transpose(), &part, 1.0);
    }
    product
}
