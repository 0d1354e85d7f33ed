//! Fourier coefficients of a real series, and the level of white noise under a spectrum.
//!
//! x(k) = c_0 + Σ_h 2 Re(c_h exp(2πi h k / N)),  c_h = (1/N) Σ_k x(k) exp(-2πi h k / N).

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

/// Coefficients in the narrowest band over which a level is pooled: the relative error of a
/// median of 16 exponential powers is 0.36, enough to tell signal from noise.
pub(in crate::recording) const BAND_LEAST: usize = 16;

/// Ratio of the bounds of a band: a noise spectrum changes little over a quarter of an octave.
pub(in crate::recording) const BAND_RATIO: f64 = 1.25;

/// Motion stands clear of its noise where it has this many times its power: what the noise does to a
/// prediction is then a tenth of what the motion does, and no filter that takes the noise away
/// explains more than that.
const CLEAR: f64 = 10.0;

/// End of the band that starts at `low`; the last band takes in a remainder that is too narrow.
pub(in crate::recording) fn band_end(low: usize, count: usize) -> usize {
    let end = ((low as f64 * BAND_RATIO) as usize).max(low + BAND_LEAST);
    if count < end + BAND_LEAST { count } else { end }
}

/// End of the last band in which a spectrum, noise included, stands clear of its noise; 0 if none does.
pub(in crate::recording) fn clear_until(power: &[f64], noise: &[f64]) -> usize {
    let (mut low, mut clear) = (0, 0);
    while low < power.len() {
        let high = band_end(low, power.len());
        let sum = |series: &[f64]| series[low..high].iter().sum::<f64>();
        if sum(power) >= (1.0 + CLEAR) * sum(noise) {
            clear = high;
        }
        low = high;
    }
    clear
}

/// Coefficients c_0..c_{N/2} of a series of any length N >= 1.
pub(in crate::recording) fn coefficients(series: &[f64]) -> Vec<Complex<f64>> {
    let n = series.len();
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut input = series.to_vec();
    let mut output = plan.make_output_vec();
    // Both buffers come from the plan's own length, so the transform cannot refuse them.
    let _ = plan.process(&mut input, &mut output);
    let scale = 1.0 / n as f64;
    output.iter_mut().for_each(|c| *c *= scale);
    output
}

/// The series of N samples with these coefficients; those above N/2 are taken as zero.
pub(in crate::recording) fn synthesis(mut coefficients: Vec<Complex<f64>>, n: usize) -> Vec<f64> {
    let plan = RealFftPlanner::<f64>::new().plan_fft_inverse(n);
    coefficients.resize(n / 2 + 1, Complex::new(0.0, 0.0));
    coefficients[0].im = 0.0;
    if n.is_multiple_of(2) {
        coefficients[n / 2].im = 0.0;
    }
    let mut output = plan.make_output_vec();
    let _ = plan.process(&mut coefficients, &mut output);
    output
}

/// Σ_i x(i) x(i + l) for the lags 0..=lags. Zeros behind the series keep the circular correlation of the transform from wrapping
/// around.
pub(in crate::recording) fn lagged_products(series: &[f64], lags: usize) -> Vec<f64> {
    let padded = (series.len() + lags + 1).next_power_of_two();
    let mut extended = series.to_vec();
    extended.resize(padded, 0.0);
    let power = coefficients(&extended)
        .into_iter()
        .map(|c| Complex::from(c.norm_sqr()));
    let mut sums = synthesis(power.collect(), padded);
    sums.truncate(lags + 1);
    sums.iter_mut().for_each(|sum| *sum *= padded as f64);
    sums
}

/// Median of values; 0 of none.
pub(in crate::recording) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Mean power per coefficient of white noise, from the median of powers that each have the
/// distribution of a mean of `shape` exponential variables.
///
/// Median of Gamma(a) is a (1 - 1/(9a))³ (Wilson and Hilferty, 1931); the median, not the mean,
/// because a resonance or a line of the mains stands in a few coefficients only.
pub(in crate::recording) fn noise_power(powers: &mut [f64], shape: f64) -> f64 {
    median(powers) / (1.0 - 1.0 / (9.0 * shape)).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn invariant_synthesis_of_coefficients_is_the_series() {
        for n in [1, 2, 7, 30, 101, 1500] {
            let series: Vec<f64> = (0..n).map(|k| ((k * k) as f64).sin()).collect();
            let back = synthesis(coefficients(&series), n);
            for (a, b) in series.iter().zip(&back) {
                assert!((a - b).abs() < 1e-12, "length {n}");
            }
        }
    }

    #[test]
    fn a_falling_spectrum_is_clear_until_it_has_ten_times_the_power_of_its_noise() {
        let noise = vec![1.0; 400];
        let power: Vec<f64> = (0..400)
            .map(|h| 1.0 + 1.0e3 * (-0.03 * h as f64).exp())
            .collect();
        // 1000 e^(-0.03 h) = 10 at h = 153.5, and bands are a quarter wide there.
        let clear = clear_until(&power, &noise) as f64;
        assert!(
            (153.5 / BAND_RATIO..153.5 * BAND_RATIO).contains(&clear),
            "{clear}"
        );
        assert_eq!(clear_until(&noise, &noise), 0);
    }

    #[test]
    fn recovers_known_power_of_white_noise() {
        let n = 20_000;
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let series: Vec<f64> = (0..n)
            .map(|_| 0.3 * Distribution::<f64>::sample(&StandardNormal, &mut random))
            .collect();
        let mut powers: Vec<f64> = coefficients(&series)[1..n / 2]
            .iter()
            .map(|c| c.norm_sqr())
            .collect();
        // The relative error of a median of m exponentials is 1 / (ln 2 sqrt(m)); the formula for
        // the median is good to 2 % at shape 1.
        let bound = 4.0 / (0.69 * (n as f64 / 2.0).sqrt()) + 0.02;
        let ratio = noise_power(&mut powers, 1.0) * n as f64 / 0.09;
        assert!((ratio - 1.0).abs() < bound, "{ratio}");
    }

    /// Bands from the lowest coefficient on; the last that is clear counts, whatever lies below it.
    #[test]
    fn motion_is_clear_until_the_last_band_above_its_noise() {
        let count = 60;
        let noise = vec![1.0; count];
        let first = band_end(0, count);
        let second = band_end(first, count);
        assert!(first > 0 && first < second && second <= count);
        let clear_in = |range: std::ops::Range<usize>, power: f64| {
            let of = |k: usize| if range.contains(&k) { power } else { 1.0 };
            clear_until(&(0..count).map(of).collect::<Vec<f64>>(), &noise)
        };
        assert_eq!(clear_in(0..0, 11.1), 0);
        assert_eq!(clear_in(0..first, 10.9), 0);
        assert_eq!(clear_in(0..first, 11.1), first);
        assert_eq!(clear_in(first..second, 11.1), second);
        assert_eq!(clear_in(0..1, 11.1), 0);
    }
}
