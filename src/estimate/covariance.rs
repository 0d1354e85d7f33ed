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
    let weights = problem.weights().matrix();
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
            let end = rows.min(start + length);
            let transformed: Vec<Vec<Complex<f64>>> = self
                .residuals
                .iter()
                .map(|e| transform.of(&e[start..end]))
                .collect();
            for (cell, range) in cells.iter().enumerate() {
                for f in range.clone() {
                    let e: Vec<Complex<f64>> = transformed.iter().map(|series| series[f]).collect();
                    let leverage = leverage.as_ref().map_or(&none, |l| &l[f]);
                    spectrum.add(cell, transform.multiplicity(f), (&e, leverage));
                }
            }
        }
        let weights = self
            .problem
            .weights()
            .matrix()
            .map(|w| Complex::new(w, 0.0));
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

    /// Columns of a segment before the weights of the channels: `[channel][column][row]`, empty where absent.
    fn columns(&self, start: usize) -> Vec<Vec<Vec<f64>>> {
        let problem = self.problem;
        let positions = problem.unknowns.positions();
        let channels = problem.model.channels();
        let end = self.recording.rows().min(start + SEGMENT);
        let mut series = vec![vec![Vec::new(); positions.len()]; channels.len()];
        let task = Task {
            recording: self.recording,
            range: start..end,
            bodies: None,
        };
        visit(problem.model, self.values, &positions, &task, |block| {
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
        let columns = self.columns(start);
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
        let weights = self
            .problem
            .weights()
            .matrix()
            .map(|w| Complex::new(w, 0.0));
        let projected =
            self.mixed(transform, (start, cells), &vec![weights; cells.len()]) * inverse;
        let frequencies = transform.frequencies();
        let squares = |f: usize, c: usize| {
            let real = projected.row(2 * frequencies * c + f).norm_squared();
            let imaginary = projected
                .row(2 * frequencies * c + frequencies + f)
                .norm_squared();
            (real + imaginary) / transform.multiplicity(f)
        };
        let channels = self.residuals.len();
        (0..frequencies)
            .map(|f| (0..channels).map(|c| squares(f, c)).collect())
            .collect()
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
