//! Amplitude spectral density of evenly spaced samples by Welch's average of windowed stretches.
//!
//! S(f) = 2/(r Σw²) · mean |Σ_k w_k (y_k − ȳ) exp(−i 2π f k / r)|²,  r the rate in Hz and w Hann's window; shown is √S, in the unit of y per √Hz.
//! Source: Welch 1967, eq. 3 to 6, with half of each stretch in the next.

use realfft::RealFftPlanner;
use std::f64::consts::TAU;

/// Samples of a stretch at most: with 200 Hz a resolution of 0.05 Hz.
const MOST: usize = 4096;

/// Samples of a stretch at least: fewer show no frequency.
const LEAST: usize = 32;

/// Points that are shown at most, at equal ratios of frequency.
const POINTS: usize = 240;

/// Steps between samples may differ from their mean by this share of it.
const EVEN: f64 = 0.02;

/// The rate of evenly spaced samples, Hz; `None` where they are not.
pub(super) fn rate_hz(t: &[f64]) -> Option<f64> {
    let mean = (t.last()? - t.first()?) / (t.len() as f64 - 1.0);
    let even = |pair: &[f64]| (pair[1] - pair[0] - mean).abs() <= EVEN * mean;
    (t.len() > LEAST && mean > 0.0 && t.windows(2).all(even)).then(|| 1.0 / mean)
}

/// Which frequencies are shown, and how they are found.
pub(super) struct Spectrum {
    rate_hz: f64,
    length: usize,
    window: Vec<f64>,
    /// First bin of each point, and the end of the last.
    bounds: Vec<usize>,
}

impl Spectrum {
    /// For series of `rows` samples.
    pub fn new(rate_hz: f64, rows: usize) -> Self {
        // Three stretches at least, half over each other, so that there is something to average.
        let half = rows / 2;
        let length = match half < LEAST {
            true => LEAST.min(rows),
            false => MOST.min(half),
        };
        let window: Vec<f64> = (0..length)
            .map(|k| 0.5 - 0.5 * (TAU * k as f64 / length as f64).cos())
            .collect();
        let last = length / 2 + 1;
        let ratio = (last as f64).powf(1.0 / POINTS as f64);
        let mut bounds: Vec<usize> = (0..=POINTS)
            .map(|k| ratio.powi(k as i32) as usize)
            .collect();
        bounds.push(last);
        bounds.dedup();
        Self {
            rate_hz,
            length,
            window,
            bounds,
        }
    }

    /// Hz, the middle of the bins of each point.
    pub fn frequencies(&self) -> Vec<f64> {
        let bin = self.rate_hz / self.length as f64;
        let middle = |pair: &[usize]| 0.5 * bin * (pair[0] + pair[1] - 1) as f64;
        self.bounds.windows(2).map(middle).collect()
    }

    /// √S at each of the frequencies; empty where a value is not finite.
    pub fn density(&self, y: &[f64]) -> Vec<f64> {
        if y.iter().any(|value| !value.is_finite()) {
            return Vec::new();
        }
        let mean = y.iter().sum::<f64>() / y.len() as f64;
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(self.length);
        let mut power = vec![0.0; self.length / 2 + 1];
        let mut count = 0.0;
        for start in (0..=y.len() - self.length).step_by((self.length / 2).max(1)) {
            let stretch = &y[start..start + self.length];
            let mut windowed: Vec<f64> = stretch
                .iter()
                .zip(&self.window)
                .map(|(y, w)| w * (y - mean))
                .collect();
            let mut out = transform.make_output_vec();
            if transform.process(&mut windowed, &mut out).is_err() {
                return Vec::new();
            }
            for (sum, value) in power.iter_mut().zip(&out) {
                *sum += value.norm_sqr();
            }
            count += 1.0;
        }
        let energy: f64 = self.window.iter().map(|w| w * w).sum();
        let scale = 2.0 / (self.rate_hz * energy * count);
        self.bounds
            .windows(2)
            .map(|pair| {
                let own = &power[pair[0]..pair[1]];
                (scale * own.iter().sum::<f64>() / own.len() as f64).sqrt()
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White noise of variance σ² has S = 2 σ²/r from 0 to r/2; here of a generator whose values are ±1, σ = 1.
    #[test]
    fn recovers_known_density_of_white_noise() {
        let mut state = 1_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            if state >> 63 == 0 { 1.0 } else { -1.0 }
        };
        let y: Vec<f64> = (0..40_000).map(|_| next()).collect();
        let spectrum = Spectrum::new(200.0, y.len());
        let density = spectrum.density(&y);
        let high = &density[density.len() / 2..];
        let mean = high.iter().map(|a| a * a).sum::<f64>() / high.len() as f64;
        // Every point of that half averages over more than ten stretches and ten bins.
        assert!(
            (mean - 0.01).abs() < 0.01 * 3.0 / (high.len() as f64 * 100.0).sqrt() * 2.0,
            "{mean}"
        );
    }

    #[test]
    fn recovers_known_frequency_of_a_sine() {
        let rate = 100.0;
        let y: Vec<f64> = (0..6000)
            .map(|k| (TAU * 7.0 * f64::from(k) / rate).sin())
            .collect();
        let spectrum = Spectrum::new(rate, y.len());
        let density = spectrum.density(&y);
        let top = (0..density.len()).max_by(|&a, &b| density[a].total_cmp(&density[b]));
        let found = spectrum.frequencies()[top.unwrap()];
        assert!((found - 7.0).abs() < 0.2, "{found}");
    }

    #[test]
    fn uneven_samples_have_no_rate() {
        let even: Vec<f64> = (0..100).map(|k| 1e9 + 0.01 * f64::from(k)).collect();
        assert!((rate_hz(&even).unwrap() - 100.0).abs() < 1e-3);
        let gap: Vec<f64> = even
            .iter()
            .filter(|t| (**t * 100.0) as i64 % 17 != 0)
            .copied()
            .collect();
        assert_eq!(rate_hz(&gap), None);
        assert_eq!(rate_hz(&[0.0]), None);
    }
}
