//! Detection of signals that were low-passed, or interpolated by curves, before they were logged.
//!
//! Dry friction jumps and its kinks make the spectrum of a signal fall by 12 dB in an octave at most, and noise of first order by 6;
//! beneath both lies the white noise of the converter, which falls no further. A low-pass of second order or more, and a spline
//! between samples, fall on and on. Where the spectrum falls by 30 dB within an octave well above the band of the motion, to which
//! rigid bodies answer with no more than its threefold, and has less left there than a converter of twelve bits makes, none but these
//! is left.

use crate::recording::series::interpolation::{Ends, fill};
use crate::recording::series::spectrum::{band_end, coefficients, noise_power};

/// Fall within an octave that neither friction nor noise has, dB.
const STEEP_DB: f64 = 30.0;

/// Fall within an octave of kinks of friction and of noise of first order together, dB: it is steeper from the cut-off on.
const NATURAL_DB: f64 = 18.0;

/// Multiple of the motion's band above which its torques have nothing: products of three motions have its threefold.
const ABOVE_MOTION: f64 = 4.0;

/// Bits of a converter whose noise of rounding a signal has at least, by its range.
const BITS: i32 = 12;

/// Share of the power of a speed that lies in the band of its motion.
const OF_MOTION: f64 = 0.99;

/// Fewest samples of which a spectrum has bands.
const LEAST: usize = 500;

/// A low-pass that a signal has behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass {
    /// From where on the spectrum falls more steeply than friction and noise do, Hz.
    pub cutoff_hz: f64,
    /// By how much it falls in its steepest octave, dB.
    pub fall_db: f64,
}

/// A band of a spectrum.
struct Band {
    /// Its upper end, Hz.
    high: f64,
    /// Median power, dB.
    level: f64,
}

/// The low-pass that a signal has behind it whose motion has a band in Hz; `None` where it has none.
pub fn low_pass(
    signal: &[f64],
    mask: Option<&[bool]>,
    rate_hz: f64,
    motion_hz: f64,
) -> Option<LowPass> {
    let mut series = signal.to_vec();
    if let Some(mask) = mask {
        fill(&mut series, mask, Ends::Held);
    }
    let bands = bands(&series, rate_hz)?;
    let fall = |k: usize| {
        let octave = bands[k..]
            .iter()
            .find(|band| band.high >= 2.0 * bands[k].high)?;
        Some(bands[k].level - octave.level)
    };
    let first = bands.partition_point(|band| band.high < ABOVE_MOTION * motion_hz);
    let falls = (first..bands.len()).map_while(|k| Some((k, fall(k)?)));
    let (steepest, fall_db) = falls.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let is_steep = |k: &usize| fall(*k).is_some_and(|fall| fall > NATURAL_DB);
    let cutoff = (first..=steepest).rev().take_while(is_steep).last()?;
    let above = bands[steepest..].iter().map(|band| band.level);
    let least = above.fold(f64::INFINITY, f64::min);
    (fall_db >= STEEP_DB && least < level_of_converter(&series)).then(|| LowPass {
        // The middle of the octave.
        cutoff_hz: std::f64::consts::SQRT_2 * bands[cutoff].high,
        fall_db,
    })
}

/// Bands of the spectrum of a series through Hann's window, which keeps what is strong out of what is weak.
fn bands(series: &[f64], rate_hz: f64) -> Option<Vec<Band>> {
    let powers = powers(series)?;
    let mut bands = Vec::new();
    let mut low = 1;
    while low < powers.len() {
        let end = band_end(low, powers.len());
        let power = noise_power(&mut powers[low..end].to_vec(), 1.0);
        bands.push(Band {
            high: end as f64 * rate_hz / series.len() as f64,
            level: 10.0 * power.max(f64::MIN_POSITIVE).log10(),
        });
        low = end;
    }
    Some(bands)
}

/// Level of the rounding by a converter that has the range of a series, dB. Hann's window has the mean square 3/8.
fn level_of_converter(series: &[f64]) -> f64 {
    let low = series.iter().copied().fold(f64::INFINITY, f64::min);
    let high = series.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let step = (high - low) / 2f64.powi(BITS);
    10.0 * (3.0 / 8.0 * step * step / 12.0 / series.len() as f64).log10()
}

/// Powers of a series less the line between its ends.
fn powers(series: &[f64]) -> Option<Vec<f64>> {
    let count = series.len();
    if count < LEAST {
        return None;
    }
    let (first, last) = (series[0], series[count - 1]);
    let windowed = series.iter().enumerate().map(|(k, x)| {
        let share = k as f64 / (count - 1) as f64;
        let window = (std::f64::consts::PI * share).sin().powi(2);
        window * (x - first - share * (last - first))
    });
    let all = coefficients(&windowed.collect::<Vec<f64>>());
    Some(all.iter().map(|c| c.norm_sqr()).collect())
}

/// The frequency below which a motion with this speed lies, Hz; 0 of too few rows.
pub fn band_of_motion(speed: &[f64], rate_hz: f64) -> f64 {
    let powers = powers(speed).unwrap_or_default();
    let total: f64 = powers.iter().sum();
    let mut sum = 0.0;
    let below = powers.iter().take_while(|power| {
        sum += *power;
        sum < OF_MOTION * total
    });
    (below.count() + 1) as f64 * rate_hz / speed.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::series::spline::Spline;
    use crate::recording::series::zero_phase::ZeroPhase;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const RATE: f64 = 100.0;
    const ROWS: usize = 3000;

    fn speed() -> Vec<f64> {
        let at = |k: usize| {
            let t = k as f64 / RATE;
            (2.0 * t).cos() + 0.6 * (3.7 * t + 1.0).cos()
        };
        (0..ROWS).map(at).collect()
    }

    /// Torques with dry friction, and noise of a deviation with a colour.
    fn signal(noise: f64, colour: f64) -> Vec<f64> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let mut slow = 0.0;
        let torque = |v: f64| 2.0 * v + v * v + v / (v.abs() + 0.02);
        let with_noise = |v: &f64| {
            let drawn: f64 = StandardNormal.sample(&mut random);
            slow = colour * slow + (1.0 - colour * colour).sqrt() * drawn;
            torque(*v) + noise * slow
        };
        speed().iter().map(with_noise).collect()
    }

    fn found(signal: &[f64], rate: f64) -> Option<LowPass> {
        low_pass(signal, None, rate, band_of_motion(&speed(), RATE))
    }

    #[test]
    fn recovers_the_band_of_a_motion() {
        let band = band_of_motion(&speed(), RATE);
        assert!((band - 3.7 / std::f64::consts::TAU).abs() < 0.1, "{band}");
    }

    #[test]
    fn recovers_a_low_pass_before_the_log() {
        for cutoff in [5.0, 10.0, 20.0] {
            for colour in [0.0, 0.9] {
                let mut filtered = signal(0.05, colour);
                ZeroPhase::new(cutoff, RATE).unwrap().apply(&mut filtered);
                filtered
                    .iter_mut()
                    .for_each(|x| *x = (*x * 1e5).round() / 1e5);
                let found = found(&filtered, RATE).unwrap();
                let ratio = found.cutoff_hz / cutoff;
                assert!((0.5..1.5).contains(&ratio), "{cutoff}, {colour}: {found:?}");
            }
        }
    }

    #[test]
    fn honest_signals_have_none() {
        for noise in [0.0, 0.001, 0.05, 0.5] {
            for colour in [0.0, 0.9, 0.98, 0.999] {
                assert_eq!(
                    found(&signal(noise, colour), RATE),
                    None,
                    "{noise}, {colour}"
                );
            }
        }
    }

    /// Without friction a spectrum falls from the end of the motion's band to the noise at once.
    #[test]
    fn the_end_of_the_motion_is_no_filter() {
        let smooth = |k: usize| -> f64 {
            let t = k as f64 / RATE;
            (0..60)
                .map(|h| (0.45 * f64::from(h) * t + f64::from(h * h)).sin())
                .sum()
        };
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(9);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        for noise in [0.01, 0.1, 1.0] {
            let series: Vec<f64> = (0..ROWS).map(|k| smooth(k) + noise * draw()).collect();
            assert_eq!(found(&series, RATE), None, "{noise}");
        }
    }

    #[test]
    fn recovers_curves_between_samples() {
        let samples = signal(0.05, 0.0);
        let knots: Vec<f64> = (0..ROWS).map(|k| k as f64).collect();
        let times: Vec<f64> = (0..5 * (ROWS - 1)).map(|m| m as f64 / 5.0).collect();
        let written = Spline::new(&knots, &samples).at(&times);
        assert!(found(&written, 5.0 * RATE).is_some());
    }
}
