//! Covariance of the estimate when the residuals are coloured and correlated across channels:
//!
//! ```text
//! C = B (M + PᵀP) B,   B = (XᵀX + PᵀP)⁻¹,   M = Σ_f Z(f)ᴴ A⁻¹ S(f) A⁻ᴴ Z(f),   Z = WᵀW D
//! ```
//!
//! with the weighted derivatives X = W D, the prior's rows P, the autoregressions A of the residuals and the spectral
//! matrix S(f) of their innovations, which is smoothed: the sandwich of Newey and West (1987) with a prewhitened and
//! smoothed spectrum in place of a truncated autocovariance (Andrews and Monahan 1992). Residuals are smaller than noise
//! where the fit follows it; their power is divided by 1 − h(f), h the leverage `diag(X(f) B X(f)ᴴ)`, smoothed alike.

use crate::chain::dataset::Prepared;
use crate::estimate::fit_problem::problem::{FitProblem, NoiseSource};
use crate::estimate::residual::noise::ResidualSeries;
use crate::estimate::residual::rows::{Task, visit_errors};
use crate::estimate::uncertainty::coloured_noise::{self, ColouredNoise, Innovations};
use crate::estimate::uncertainty::cross_spectra::MaskedResiduals;
use crate::estimate::uncertainty::spectrum::{Power, SEGMENT, Spectrum, Transform};
use crate::linalg::triangular::Triangular;
use nalgebra::{Complex, DMatrix, DVector};
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;

/// Share of a column that is left where those before it are taken out, below which it is one of them.
const DEPENDENT: f64 = 1e-11;

/// Leverage of all unknowns together over the power of one band of frequencies, below which it is not computed: the
/// variances are then off by less than this share even if one band of one channel had it all.
const NEGLIGIBLE: f64 = 0.02;

/// Bands of frequency that leverage is held against.
const BANDS: f64 = 128.0;

/// Covariance of the unknowns at the optimum x; infinite variance of those that the derivatives do not determine
/// there, such as the shape of a law whose size has gone to zero.
pub fn of_unknowns(problem: &FitProblem<'_>, x: &DVector<f64>) -> Option<DMatrix<f64>> {
    let sensitivity = Sensitivity::of(problem, x)?;
    let residuals = problem.counted_residuals(x);
    Some(sensitivity.under(problem, &residuals).covariance())
}

/// Derivatives before the weights of the channels: `[channel][column][row]`, empty where absent.
type Columns = Vec<Vec<Vec<f64>>>;

/// What the covariance takes from the derivatives alone, whatever the noise.
#[derive(Debug, Clone)]
pub struct Sensitivity {
    values: DVector<f64>,
    /// Unknowns that the derivatives do not determine.
    open: Vec<usize>,
    /// R⁻¹ over the others, with `XᵀX + PᵀP = RᵀR`.
    inverse: DMatrix<f64>,
    /// Of each recording, where it is one segment.
    segments: Vec<Option<WholeSegment>>,
}

/// A recording that is one segment.
#[derive(Debug, Clone)]
struct WholeSegment {
    columns: Columns,
    /// h(f), `[frequency][channel]`.
    leverage: Vec<Vec<f64>>,
}

impl Sensitivity {
    /// Of a problem at its optimum; `None` where the derivatives are not finite.
    pub fn of(problem: &FitProblem<'_>, x: &DVector<f64>) -> Option<Self> {
        let triangular = triangular(problem, x);
        let (open, kept) = open_and_kept(&triangular);
        let mut all = Self {
            values: problem.parameters(x),
            open,
            inverse: inverse_over(&triangular, &kept)?,
            segments: vec![None; problem.recordings.len()],
        };
        for (index, recording) in problem.recordings.iter().enumerate() {
            let length = recording.rows();
            if segment_length(recording) == length {
                let part = Part::new(problem, &all, index);
                let columns = part.columns(0..length).into_owned();
                let leverage = part.leverage(&Transform::new(length), &columns);
                all.segments[index] = Some(WholeSegment { columns, leverage });
            }
        }
        Some(all)
    }

    /// With residuals that are the noise, be they those of a model with more physics.
    pub fn under<'a>(
        &'a self,
        problem: &'a FitProblem<'a>,
        residuals: &ResidualSeries,
    ) -> Sandwich<'a> {
        let counted: Vec<Counted> = (0..problem.recordings.len())
            .map(|index| counted(problem, index, &residuals[index]))
            .collect();
        let views: Vec<coloured_noise::Counted<'_>> = counted.iter().map(Counted::view).collect();
        let colour = match problem.noise {
            NoiseSource::Periods => ColouredNoise::of_periods(problem.recordings),
            NoiseSource::Residuals => None,
        };
        let colour = colour.unwrap_or_else(|| ColouredNoise::of(&views));
        let parts = counted.iter().enumerate().map(|(index, counted)| {
            let part = Part::new(problem, self, index);
            let noise = part.noise(counted, &colour);
            (part, noise)
        });
        Sandwich {
            parts: parts.collect(),
            problem,
            sensitivity: self,
        }
    }
}

/// The covariance of the unknowns under a noise, not multiplied out.
pub struct Sandwich<'a> {
    problem: &'a FitProblem<'a>,
    sensitivity: &'a Sensitivity,
    parts: Vec<(Part<'a>, SegmentNoise)>,
}

impl Sandwich<'_> {
    /// C; infinite variance of unknowns that the derivatives do not determine.
    pub fn covariance(&self) -> DMatrix<f64> {
        let bread = self.bread();
        let known = self.problem.prior.rows();
        let known = known.select_columns(&self.problem.unknowns.positions());
        let mut meat = known.tr_mul(&known);
        for (part, noise) in &self.parts {
            meat += part.middle(noise);
        }
        let covariance = &bread * meat * &bread;
        let mut covariance = (&covariance + covariance.transpose()) * 0.5;
        for &j in &self.sensitivity.open {
            covariance[(j, j)] = f64::INFINITY;
        }
        covariance
    }

    /// `gᵀ C g` over the unknowns that the derivatives determine.
    pub fn variance(&self, g: &DVector<f64>) -> f64 {
        let mut g = g.clone();
        self.sensitivity.open.iter().for_each(|&j| g[j] = 0.0);
        let along = self.bread() * g;
        let known = self.problem.prior.rows();
        let known = known.select_columns(&self.problem.unknowns.positions()) * &along;
        let parts = self.parts.iter();
        let of_parts: f64 = parts
            .map(|(part, noise)| part.variance(noise, &along))
            .sum();
        of_parts + known.norm_squared()
    }

    /// B.
    fn bread(&self) -> DMatrix<f64> {
        &self.sensitivity.inverse * self.sensitivity.inverse.transpose()
    }
}

/// R with `XᵀX + PᵀP = RᵀR` at x.
fn triangular(problem: &FitProblem<'_>, x: &DVector<f64>) -> DMatrix<f64> {
    let whole = problem.factor(x).matrix();
    whole.view((0, 0), (x.len(), x.len())).into_owned()
}

/// Unknowns that the derivatives do not determine, and the others.
fn open_and_kept(triangular: &DMatrix<f64>) -> (Vec<usize>, Vec<usize>) {
    let is_open = |j: usize| {
        let own = triangular[(j, j)].abs();
        own.is_nan() || own <= DEPENDENT * triangular.column(j).norm()
    };
    (0..triangular.ncols()).partition(|&j| is_open(j))
}

/// R⁻¹ at x over the unknowns that the derivatives determine there, so that `R⁻¹ R⁻ᵀ` is the inverse of `XᵀX + PᵀP`.
pub(super) fn inverse_over_determined(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
) -> Option<DMatrix<f64>> {
    let triangular = triangular(problem, x);
    let (_, kept) = open_and_kept(&triangular);
    inverse_over(&triangular, &kept)
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

/// Factors of the rows of a channel of a recording; 0 where a row does not count.
fn row_factors(problem: &FitProblem<'_>, index: usize, channel: usize) -> Vec<f64> {
    let recording = problem.recordings[index];
    let factors = problem.factors.as_ref().map(|factors| &factors[index]);
    let factor = |row: usize| match (recording.counts(row), factors) {
        (false, _) => 0.0,
        (true, None) => 1.0,
        (true, Some(factors)) => factors[channel][row],
    };
    (0..recording.rows()).map(factor).collect()
}

/// Residuals times the factors of their rows, and which rows of them count: `[channel][row]`.
fn counted(problem: &FitProblem<'_>, index: usize, residuals: &[Vec<f64>]) -> Counted {
    let mut counted = Counted::default();
    for (channel, series) in residuals.iter().enumerate() {
        let own = row_factors(problem, index, channel);
        counted.counts.push(own.iter().map(|f| *f != 0.0).collect());
        let influence = influence(&own);
        let scaled = series.iter().zip(&own).map(|(e, f)| influence * e * f * f);
        counted.residuals.push(scaled.collect());
    }
    counted
}

/// `√(mean f²) / mean ψ′` over the rows that count: residuals f² e times this, beside derivatives times f, give the
/// covariance of an M-estimator, `mean ψ² / (mean ψ′)² (XᵀX)⁻¹` (Huber and Ronchetti 2009, section 7.6). Of Tukey's biweight with
/// f = 1 − (u/c)², ψ′ = f (5 f − 4); rows that are counted whole have f = 1, and all of them give 1.
fn influence(factors: &[f64]) -> f64 {
    let (mut weight, mut slope, mut rows) = (0.0, 0.0, 0.0);
    for f in factors.iter().filter(|f| **f != 0.0) {
        weight += f * f;
        slope += f * (5.0 * f - 4.0);
        rows += 1.0;
    }
    // More than half of the rows lie where ψ rises, by the scale that is their median deviation.
    if slope > 0.0 {
        (weight * rows).sqrt() / slope
    } else {
        1.0
    }
}

#[derive(Default)]
struct Counted {
    residuals: Vec<Vec<f64>>,
    counts: Vec<Vec<bool>>,
}

impl Counted {
    fn view(&self) -> coloured_noise::Counted<'_> {
        coloured_noise::Counted {
            residuals: &self.residuals,
            counts: &self.counts,
        }
    }

    /// Innovations of all channels.
    fn innovations(&self, colour: &ColouredNoise, cyclic: bool) -> Self {
        let channels = self.residuals.iter().zip(&self.counts).enumerate();
        let of = |(c, (series, counts)): (usize, (&Vec<f64>, &Vec<bool>))| {
            colour.innovations(c, series, counts, cyclic)
        };
        let mut all = Self::default();
        for Innovations { values, known } in channels.map(of) {
            all.residuals.push(values);
            all.counts.push(known);
        }
        all
    }
}

/// One recording of the fit.
struct Part<'a> {
    problem: &'a FitProblem<'a>,
    sensitivity: &'a Sensitivity,
    recording: &'a Prepared,
    index: usize,
}

/// The noise of the segments of a recording.
struct SegmentNoise {
    transform: Transform,
    /// `Lᴴ A⁻ᴴ WᵀW` at every frequency.
    mixing: Vec<DMatrix<Complex<f64>>>,
}

impl<'a> Part<'a> {
    fn new(problem: &'a FitProblem<'a>, sensitivity: &'a Sensitivity, index: usize) -> Self {
        Self {
            problem,
            sensitivity,
            recording: problem.recordings[index],
            index,
        }
    }

    fn segments(&self) -> Vec<Range<usize>> {
        let (rows, length) = (self.recording.rows(), segment_length(self.recording));
        let starts = (0..rows).step_by(length);
        starts
            .map(|start| start..rows.min(start + length))
            .collect()
    }

    fn noise(&self, counted: &Counted, colour: &ColouredNoise) -> SegmentNoise {
        let segments = self.segments();
        let length = segment_length(self.recording);
        let cyclic = self.recording.segment().cyclic && segments.len() == 1;
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
    fn middle(&self, noise: &SegmentNoise) -> DMatrix<f64> {
        let segments = self.segments();
        let parts: Vec<DMatrix<f64>> = segments
            .into_par_iter()
            .map(|rows| gram(&self.mixed(&noise.transform, &self.columns(rows), &noise.mixing)))
            .collect();
        let count = self.sensitivity.inverse.nrows();
        parts
            .iter()
            .fold(DMatrix::zeros(count, count), |sum, part| sum + part)
    }

    /// `uᵀ M u` of this recording.
    fn variance(&self, noise: &SegmentNoise, u: &DVector<f64>) -> f64 {
        let of = |rows| {
            let along = along(&self.columns(rows), u);
            self.mixed(&noise.transform, &along, &noise.mixing)
                .norm_squared()
        };
        self.segments().into_iter().map(of).sum()
    }

    /// Spectrum of the innovations of the residuals.
    fn spectrum(&self, innovations: &Counted, segments: &[Range<usize>]) -> Spectrum {
        let transform = Transform::new(segment_length(self.recording));
        let channels = innovations.residuals.len();
        let taken = self.sensitivity.inverse.nrows() as f64 * BANDS;
        let is_taken = taken / self.recording.rows().max(1) as f64 > NEGLIGIBLE;
        let of_segment = |rows: &Range<usize>| -> Vec<Power> {
            let whole = self.sensitivity.segments[self.index].as_ref();
            let leverage = is_taken.then(|| match whole {
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

    fn columns(&self, rows: Range<usize>) -> Cow<'a, Columns> {
        match &self.sensitivity.segments[self.index] {
            Some(whole) => Cow::Borrowed(&whole.columns),
            None => Cow::Owned(columns(
                self.problem,
                &self.sensitivity.values,
                self.index,
                rows,
            )),
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
        let projected = self.mixed(transform, columns, &weights) * &self.sensitivity.inverse;
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
    series: &Counted,
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
