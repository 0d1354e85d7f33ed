//! The bandwidth of a motion, from the spectra of its recorded positions, velocities and accelerations.
//!
//! With S(f) the spectrum of the acceleration, N(f) that of its noise and G the gain of the smoother, the cut-off
//! minimises the estimated squared error  Σ_f (1 - G)² (S - N) + G² N:  what the smoother takes from the motion, and what
//! it leaves of the noise.
//!
//! The noise of a measured position, velocity or acceleration grows in the acceleration as f⁴, f² and
//! f⁰ if it is white, and more slowly if, as with most encoders, it is not; it does not fall. So N is
//! the greatest rising curve below the spectrum: N(f) = min_{f' >= f} S(f'). The spectrum at its top
//! alone would not do: coloured noise is weakest there, and would pass for motion below. Where velocities or
//! accelerations were recorded too, noise is what is left where all are combined: 1/N = Σ 1/N_i.
//!
//! The joints of one arm are driven by controllers of one bandwidth, and a torque needs the motion of all of them: one
//! cut-off serves all, that with the least product of errors, unless it lets a joint's error grow by more than
//! [`CLEARLY`].

use std::f64::consts::{PI, TAU};

use realfft::num_complex::Complex;

use crate::recording::series::spectrum::{
    BAND_RATIO, band_end, clear_until, coefficients, noise_power,
};
use crate::recording::series::zero_phase::gain;

/// Candidates for the cut-off; over three decades each is 8 % above the one before, and the error
/// near its least changes far less than that.
const CANDIDATES: usize = 90;

/// Lowest cut-off that the data may choose, in cycles per recording: fewer lie within the spectral window.
const LEAST_CYCLES: f64 = 20.0;

/// Highest cut-off that the data may choose, in units of the rate: just below half of it.
pub(super) const HIGHEST_CUTOFF: f64 = 0.45;

/// Cells of the spectrum to an e-fold of frequency: over one of them the gain, which falls with the
/// eighth power, changes by 2 %.
const CELLS_PER_EFOLD: usize = 400;

/// A joint has a bandwidth of its own where the common one makes the variance of its acceleration's error so many
/// times the least: its deviation is then three times as large, and the intervals of its inertias with it.
const CLEARLY: f64 = 9.0;

/// Velocities contradict the positions where the two differ by this share of what moves, beyond their noise: a delay of
/// a thirtieth of a radian, of a millisecond at 5 Hz.
const CONTRADICTS: f64 = 0.03;

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

/// First frequency that counts where powers are divided by those of the frequency: below it the window leaks.
const CLEAR_OF_WINDOW: usize = 3;

/// Even samples of a joint's position, velocity or acceleration.
#[derive(Debug, Clone, Copy)]
pub(in crate::recording) struct Samples<'a> {
    pub series: &'a [f64],
    /// 0 position, 1 velocity, 2 acceleration.
    pub order: usize,
}

/// Spectra of a joint's acceleration and of the noise in it, to a common factor.
pub(super) struct MotionSpectrum {
    rate_hz: f64,
    power: Vec<f64>,
    noise: Vec<f64>,
    /// Noise that each channel has by itself, by order.
    of_channels: Vec<(usize, Vec<f64>)>,
    cells: Vec<Cell>,
    /// Variance that a power of one at one frequency is, in the unit of the acceleration times squared steps.
    scale: f64,
}

impl MotionSpectrum {
    /// Of channels of equal length, the position first.
    pub fn of(channels: &[Samples<'_>], rate_hz: f64, sampling: Sampling) -> Self {
        let rows = channels.first().map_or(0, |c| c.series.len());
        let n = rows.saturating_sub(2);
        let from = sampling.noise_from();
        let mut of_channels = Vec::with_capacity(channels.len());
        let (mut power, mut least) = (Vec::new(), Vec::<f64>::new());
        let mut precision: Vec<f64> = Vec::new();
        for channel in channels {
            let own: Vec<f64> = spectrum(channel, rate_hz)
                .iter()
                .map(|c| c.norm_sqr())
                .collect();
            let noise = rising_envelope(&own, from);
            if power.is_empty() {
                (power, least) = (own.clone(), noise.clone());
                precision = noise.iter().map(|x| x.recip()).collect();
            } else {
                for f in 0..own.len() {
                    if noise[f] < least[f] {
                        (power[f], least[f]) = (own[f], noise[f]);
                    }
                    precision[f] += noise[f].recip();
                }
            }
            of_channels.push((channel.order, noise));
        }
        let noise: Vec<f64> = precision.iter().map(|p| p.recip()).collect();
        let window: f64 = (0..n).map(|k| window(k, n).powi(2)).sum();
        Self {
            cells: cells(&power, &noise),
            rate_hz,
            power,
            noise,
            of_channels,
            scale: 2.0 * n as f64 / window.max(f64::MIN_POSITIVE),
        }
    }

    /// Hz between two frequencies.
    fn step(&self) -> f64 {
        0.5 * self.rate_hz / self.power.len().max(1) as f64
    }

    /// Estimated squared error of the acceleration behind a cut-off in Hz, to a common factor.
    fn error(&self, cutoff: f64) -> f64 {
        let step = self.step();
        let of = |cell: &Cell| {
            let passed = gain(cell.index * step, cutoff, self.rate_hz);
            let error =
                (1.0 - passed).powi(2) * (cell.power - cell.noise) + passed.powi(2) * cell.noise;
            error / cell.index.powi(2)
        };
        self.cells.iter().map(of).sum()
    }

    /// Whether anything moves that stands clear of the noise.
    fn moves(&self) -> bool {
        clear_until(&self.power, &self.noise) > 0
    }

    /// Up to here the motion stands clear of its noise, Hz, at most the cut-off.
    pub fn clear_hz(&self, cutoff_hz: f64) -> f64 {
        (clear_until(&self.power, &self.noise) as f64 * self.step()).min(cutoff_hz)
    }

    /// Variance of one sample of a channel whose noise is white with the power that it has at the cut-off.
    pub fn variance(&self, order: usize, cutoff_hz: f64) -> f64 {
        let own = self.of_channels.iter().find(|(o, _)| *o == order);
        let last = self.power.len().saturating_sub(1);
        let at = ((cutoff_hz / self.step()) as usize).max(1).min(last.max(1));
        let power = own
            .and_then(|(_, noise)| noise.get(at))
            .copied()
            .unwrap_or(0.0);
        let radians = TAU * cutoff_hz / self.rate_hz;
        let whole = power * self.scale * self.power.len() as f64;
        whole * radians.powi(2 * order as i32 - 4) * self.rate_hz.powi(2 * order as i32)
    }

    /// Noise of the acceleration at a frequency below the cut-off, of channels whose noise is white with the power that it
    /// has at the cut-off.
    fn white_noise(&self, frequency: f64, cutoff_hz: f64) -> f64 {
        let last = self.power.len().saturating_sub(1);
        let at = ((cutoff_hz / self.step()) as usize).max(1).min(last.max(1));
        let precision = self.of_channels.iter().map(|(order, noise)| {
            let power = noise.get(at).copied().unwrap_or(0.0);
            (power * (frequency / cutoff_hz).powi(4 - 2 * *order as i32)).recip()
        });
        precision.sum::<f64>().recip()
    }

    /// Standard deviations of the errors of position, velocity and acceleration behind a cut-off. Motion is what a
    /// band of frequencies has beyond its noise, where that is as much again: less is not told from it.
    pub fn deviations(&self, cutoff_hz: f64) -> [f64; 3] {
        let mut variances = [0.0; 3];
        let count = self.power.len();
        let mut low = CLEAR_OF_WINDOW.min(count);
        while low < count {
            let high = band_end(low, count);
            let sum = |series: &[f64]| series[low..high].iter().sum::<f64>();
            let moves = sum(&self.power) > 2.0 * sum(&self.noise);
            for f in low..high {
                let frequency = f as f64 * self.step();
                let passed = gain(frequency, cutoff_hz, self.rate_hz);
                let motion = if moves {
                    self.power[f] - self.noise[f]
                } else {
                    0.0
                };
                // The envelope bounds the noise; below the cut-off it is that of channels whose noise is white.
                let noise = self.noise[f].min(self.white_noise(frequency, cutoff_hz));
                let error = (1.0 - passed).powi(2) * motion + passed.powi(2) * noise;
                let radians = TAU * frequency / self.rate_hz;
                for (order, variance) in variances.iter_mut().enumerate() {
                    *variance += error * radians.powi(2 * order as i32 - 4);
                }
            }
            low = high;
        }
        [0, 1, 2].map(|order| {
            (self.scale * variances[order].max(0.0)).sqrt() * self.rate_hz.powi(order as i32)
        })
    }
}

/// The cut-offs of the joints of one recording, Hz: the common one, or the one given in its place, and those of joints
/// that clearly ask for another in the same ratio to it.
pub(super) fn choose_cutoffs(joints: &[MotionSpectrum], common_hz: Option<f64>) -> Vec<f64> {
    let Some(first) = joints.first() else {
        return Vec::new();
    };
    let highest = HIGHEST_CUTOFF * first.rate_hz;
    let cycles = LEAST_CYCLES * first.rate_hz / (2 * first.power.len()).max(1) as f64;
    let lowest = cycles.min(0.5 * highest);
    let ratio = (highest / lowest).powf(1.0 / (CANDIDATES - 1) as f64);
    let candidates: Vec<f64> = (0..CANDIDATES)
        .map(|i| lowest * ratio.powi(i as i32))
        .collect();
    let errors: Vec<Vec<f64>> = joints
        .iter()
        .map(|joint| {
            let error = |c: &f64| joint.error(*c).max(f64::MIN_POSITIVE);
            candidates.iter().map(error).collect()
        })
        .collect();
    let least = |values: &mut dyn Iterator<Item = f64>| -> usize {
        let all = values.enumerate();
        all.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(k, _)| k)
    };
    let moving: Vec<usize> = (0..joints.len()).filter(|&j| joints[j].moves()).collect();
    let product = |k: usize| moving.iter().map(|&j| errors[j][k].ln()).sum::<f64>();
    let common = least(&mut (0..CANDIDATES).map(product));
    let in_common = common_hz.unwrap_or(candidates[common]);
    let of = |j: usize| {
        let own = least(&mut errors[j].iter().copied());
        let clearly = moving.contains(&j) && errors[j][common] > CLEARLY * errors[j][own];
        let ratio = match clearly {
            true => candidates[own] / candidates[common],
            false => 1.0,
        };
        (ratio * in_common).min(highest)
    };
    (0..joints.len()).map(of).collect()
}

/// Whether recorded velocities are those of the positions, as far as the noise of both lets one see.
pub(in crate::recording) fn agree(
    position: &[f64],
    velocity: &[f64],
    rate_hz: f64,
    sampling: Sampling,
) -> bool {
    let [a, b] = [(position, 0), (velocity, 1)]
        .map(|(series, order)| spectrum(&Samples { series, order }, rate_hz));
    let power = |s: &[Complex<f64>]| s.iter().map(|c| c.norm_sqr()).collect::<Vec<f64>>();
    let (of_a, of_b) = (power(&a), power(&b));
    let noise = [&of_a, &of_b].map(|p| rising_envelope(p, sampling.noise_from()));
    let both: Vec<f64> = noise[0].iter().zip(&noise[1]).map(|(x, y)| x + y).collect();
    let clear = clear_until(&of_a, &both);
    let in_band = CLEAR_OF_WINDOW..clear.max(CLEAR_OF_WINDOW);
    let (mut differs, mut expected, mut moves) = (0.0, 0.0, 0.0);
    for f in in_band {
        differs += (a[f] - b[f]).norm_sqr();
        expected += both[f];
        moves += of_a[f];
    }
    differs <= 4.0 * expected + CONTRADICTS.powi(2) * moves
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

/// Fourier coefficients below half the rate of the windowed acceleration times the squared step, whose differences
/// have their gain and their half step made good.
fn spectrum(channel: &Samples<'_>, rate_hz: f64) -> Vec<Complex<f64>> {
    let step = rate_hz.recip();
    let x = channel.series;
    let n = x.len().saturating_sub(2);
    let mut samples: Vec<f64> = match channel.order {
        0 => x.windows(3).map(|w| w[2] - 2.0 * w[1] + w[0]).collect(),
        1 => x[..n + 1]
            .windows(2)
            .map(|w| (w[1] - w[0]) * step)
            .collect(),
        _ => x[1..=n].iter().map(|a| a * step * step).collect(),
    };
    let mean = samples.iter().sum::<f64>() / n as f64;
    for (k, value) in samples.iter_mut().enumerate() {
        *value = (*value - mean) * window(k, n);
    }
    let mut all = coefficients(&samples);
    all.truncate((n / 2).max(1));
    let count = all.len() as f64;
    for (f, c) in all.iter_mut().enumerate() {
        let half = 0.5 * PI * f as f64 / count;
        let lost = if half > 0.0 { half.sin() / half } else { 1.0 };
        *c *= match channel.order {
            0 => Complex::from(lost.powi(-2)),
            1 => Complex::from_polar(lost.recip(), half),
            _ => Complex::from(1.0),
        };
    }
    all
}

/// Hann squared, whose leakage falls with the fifth power of the distance: neither what the two ends differ by nor the
/// strong low frequencies may pass for high ones.
fn window(k: usize, n: usize) -> f64 {
    let hann = 0.5 * (1.0 - (TAU * (k as f64 + 0.5) / n as f64).cos());
    hann * hann
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

    /// Of two channels that show one motion the one with less noise counts.
    #[test]
    fn the_quieter_channel_is_looked_at() {
        let noise = |by: usize, size: f64| -> Vec<f64> {
            (0..600)
                .map(|k| size * ((k * k * by % 101) as f64 / 50.0 - 1.0))
                .collect()
        };
        let (position, velocity) = (noise(7919, 1.0), noise(6037, 1e-6));
        let channels =
            [(0, &position), (1, &velocity)].map(|(order, series)| Samples { series, order });
        let power = |channels: &[Samples<'_>]| {
            MotionSpectrum::of(channels, 100.0, Sampling::Recorded).power
        };
        assert_eq!(power(&channels), power(&channels[1..]));
        assert_ne!(power(&channels), power(&channels[..1]));
    }
}
