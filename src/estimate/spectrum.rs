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

/// Most cells: finer structure than this share of the band is not resolved.
const MOST_CELLS: usize = 128;

/// The transform of segments of one length.
pub struct Transform {
    plan: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    length: usize,
}

impl Transform {
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

/// Spectral matrix of the residuals in cells of frequency, corrected for what the fit has taken from them.
pub struct Spectrum {
    cells: Vec<DMatrix<Complex<f64>>>,
    /// Residual power that is left where the fit takes its share, per cell and channel.
    left: Vec<Vec<f64>>,
    weight: Vec<f64>,
}

impl Spectrum {
    /// Cells for so many frequencies in all over so many channels.
    pub fn new(frequencies: usize, channels: usize) -> Self {
        let count = (frequencies / LEAST_PER_CELL).clamp(1, MOST_CELLS);
        Self {
            cells: vec![DMatrix::zeros(channels, channels); count],
            left: vec![vec![0.0; channels]; count],
            weight: vec![0.0; count],
        }
    }

    /// Number of cells.
    pub fn count(&self) -> usize {
        self.cells.len()
    }

    /// Which of so many frequencies between 0 and half the rate every cell covers.
    pub fn cells_of(&self, frequencies: usize) -> Vec<Range<usize>> {
        let count = self.cells.len();
        let from = |cell: usize| (cell * frequencies).div_ceil(count);
        (0..count).map(|cell| from(cell)..from(cell + 1)).collect()
    }

    /// Adds the power P of the residuals of all channels at one frequency, `P = e eᴴ` for a periodogram, and the
    /// leverage h of each there.
    pub fn add(
        &mut self,
        cell: usize,
        weight: f64,
        (power, leverage): (&DMatrix<Complex<f64>>, &[f64]),
    ) {
        self.cells[cell] += power * Complex::new(weight, 0.0);
        for (left, leverage) in self.left[cell].iter_mut().zip(leverage) {
            *left += weight * (1.0 - leverage).max(0.0);
        }
        self.weight[cell] += weight;
    }

    /// Roots of the spectral matrices, `S = L Lᴴ`, with `S_ij = Σ e_i ē_j / Σ √((1 − h_i)(1 − h_j))`.
    pub fn roots(mut self) -> Vec<DMatrix<Complex<f64>>> {
        /// Power that is left at least: a cell that the fit explains nearly whole tells little of noise.
        const LEAST_LEFT: f64 = 0.2;
        for (cell, matrix) in self.cells.iter_mut().enumerate() {
            let floor = LEAST_LEFT * self.weight[cell];
            let scale: Vec<f64> = self.left[cell].iter().map(|l| l.max(floor)).collect();
            for i in 0..matrix.nrows() {
                for j in 0..matrix.ncols() {
                    let divisor = (scale[i] * scale[j]).sqrt();
                    let factor = if divisor > 0.0 { 1.0 / divisor } else { 0.0 };
                    matrix[(i, j)] *= Complex::new(factor, 0.0);
                }
            }
        }
        self.cells.into_iter().map(root).collect()
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
