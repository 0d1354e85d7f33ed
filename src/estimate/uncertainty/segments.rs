//! Segments of recordings in the frequencies of their noise: `M` of the sandwich, `uᵀ M u`, and leverages.

use crate::chain::dataset::Prepared;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::residual::rows::{Task, visit_errors};
use crate::estimate::uncertainty::coloured_noise::ColouredNoise;
use crate::estimate::uncertainty::counted_residuals::{CountedResiduals, row_factors};
use crate::estimate::uncertainty::cross_spectra::MaskedResiduals;
use crate::estimate::uncertainty::spectrum::{Power, SEGMENT, Spectrum, Transform};
use nalgebra::{Complex, DMatrix, DVector};
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;

/// Leverage of all unknowns together over the power of one band of frequencies, below which it is not computed: the
/// variances are then off by less than this share even if one band of one channel had it all.
const NEGLIGIBLE: f64 = 0.02;

/// Bands of frequency that leverage is held against.
const BANDS: f64 = 128.0;

/// Derivatives before the weights of the channels: `[channel][column][row]`, empty where absent.
type Columns = Vec<Vec<Vec<f64>>>;

/// A recording that is one segment.
#[derive(Debug, Clone)]
pub(super) struct WholeSegment {
    columns: Columns,
    /// h(f), `[frequency][channel]`.
    leverage: Vec<Vec<f64>>,
}

/// One recording of the fit.
pub(super) struct Part<'a> {
    pub problem: &'a FitProblem<'a>,
    /// Its number.
    pub index: usize,
    /// Values of all parameters.
    pub values: &'a DVector<f64>,
    /// R⁻¹ over the unknowns that the derivatives determine.
    pub inverse: &'a DMatrix<f64>,
    /// What is known of it, where it is one segment.
    pub whole: Option<&'a WholeSegment>,
}

/// The noise of the segments of a recording.
pub(super) struct SegmentNoise {
    transform: Transform,
    /// `Lᴴ A⁻ᴴ WᵀW` at every frequency.
    mixing: Vec<DMatrix<Complex<f64>>>,
}

impl<'a> Part<'a> {
    /// Derivatives of all rows and their leverage; `None` where they are several segments.
    pub fn whole_segment(&self) -> Option<WholeSegment> {
        let length = self.recording().rows();
        (segment_length(self.recording()) == length).then(|| {
            let columns = self.columns(0..length).into_owned();
            let leverage = self.leverage(&Transform::new(length), &columns);
            WholeSegment { columns, leverage }
        })
    }

    fn recording(&self) -> &'a Prepared {
        self.problem.recordings[self.index]
    }

    fn segments(&self) -> Vec<Range<usize>> {
        let (rows, length) = (self.recording().rows(), segment_length(self.recording()));
        let starts = (0..rows).step_by(length);
        starts
            .map(|start| start..rows.min(start + length))
            .collect()
    }

    /// The noise of its residuals.
    pub fn noise(&self, counted: &CountedResiduals, colour: &ColouredNoise) -> SegmentNoise {
        let segments = self.segments();
        let length = segment_length(self.recording());
        let cyclic = self.recording().segment().cyclic && segments.len() == 1;
        let innovations = counted.innovations(colour, cyclic);
        let spectrum = self.spectrum(&innovations, &segments);
        // What a residual owes to an innovation before its segment, or at its end to one of its beginning.
        let tail = match cyclic {
            true => 0,
            false => colour.memory(length),
        };
        let transform = Transform::new(length + tail);
        let mixing = self.mixing(&transform, &spectrum, colour);
        SegmentNoise { transform, mixing }
    }

    /// `M` of this recording.
    pub fn middle(&self, noise: &SegmentNoise) -> DMatrix<f64> {
        let segments = self.segments();
        let parts: Vec<DMatrix<f64>> = segments
            .into_par_iter()
            .map(|rows| gram(&self.mixed(&noise.transform, &self.columns(rows), &noise.mixing)))
            .collect();
        let count = self.inverse.nrows();
        parts
            .iter()
            .fold(DMatrix::zeros(count, count), |sum, part| sum + part)
    }

    /// `uᵀ M u` of this recording.
    pub fn variance(&self, noise: &SegmentNoise, u: &DVector<f64>) -> f64 {
        let of = |rows| {
            let along = along(&self.columns(rows), u);
            self.mixed(&noise.transform, &along, &noise.mixing)
                .norm_squared()
        };
        self.segments().into_iter().map(of).sum()
    }

    /// Spectrum of the innovations of the residuals.
    fn spectrum(&self, innovations: &CountedResiduals, segments: &[Range<usize>]) -> Spectrum {
        let transform = Transform::new(segment_length(self.recording()));
        let channels = innovations.residuals.len();
        let taken = self.inverse.nrows() as f64 * BANDS;
        let is_taken = taken / self.recording().rows().max(1) as f64 > NEGLIGIBLE;
        let of_segment = |rows: &Range<usize>| -> Vec<Power> {
            let leverage = is_taken.then(|| match self.whole {
                Some(whole) => Cow::Borrowed(&whole.leverage),
                None => Cow::Owned(self.leverage(&transform, &self.columns(rows.clone()))),
            });
            let powers = powers(innovations, &transform, rows.clone())
                .into_iter()
                .enumerate();
            let last = (transform.frequencies() - 1).max(1) as f64;
            let power = |(f, matrix): (usize, DMatrix<Complex<f64>>)| Power {
                place: f as f64 / last,
                weight: transform.multiplicity(f),
                matrix,
                leverage: leverage
                    .as_ref()
                    .map_or_else(|| vec![0.0; channels], |l| l[f].clone()),
            };
            powers.map(power).collect()
        };
        let all: Vec<Vec<Power>> = segments.par_iter().map(of_segment).collect();
        Spectrum::of(all.into_iter().flatten().collect())
    }

    /// `Lᴴ A⁻ᴴ WᵀW` at every frequency, with `S = L Lᴴ`.
    fn mixing(
        &self,
        transform: &Transform,
        spectrum: &Spectrum,
        colour: &ColouredNoise,
    ) -> Vec<DMatrix<Complex<f64>>> {
        let weights = self.problem.weights().matrix();
        let squared = (weights.transpose() * &weights).map(|w| Complex::new(w, 0.0));
        let cells = spectrum.cells_of(transform.frequencies());
        let whole: Vec<_> = spectrum.roots().iter().map(|root| root.adjoint()).collect();
        let mut mixing = Vec::with_capacity(transform.frequencies());
        for (cell, root) in cells.into_iter().zip(&whole) {
            for f in cell {
                let mut own = root.clone();
                if !colour.is_white() {
                    let frequency = f as f64 / transform.length() as f64;
                    for c in 0..own.ncols() {
                        let shaped = colour.response(c, frequency).conj().inv();
                        own.column_mut(c).iter_mut().for_each(|x| *x *= shaped);
                    }
                }
                mixing.push(own * &squared);
            }
        }
        mixing
    }

    /// Derivatives of some rows.
    fn columns(&self, rows: Range<usize>) -> Cow<'a, Columns> {
        match self.whole {
            Some(whole) => Cow::Borrowed(&whole.columns),
            None => Cow::Owned(columns(self.problem, self.values, self.index, rows)),
        }
    }

    /// `B(f) D(f)` of a segment with a matrix B for every frequency, times the root of how often a
    /// frequency counts: real parts of all frequencies of the first channel, imaginary parts, then the next channel's.
    fn mixed(
        &self,
        transform: &Transform,
        columns: &Columns,
        mixing: &[DMatrix<Complex<f64>>],
    ) -> DMatrix<f64> {
        let (channels, count) = (columns.len(), columns.first().map_or(0, Vec::len));
        let frequencies = transform.frequencies();
        let mut mixed = DMatrix::zeros(2 * frequencies * channels, count);
        let empty = |i: usize, j: usize| mixing.iter().all(|b| b[(i, j)] == Complex::new(0.0, 0.0));
        for (j, channel) in columns.iter().enumerate() {
            let into: Vec<usize> = (0..channels).filter(|&i| !empty(i, j)).collect();
            for (k, series) in channel.iter().enumerate().filter(|(_, s)| !s.is_empty()) {
                let mut x = transform.of(series);
                for (f, x) in x.iter_mut().enumerate() {
                    *x *= Complex::new(transform.multiplicity(f).sqrt(), 0.0);
                }
                let mut column = mixed.column_mut(k);
                let all = column.as_mut_slice();
                for &i in &into {
                    let parts = &mut all[2 * frequencies * i..][..2 * frequencies];
                    let (real, imaginary) = parts.split_at_mut(frequencies);
                    let to = real.iter_mut().zip(imaginary);
                    for ((re, im), (x, b)) in to.zip(x.iter().zip(mixing)) {
                        let product = b[(i, j)] * x;
                        *re += product.re;
                        *im += product.im;
                    }
                }
            }
        }
        mixed
    }

    /// `diag(X(f) B X(f)ᴴ)` of the weighted columns per frequency and channel.
    fn leverage(&self, transform: &Transform, columns: &Columns) -> Vec<Vec<f64>> {
        let weights = self
            .problem
            .weights()
            .matrix()
            .map(|w| Complex::new(w, 0.0));
        let weights = vec![weights; transform.frequencies()];
        let projected = self.mixed(transform, columns, &weights) * self.inverse;
        let frequencies = transform.frequencies();
        let squares = |f: usize, c: usize| {
            let real = projected.row(2 * frequencies * c + f).norm_squared();
            let imaginary = projected
                .row(2 * frequencies * c + frequencies + f)
                .norm_squared();
            (real + imaginary) / transform.multiplicity(f)
        };
        // Of the power in rows that count: gaps have none.
        let share = |channel: usize| {
            let factors = row_factors(self.problem, self.index, channel);
            let kept = factors.iter().filter(|f| **f != 0.0).count().max(1);
            factors.len() as f64 / kept as f64
        };
        let shares: Vec<f64> = (0..columns.len()).map(share).collect();
        let of = |f: usize| {
            let shares = shares.iter().enumerate();
            shares.map(|(c, share)| share * squares(f, c)).collect()
        };
        (0..frequencies).map(of).collect()
    }
}

/// Rows of the segments of a recording, of one length: zeros behind a shorter one would pass for residuals.
fn segment_length(recording: &Prepared) -> usize {
    let rows = recording.rows();
    rows.div_ceil(rows.div_ceil(SEGMENT).max(1)).max(1)
}

/// The sum of some columns times factors, as one column.
fn along(columns: &Columns, factors: &DVector<f64>) -> Columns {
    let of_channel = |columns: &Vec<Vec<f64>>| {
        let rows = columns.iter().map(Vec::len).max().unwrap_or(0);
        let mut sum = vec![0.0; rows];
        for (column, factor) in columns.iter().zip(factors.iter()) {
            sum.iter_mut()
                .zip(column)
                .for_each(|(to, x)| *to += factor * x);
        }
        vec![sum]
    };
    columns.iter().map(of_channel).collect()
}

/// Columns of a segment of a recording.
fn columns(
    problem: &FitProblem<'_>,
    values: &DVector<f64>,
    index: usize,
    rows: Range<usize>,
) -> Columns {
    let (start, end) = (rows.start, rows.end);
    let recording = problem.recordings[index];
    let positions = problem.unknowns.positions();
    let channels = problem.model.channels();
    let mut series = vec![vec![Vec::new(); positions.len()]; channels.len()];
    let task = Task {
        recording,
        range: start..end,
        bodies: None,
    };
    visit_errors(problem.model, values, &positions, &task, |block| {
        let counts = block.counting();
        let at = block.start() - start;
        for (j, columns) in series.iter_mut().enumerate() {
            if !channels[j].active {
                continue;
            }
            let factors = problem.factors.as_ref().map(|f| &f[index][j]);
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

/// Power of the series of a segment at every frequency.
fn powers(
    series: &CountedResiduals,
    transform: &Transform,
    rows: Range<usize>,
) -> Vec<DMatrix<Complex<f64>>> {
    let part = |series: &Vec<f64>| series[rows.clone()].to_vec();
    let residuals: Vec<Vec<f64>> = series.residuals.iter().map(part).collect();
    let counts = series.counts.iter();
    let counts: Vec<Vec<bool>> = counts.map(|series| series[rows.clone()].to_vec()).collect();
    if counts.iter().flatten().all(|counts| *counts) {
        let spectra: Vec<_> = residuals.iter().map(|e| transform.of(e)).collect();
        let at = |f: usize| DVector::from_fn(spectra.len(), |c, _| spectra[c][f]);
        let periodogram = |e: DVector<Complex<f64>>| &e * e.adjoint();
        let frequencies = 0..transform.frequencies();
        return frequencies.map(|f| periodogram(at(f))).collect();
    }
    let gapped = MaskedResiduals {
        residuals: &residuals,
        counts: &counts,
    };
    gapped.powers(transform)
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
