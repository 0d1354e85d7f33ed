//! Cross-spectral matrices of residuals with missing rows, left out by a mask or at standstill:
//!
//! `P_ij(f) = Σ_k R_ij(k) e^(−2πi f k)`,   `R_ij(k) = Σ_t e_i(t+k) e_j(t) / n_ij(k)`
//!
//! over the `n_ij(k)` pairs of rows that count on both channels (Parzen 1963). A spectrum of zeros in the gaps would be
//! that of an error which ends at every gap, and straight lines across them are smaller than the error is.

use crate::estimate::uncertainty::spectrum::Transform;
use nalgebra::{Complex, DMatrix};

/// Share of the rows that count which a lag has to have as pairs: fewer tell nothing of it.
const LEAST_PAIRS: f64 = 0.02;

/// Residuals of a segment, `[channel][row]`, zero in rows that do not count, and which do.
pub struct MaskedResiduals<'a> {
    pub residuals: &'a [Vec<f64>],
    pub counts: &'a [Vec<bool>],
}

impl MaskedResiduals<'_> {
    /// P at all frequencies of the transform. Without gaps the periodogram `e(f) e(f)ᴴ`.
    pub fn powers(&self, transform: &Transform) -> Vec<DMatrix<Complex<f64>>> {
        let channels = self.residuals.len();
        let spectra = |series: &[Vec<f64>]| -> Vec<Vec<Complex<f64>>> {
            series.iter().map(|s| transform.of(s)).collect()
        };
        let errors = spectra(self.residuals);
        let one = |counts: &Vec<bool>| counts.iter().map(|&c| f64::from(u8::from(c))).collect();
        let masks: Vec<Vec<f64>> = self.counts.iter().map(one).collect();
        let masks = spectra(&masks);
        let mut powers = vec![DMatrix::zeros(channels, channels); transform.frequencies()];
        for i in 0..channels {
            for j in 0..channels {
                let covariance = covariance(transform, [&errors[i], &errors[j]], {
                    [&masks[i], &masks[j]]
                });
                let scale = Complex::new((covariance.len() as f64).sqrt(), 0.0);
                let series = transform.of(&covariance);
                for (power, p) in powers.iter_mut().zip(series) {
                    power[(i, j)] = p * scale;
                }
            }
        }
        powers
    }
}

type Pair<'a> = [&'a Vec<Complex<f64>>; 2];

/// `R_ij(k)` for all lags k, from the transforms of both errors and of both masks.
fn covariance(transform: &Transform, errors: Pair<'_>, masks: Pair<'_>) -> Vec<f64> {
    let correlation = |[a, b]: Pair<'_>| {
        let product = a.iter().zip(b).map(|(a, b)| a * b.conj());
        transform.back(product.collect())
    };
    let (products, pairs) = (correlation(errors), correlation(masks));
    let least = LEAST_PAIRS * pairs.iter().copied().fold(0.0, f64::max);
    let mean = |(sum, pairs): (f64, f64)| if pairs > least { sum / pairs } else { 0.0 };
    products.into_iter().zip(pairs).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::MaskedResiduals;
    use crate::estimate::uncertainty::spectrum::Transform;
    use crate::robot::random::{generator, symmetric};

    fn series(length: usize) -> Vec<Vec<f64>> {
        let mut rng = generator(3);
        let mut one = || (0..length).map(|_| symmetric(&mut rng, 1.0)).collect();
        (0..2).map(|_| one()).collect()
    }

    #[test]
    fn without_gaps_it_is_the_periodogram() {
        let (length, residuals) = (50, series(50));
        let transform = Transform::new(length);
        let gapped = MaskedResiduals {
            residuals: &residuals,
            counts: &vec![vec![true; length]; 2],
        };
        let spectra: Vec<_> = residuals.iter().map(|s| transform.of(s)).collect();
        for (f, power) in gapped.powers(&transform).iter().enumerate() {
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let expected = spectra[i][f] * spectra[j][f].conj();
                assert!((power[(i, j)] - expected).norm() < 1e-12);
            }
        }
    }

    /// Errors that stay for 30 rows and are new after a gap of 20: the sum over one stretch has the variance
    /// of 30 equal errors, which is the sum of R over all pairs of its rows.
    #[test]
    fn errors_that_last_from_gap_to_gap_keep_their_size() {
        const STEPS: usize = 4000;
        let (mut residuals, mut counts) = (Vec::new(), Vec::new());
        let mut rng = generator(4);
        for _ in 0..STEPS {
            let error = symmetric(&mut rng, 1.0);
            residuals.extend([[error; 30].as_slice(), &[0.0; 20]].concat());
            counts.extend([[true; 30].as_slice(), &[false; 20]].concat());
        }
        let length = residuals.len();
        let transform = Transform::new(length);
        let gapped = MaskedResiduals {
            residuals: &[residuals],
            counts: &[counts],
        };
        let mut stretch = vec![0.0; length];
        stretch[..30].fill(1.0);
        let powers = gapped.powers(&transform);
        let found: f64 = (transform.of(&stretch).iter().zip(&powers).enumerate())
            .map(|(f, (x, p))| transform.multiplicity(f) * x.norm_sqr() * p[(0, 0)].re)
            .sum();
        // An even spread over ±1 has variance 1/3. Lags from 20 to 30 rows, a twelfth of the pairs, also join
        // different stretches: the sum loses 3.7 %.
        let expected = 900.0 / 3.0;
        let deviation = (0.8 / STEPS as f64).sqrt();
        let ratio = found / expected;
        assert!((ratio - 0.963).abs() < 4.0 * deviation, "{ratio}");
    }
}
