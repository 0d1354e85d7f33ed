//! The cut-off of a low-pass, from the spectrum of what is filtered.
//!
//! With S(f) the spectrum of the acceleration, N(f) that of its noise and G the gain of the filter,
//! the cut-off minimises the estimated squared error  Σ_f (1 - G)² (S - N) + G² N:  what the filter
//! takes from the motion, and what it leaves of the noise.
//!
//! The noise of a measured position, velocity or acceleration grows in the acceleration as f⁴, f² and
//! f⁰ if it is white, and more slowly if, as with most encoders, it is not; it does not fall. So N is
//! the greatest rising curve below the spectrum: N(f) = min_{f' >= f} S(f'). The spectrum at its top
//! alone would not do: coloured noise is weakest there, and would pass for motion below.

use std::f64::consts::TAU;

use crate::recording::spectrum::{BAND_RATIO, clear_until, coefficients, noise_power};
use crate::recording::zero_phase::gain;

/// Candidates for the cut-off; over three decades each is 8 % above the one before, and the error
/// near its least changes far less than that.
const CANDIDATES: usize = 90;

/// Lowest cut-off that the data may choose, in cycles per recording: keeps the edges of a joint at
/// rest to a twentieth of the recording each.
const LEAST_CYCLES: f64 = 40.0;

/// Highest cut-off that the data may choose, in units of the rate: just below half of it.
const HIGHEST_CUTOFF: f64 = 0.45;

/// Cells of the spectrum to an e-fold of frequency: over one of them the gain, which falls with the
/// eighth power, changes by 2 %.
const CELLS_PER_EFOLD: usize = 400;

/// How the samples came to be even.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sampling {
    Recorded,
    Interpolated,
}

impl Sampling {
    /// The fraction of half the rate from which on everything counts as noise. At the top the
    /// filters of sensors make noise weak, and disturbances fold back as lines; linear
    /// interpolation damps noise by up to a half from the middle on.
    fn noise_from(self) -> f64 {
        match self {
            Self::Recorded => 0.75,
            Self::Interpolated => 0.5,
        }
    }
}

/// Frequencies in the narrowest band whose median is a level of the noise: its relative error is 0.25.
const BAND_LEAST: usize = 32;

/// A cut-off and how far the motion stands clear of its noise, Hz.
pub(super) struct Cutoff {
    pub hz: f64,
    pub clear_hz: f64,
}

/// The cut-off with the least estimated error of the acceleration, which is the derivative of the given
/// order of the series.
pub(super) fn choose_cutoff(
    series: &[f64],
    order: usize,
    rate_hz: f64,
    sampling: Sampling,
) -> Cutoff {
    let highest = HIGHEST_CUTOFF * rate_hz;
    let lowest = (LEAST_CYCLES * rate_hz / series.len() as f64).min(0.5 * highest);
    let power = acceleration_spectrum(series, order);
    let noise = rising_envelope(&power, sampling.noise_from());
    let step = 0.5 * rate_hz / power.len() as f64;
    let cells = cells(&power, &noise);
    let error = |cutoff: f64| -> f64 {
        let of = |cell: &Cell| {
            let passed = gain(cell.index * step, cutoff, rate_hz);
            (1.0 - passed).powi(2) * (cell.power - cell.noise) + passed.powi(2) * cell.noise
        };
        cells.iter().map(of).sum()
    };
    let ratio = (highest / lowest).powf(1.0 / (CANDIDATES - 1) as f64);
    let candidates = (0..CANDIDATES).map(|i| lowest * ratio.powi(i as i32));
    let best = candidates
        .map(|cutoff| (error(cutoff), cutoff))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let hz = best.map_or(highest, |(_, cutoff)| cutoff);
    Cutoff {
        hz,
        clear_hz: (clear_until(&power, &noise) as f64 * step).min(hz),
    }
}

/// Sums of the spectrum and its noise over frequencies between which the gain hardly changes.
struct Cell {
    /// Mean index of its frequencies.
    index: f64,
    power: f64,
    noise: f64,
}

/// Cells without the constant: single frequencies first, then four hundred to an e-fold.
fn cells(power: &[f64], noise: &[f64]) -> Vec<Cell> {
    let mut cells = Vec::new();
    let mut low = 1;
    while low < power.len() {
        let high = (low + 1 + low / CELLS_PER_EFOLD).min(power.len());
        cells.push(Cell {
            index: 0.5 * (low + high - 1) as f64,
            power: power[low..high].iter().sum(),
            noise: noise[low..high].iter().sum(),
        });
        low = high;
    }
    cells
}

/// Power of the windowed d-th differences below half the rate, to a common factor.
fn acceleration_spectrum(series: &[f64], order: usize) -> Vec<f64> {
    let mut differences = series.to_vec();
    for _ in 0..order {
        let pairs = differences.windows(2);
        differences = pairs.map(|pair| pair[1] - pair[0]).collect();
    }
    let n = differences.len();
    let mean = differences.iter().sum::<f64>() / n as f64;
    for (k, value) in differences.iter_mut().enumerate() {
        // Hann squared, whose leakage falls with the fifth power of the distance: neither what the two
        // ends differ by nor the strong low frequencies may pass for high ones.
        let hann = 0.5 * (1.0 - (TAU * (k as f64 + 0.5) / n as f64).cos());
        *value = (*value - mean) * hann * hann;
    }
    let spectrum = coefficients(&differences);
    spectrum[..n / 2].iter().map(|c| c.norm_sqr()).collect()
}

/// N(f) = min_{f' >= f} S(f'), with S smoothed over bands; S itself where everything is noise.
fn rising_envelope(power: &[f64], noise_from: f64) -> Vec<f64> {
    let mut envelope = power.to_vec();
    let mut high = (noise_from * power.len() as f64) as usize;
    let mut least = f64::INFINITY;
    while high > 0 {
        let width = ((high as f64 * (1.0 - 1.0 / BAND_RATIO)) as usize).max(BAND_LEAST);
        // What is left at the bottom and is too narrow for a band joins the last one.
        let low = match high.saturating_sub(width) {
            low if low < BAND_LEAST => 0,
            low => low,
        };
        least = least.min(noise_power(&mut power[low..high].to_vec(), 1.0));
        envelope[low..high].fill(least);
        high = low;
    }
    envelope
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_of_a_falling_spectrum_is_its_level_at_three_quarters() {
        let falling: Vec<f64> = (0..1000).map(|f| 1.0 / (1.0 + f as f64)).collect();
        let envelope = rising_envelope(&falling, 0.75);
        assert!(envelope[..750].iter().all(|n| *n == envelope[0]));
        assert_eq!(envelope[750..], falling[750..]);
    }

    #[test]
    fn the_noise_of_a_rising_spectrum_is_the_spectrum() {
        let rising: Vec<f64> = (0..1000).map(|f| (1.0 + f as f64).powi(4)).collect();
        let envelope = rising_envelope(&rising, 0.75);
        assert!(envelope[..750].is_sorted());
        // The median of a band of ratio 1.25, by the factor that makes a median of powers a mean.
        for f in 200..750 {
            let ratio = envelope[f] / rising[f] * (8.0_f64 / 9.0).powi(3);
            assert!((1.25_f64.powi(-4)..1.25_f64.powi(4)).contains(&ratio));
        }
    }
}
