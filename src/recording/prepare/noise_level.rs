//! The noise of a signal whose motion does not repeat, from differences of samples that are close together.
//!
//! `Δ⁴x = x₋₂ − 4x₋₁ + 6x₀ − 4x₁ + x₂` of white noise has the variance 70 σ², and next to nothing of a motion that is sampled
//! finely (von Neumann 1941, for first differences). Dry friction jumps in a few samples, of which the median knows
//! nothing. The same differences of every second sample show whether the noise forgets from one sample to the next: where
//! it does not, nothing says how large it is within the band of the motion.
//!
//! A signal in steps h of a converter has fourth differences that are whole numbers of steps, whose quantiles are those of
//! grouped data: each number stands for all values within half a step. Rounding adds h²/12 to the variance, which is white
//! where the noise carries the signal over several steps, and follows the motion where it does not.

use crate::recording::series::differences::fourth;
use crate::stats::robust::normal_scale;

/// Ratio of the deviations by every and by every second sample up to which noise is white: three deviations of that of a
/// thousand samples, and that of an autoregression of first order with a coefficient of a seventh.
const WHITE: f64 = 1.1;

/// Samples at least: the deviations are then within 4 % of one another.
const LEAST: usize = 500;

/// Differences of a series in steps are whole numbers of them but for rounding to double precision, or to nine digits.
const WHOLE: f64 = 1e-3;

/// The pieces of a series between the samples that a mask leaves out: what bridges these has no noise.
pub fn pieces<'a>(series: &'a [f64], mask: Option<&[bool]>) -> Vec<&'a [f64]> {
    let Some(mask) = mask else {
        return vec![series];
    };
    let mut end = 0;
    let runs = mask.chunk_by(|a, b| a == b).filter_map(|run| {
        let start = end;
        end += run.len();
        run[0].then(|| &series[start..end])
    });
    runs.collect()
}

/// Standard deviation of the noise of one sample of the pieces of a series; `None` where it is not seen to be white.
pub fn white_deviation(pieces: &[&[f64]]) -> Option<f64> {
    if hiding_step(pieces).is_some() {
        return None;
    }
    let step = least_step(pieces).unwrap_or(0.0);
    let near = by_differences(pieces, 1, step)?;
    let far = by_differences(pieces, 2, step)?;
    (near > 0.0 && far <= WHITE * near).then_some(near)
}

/// The step of a signal that comes in steps so coarse that its noise is lost in their rounding, unit of the signal.
pub fn hiding_step(pieces: &[&[f64]]) -> Option<f64> {
    let step = least_step(pieces)?;
    let deviation = by_differences(pieces, 1, step)?;
    // The deviation holds that of rounding, which without noise is all there is.
    (deviation < (2.0_f64 / 12.0).sqrt() * step).then_some(step)
}

/// The step that all differences of successive samples are whole numbers of; `None` where there is none.
fn least_step(pieces: &[&[f64]]) -> Option<f64> {
    let pairs = || pieces.iter().flat_map(|piece| piece.windows(2));
    let differences = || pairs().map(|pair| (pair[1] - pair[0]).abs());
    let samples = pieces.iter().copied().flatten();
    let size = samples.fold(0.0_f64, |most, x| most.max(x.abs()));
    let least = differences()
        .filter(|d| *d > 1e-9 * size)
        .fold(f64::INFINITY, f64::min);
    let is_whole = |d: f64| (d / least - (d / least).round()).abs() <= WHOLE * (1.0 + d / least);
    (least.is_finite() && differences().all(is_whole)).then_some(least)
}

/// Deviation of white noise by fourth differences, whole numbers of a step, of samples so far apart.
fn by_differences(pieces: &[&[f64]], apart: usize, step: f64) -> Option<f64> {
    let windows = pieces.iter().flat_map(|piece| piece.windows(4 * apart + 1));
    let mut sizes: Vec<f64> = windows.map(|x| fourth(x, apart).abs()).collect();
    if sizes.len() + 4 * apart < LEAST {
        return None;
    }
    sizes.sort_unstable_by(f64::total_cmp);
    let median = grouped_median(&sizes, step);
    Some(normal_scale(median) / 70.0_f64.sqrt())
}

/// Median of sorted sizes that each stand for all within half a step of them, none below zero.
fn grouped_median(sorted: &[f64], step: f64) -> f64 {
    let half = 0.5 * sorted.len() as f64;
    let value = sorted[sorted.len() / 2];
    let below = sorted.partition_point(|x| *x < value - 0.5 * step);
    let alike = sorted.partition_point(|x| *x <= value + 0.5 * step) - below;
    let (low, high) = ((value - 0.5 * step).max(0.0), value + 0.5 * step);
    low + (high - low) * (half - below as f64) / alike.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::series::interpolation::{Ends, fill};
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use std::f64::consts::TAU;

    fn signal(colour: f64) -> Vec<f64> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(8);
        let mut noise = 0.0;
        let root = (1.0 - colour * colour).sqrt();
        (0..4000)
            .map(|k| {
                let t = k as f64 / 100.0;
                let drawn: f64 = StandardNormal.sample(&mut random);
                noise = colour * noise + root * drawn;
                let speed = (TAU * 0.4 * t).sin();
                3.0 * speed.signum() + speed + 0.1 * noise
            })
            .collect()
    }

    #[test]
    fn recovers_known_noise_beside_dry_friction() {
        let found = white_deviation(&[&signal(0.0)]).unwrap();
        // A median absolute deviation of 4000 normal samples is within 2 %, of dependent ones within 3 %.
        assert!((found / 0.1 - 1.0).abs() < 0.06, "{found}");
    }

    #[test]
    fn recovers_known_noise_in_coarse_steps() {
        for step in [0.02, 0.1, 0.2] {
            let stepped: Vec<f64> = (signal(0.0).iter())
                .map(|x| (x / step).round() * step)
                .collect();
            let expected = (0.01 + step * step / 12.0).sqrt();
            let found = by_differences(&[&stepped], 1, step).unwrap();
            assert!((found / expected - 1.0).abs() < 0.06, "{step}: {found}");
            assert_eq!(hiding_step(&[&stepped]), None);
        }
    }

    #[test]
    fn steps_that_hide_the_noise_tell_none() {
        let stepped: Vec<f64> = (signal(0.0).iter())
            .map(|x| (x / 0.5_f64).round() * 0.5)
            .collect();
        assert_eq!(white_deviation(&[&stepped]), None);
        assert_eq!(hiding_step(&[&stepped]), Some(0.5));
        assert_eq!(hiding_step(&[&signal(0.0)]), None);
    }

    #[test]
    fn red_noise_is_not_taken_for_white() {
        for colour in [0.3, 0.9, 0.98] {
            assert_eq!(white_deviation(&[&signal(colour)]), None);
        }
    }

    #[test]
    fn lines_over_samples_that_are_left_out_are_no_noise() {
        let mask: Vec<bool> = (0..4000).map(|k| k % 100 < 40).collect();
        let mut bridged = signal(0.0);
        fill(&mut bridged, &mask, Ends::Held);
        let found = white_deviation(&pieces(&bridged, Some(&mask))).unwrap();
        assert!((found / 0.1 - 1.0).abs() < 0.1, "{found}");
        assert_eq!(white_deviation(&pieces(&bridged, None)), None);
    }
}
