//! The noise of a signal whose motion does not repeat, from differences of samples that are close together.
//!
//! `Δ⁴x = x₋₂ − 4x₋₁ + 6x₀ − 4x₁ + x₂` of white noise has the variance 70 σ², and next to nothing of a motion that is sampled
//! finely (von Neumann 1941, for first differences). Dry friction jumps in a few samples, of which the median knows
//! nothing. The same differences of every second sample show whether the noise forgets from one sample to the next: where
//! it does not, nothing says how large it is within the band of the motion.

use crate::stats::robust::mad_scale;

/// Ratio of the deviations by every and by every second sample up to which noise is white: three deviations of that of a
/// thousand samples, and that of an autoregression of first order with a coefficient of a seventh.
const WHITE: f64 = 1.1;

/// Samples at least: the deviations are then within 4 % of one another.
const LEAST: usize = 500;

/// Standard deviation of the noise of one sample; `None` where it is not seen to be white.
pub(super) fn white_deviation(series: &[f64]) -> Option<f64> {
    let (near, far) = (by_differences(series, 1)?, by_differences(series, 2)?);
    (near > 0.0 && far <= WHITE * near).then_some(near)
}

/// Deviation of white noise by fourth differences of samples so far apart.
fn by_differences(series: &[f64], apart: usize) -> Option<f64> {
    if series.len() < LEAST {
        return None;
    }
    let difference =
        |x: &[f64]| x[0] - 4.0 * x[apart] + 6.0 * x[2 * apart] - 4.0 * x[3 * apart] + x[4 * apart];
    let all: Vec<f64> = series.windows(4 * apart + 1).map(difference).collect();
    mad_scale(&all).map(|deviation| deviation / 70.0_f64.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
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
        let found = white_deviation(&signal(0.0)).unwrap();
        // A median absolute deviation of 4000 normal samples is within 2 %, of dependent ones within 3 %.
        assert!((found / 0.1 - 1.0).abs() < 0.06, "{found}");
    }

    #[test]
    fn red_noise_is_not_taken_for_white() {
        for colour in [0.3, 0.9, 0.98] {
            assert_eq!(white_deviation(&signal(colour)), None);
        }
    }
}
