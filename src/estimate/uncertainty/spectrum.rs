//! Spectra of weighted residuals over segments of recordings, smoothed over cells of frequency.

use nalgebra::{Complex, DMatrix};
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use std::ops::Range;
use std::sync::Arc;

/// Rows of a segment: longer than residuals remember, short enough for the columns of one to fit in
/// memory.
pub const SEGMENT: usize = 4096;

/// Frequencies of a segment that one cell averages at least, so that a spectral matrix of as many
/// channels as robots have is regular and its variances have tens of degrees of freedom.
const LEAST_PER_CELL: usize = 24;

/// Ratio of successive frequencies at which cells may part: a spectrum changes little over a quarter of an octave.
const EDGE_RATIO: f64 = 1.25;

/// What the parting of a cell has to add to twice the logarithm of the likelihood, in units of the logarithm of the
/// number of frequencies: a level on either side and the place (Schwarz 1978; Zhang and Siegmund 2007).
const PRICE: f64 = 3.0;

/// The transform of segments of one length.
pub struct Transform {
    plan: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    length: usize,
}

impl Transform {
    /// Plans transforms of segments of so many rows.
    pub fn new(length: usize) -> Self {
        let mut planner = RealFftPlanner::new();
        Self {
            plan: planner.plan_fft_forward(length),
            inverse: planner.plan_fft_inverse(length),
            length,
        }
    }

    /// Rows of a segment.
    pub fn length(&self) -> usize {
        self.length
    }

    /// Number of frequencies from 0 to half the rate.
    pub fn frequencies(&self) -> usize {
        self.length / 2 + 1
    }

    /// Unitary transform, `X(f) = N^(−1/2) Σ x_k e^(−2πi f k)`, of at most `length` values.
    pub fn of(&self, series: &[f64]) -> Vec<Complex<f64>> {
        let mut input = vec![0.0; self.length];
        input[..series.len()].copy_from_slice(series);
        let mut output = self.plan.make_output_vec();
        let scale = 1.0 / (self.length as f64).sqrt();
        // Lengths agree by construction, and that is the only way for the transform to fail.
        if self.plan.process(&mut input, &mut output).is_err() {
            output.fill(Complex::new(0.0, 0.0));
        }
        let scaled = output.into_iter();
        scaled
            .map(|z| Complex::new(z.re * scale, z.im * scale))
            .collect()
    }

    /// `Σ_f X(f) e^(2πi f k)` over positive and negative frequencies, for every k: of a product `X = A B̄` of two
    /// transforms the correlation of their series, `Σ_t a(t+k) b(t)`, cyclic.
    pub fn back(&self, mut spectrum: Vec<Complex<f64>>) -> Vec<f64> {
        let mut output = self.inverse.make_output_vec();
        // Frequencies that are their own mirror are real in the transform of a real series.
        for (f, z) in spectrum.iter_mut().enumerate() {
            if self.multiplicity(f) == 1.0 {
                z.im = 0.0;
            }
        }
        if self.inverse.process(&mut spectrum, &mut output).is_err() {
            output.fill(0.0);
        }
        output
    }

    /// How often a frequency counts in the sum over all: negative ones are the mirror of positive ones.
    pub fn multiplicity(&self, frequency: usize) -> f64 {
        let own_mirror = frequency == 0 || 2 * frequency == self.length;
        if own_mirror { 1.0 } else { 2.0 }
    }
}

/// Powers of the residuals of all channels at one frequency, as often as it counts.
#[derive(Debug, Clone)]
pub struct Power {
    /// Of the frequencies up to half the rate, the share at which it lies.
    pub place: f64,
    /// How often it counts: 2 for a frequency that stands for its negative too.
    pub weight: f64,
    /// P = e eᴴ for a periodogram.
    pub matrix: DMatrix<Complex<f64>>,
    /// Share of the power of each channel that the fit has taken.
    pub leverage: Vec<f64>,
}

/// Spectral matrix in cells of frequency within which it is flat as far as the powers tell, corrected for what the fit
/// has taken from them.
pub struct Spectrum {
    /// Upper edges of the cells as shares of the frequencies up to half the rate; the last is 1.
    edges: Vec<f64>,
    /// Roots of the spectral matrices, `S = L Lᴴ`.
    roots: Vec<DMatrix<Complex<f64>>>,
}

impl Spectrum {
    /// Of powers in any order.
    pub fn of(mut powers: Vec<Power>) -> Self {
        powers.sort_by(|a, b| a.place.total_cmp(&b.place));
        let levels = Levels::of(&powers);
        let whole = 0..powers.len();
        let mut parts = Vec::from([whole]);
        let mut done = Vec::new();
        while let Some(part) = parts.pop() {
            match levels.best_edge(&part) {
                Some(edge) => parts.extend([edge..part.end, part.start..edge]),
                None => done.push(part),
            }
        }
        let edge = |part: &Range<usize>| powers.get(part.end).map_or(1.0, |p| p.place);
        Self {
            edges: done.iter().map(edge).collect(),
            roots: done
                .iter()
                .map(|part| root(mean(&powers[part.clone()])))
                .collect(),
        }
    }

    /// L of every cell, from the lowest frequencies to the highest.
    pub fn roots(&self) -> &[DMatrix<Complex<f64>>] {
        &self.roots
    }

    /// Which of so many frequencies between 0 and half the rate every cell covers.
    pub fn cells_of(&self, frequencies: usize) -> Vec<Range<usize>> {
        let last = frequencies.saturating_sub(1).max(1) as f64;
        let mut start = 0;
        let mut cells = Vec::with_capacity(self.edges.len());
        for (k, edge) in self.edges.iter().enumerate() {
            let end = match k + 1 == self.edges.len() {
                true => frequencies,
                false => ((edge * last).ceil() as usize).max(start).min(frequencies),
            };
            cells.push(start..end);
            start = end;
        }
        cells
    }
}

/// Power that is left at least: a cell that the fit explains nearly whole tells little of noise.
const LEAST_LEFT: f64 = 0.2;

/// `S_ij = Σ P_ij / Σ √((1 − h_i)(1 − h_j))`.
fn mean(powers: &[Power]) -> DMatrix<Complex<f64>> {
    let channels = powers.first().map_or(0, |p| p.leverage.len());
    let mut sum = DMatrix::zeros(channels, channels);
    let mut left = vec![0.0; channels];
    let mut whole = 0.0;
    for power in powers {
        sum += &power.matrix * Complex::new(power.weight, 0.0);
        whole += power.weight;
        for (left, leverage) in left.iter_mut().zip(&power.leverage) {
            *left += power.weight * (1.0 - leverage).max(0.0);
        }
    }
    left.iter_mut().for_each(|l| *l = l.max(LEAST_LEFT * whole));
    DMatrix::from_fn(channels, channels, |i, j| {
        let divisor = (left[i] * left[j]).sqrt();
        match divisor > 0.0 {
            true => sum[(i, j)] / Complex::new(divisor, 0.0),
            false => Complex::new(0.0, 0.0),
        }
    })
}

/// Sums over the first frequencies, from which the level of any cell follows.
struct Levels {
    /// By channel: power, and degrees of freedom that the fit has left.
    sums: Vec<Vec<[f64; 2]>>,
}

impl Levels {
    fn of(powers: &[Power]) -> Self {
        let channels = powers.first().map_or(0, |p| p.leverage.len());
        let of = |c: usize| {
            let mut sums = vec![[0.0; 2]];
            for power in powers {
                let [total, free] = sums[sums.len() - 1];
                let weight = 0.5 * power.weight;
                let left = weight * (1.0 - power.leverage[c]).max(LEAST_LEFT);
                sums.push([total + weight * power.matrix[(c, c)].re, free + left]);
            }
            sums
        };
        Self {
            sums: (0..channels).map(of).collect(),
        }
    }

    /// `−2 ln L` of a part at its level, the powers having exponential distributions.
    fn cost(&self, channel: usize, part: &Range<usize>) -> f64 {
        let [a, b] = [part.start, part.end].map(|k| self.sums[channel][k]);
        let (total, free) = (b[0] - a[0], b[1] - a[1]);
        match total > 0.0 {
            true => 2.0 * free * (total / free).ln(),
            false => 0.0,
        }
    }

    /// The edge at which a part falls most clearly into two of different level on some channel, if one does.
    fn best_edge(&self, part: &Range<usize>) -> Option<usize> {
        let last = part.end.checked_sub(LEAST_PER_CELL)?;
        let price = PRICE * (part.len().max(2) as f64).ln();
        let mut best = (price, None);
        let mut edge = part.start + LEAST_PER_CELL;
        while edge <= last {
            for c in 0..self.sums.len() {
                let gain = self.cost(c, part)
                    - self.cost(c, &(part.start..edge))
                    - self.cost(c, &(edge..part.end));
                if gain > best.0 {
                    best = (gain, Some(edge));
                }
            }
            edge = ((edge as f64 * EDGE_RATIO) as usize).max(edge + LEAST_PER_CELL);
        }
        best.1
    }
}

/// A root of a Hermitian matrix; of its diagonal where the matrix is not definite.
fn root(matrix: DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    let diagonal = matrix
        .diagonal()
        .map(|z| Complex::new(z.re.max(0.0).sqrt(), 0.0));
    match nalgebra::Cholesky::new(matrix) {
        Some(factor) => factor.l(),
        None => DMatrix::from_diagonal(&diagonal),
    }
}
