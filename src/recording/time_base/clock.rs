//! Time stamps that jitter about the even clock by which the samples were taken.
//!
//! With stamps t_k = c_k + e_k about a clock c_k, a motion is q(c_k) if the samples were taken by the clock and
//! q(c_k) + q̇ e_k if they were taken when they were stamped. Fourth differences hardly contain the motion, so
//!
//! ```text
//! Δ⁴q = β Δ⁴(q̇ e) + noise,    β = 0: by the clock,    β = 1: by the stamps.
//! ```

use crate::recording::channels::samples::Recording;
use crate::recording::series::differences::{fourth, steps};
use crate::recording::time_base::timing::{GAP_STEPS, UNIFORM_STEPS};
use crate::stats::robust::median;

/// Samples on both sides of a long step that show whether stamps come late or samples are missing.
const BESIDE: usize = 15;

/// Samples on both sides over which a clock is steady: it follows drift that lasts for seconds.
const STEADY: usize = 250;

/// Samples on both sides of the difference that gives a speed; the counts of an encoder are then small beside it.
const SPEED_SPAN: usize = 5;

/// Deviations of the estimate of β that it has to be from one half. Fourth differences of white noise are dependent, which
/// makes its deviation up to three times that of independent ones.
const SURE: f64 = 15.0;

/// Keeps the clock of a recording whose stamps jitter about it.
pub fn evened(mut recording: Recording) -> Recording {
    let Some(time) = &recording.time else {
        return recording;
    };
    let Some(clock) = Clock::of(time) else {
        return recording;
    };
    let squares: f64 = clock.errors.iter().map(|e| e * e).sum();
    let jitter = (squares / clock.errors.len() as f64).sqrt();
    if jitter > UNIFORM_STEPS * clock.step && clock.was_kept(&recording.position) {
        let even = time.iter().zip(&clock.errors).map(|(t, e)| t - e);
        let even: Vec<f64> = even.collect();
        if even.windows(2).all(|pair| pair[1] > pair[0]) {
            recording.time = Some(even);
            recording.stamp_jitter = Some(jitter);
        }
    }
    recording
}

/// What a reader of any result should know of a clock that is used in the place of stamps.
pub(in crate::recording) fn words(recording: &Recording, rate_hz: f64) -> Option<String> {
    let jitter = recording.stamp_jitter?;
    Some(format!(
        "The time stamps of {} scatter by {:.3} ms about an even clock of {rate_hz:.4} Hz. The motion is smooth by the clock and \
         not by the stamps, so the clock is used.",
        recording.file.display(),
        1e3 * jitter
    ))
}

/// An even clock through stamps.
struct Clock {
    /// s.
    step: f64,
    /// Stamps less the clock, s.
    errors: Vec<f64>,
    /// First samples after gaps, and the number of samples.
    ends: Vec<usize>,
}

impl Clock {
    /// `None` for stamps that do not increase, or of too few samples.
    fn of(time: &[f64]) -> Option<Self> {
        let steps = steps(time);
        let usual = median(&steps)?;
        if time.len() < 2 * STEADY || steps.iter().any(|step| *step <= 0.0) {
            return None;
        }
        let ends = segments(time, usual);
        let step = slope(time, &ends)?;
        let mut errors = Vec::with_capacity(time.len());
        let mut begin = 0;
        for &end in &ends {
            let error = |k: usize| time[k] - time[begin] - step * (k - begin) as f64;
            let mut sums = vec![0.0];
            for k in begin..end {
                sums.push(sums[k - begin] + error(k));
            }
            errors.extend((begin..end).map(|k| {
                let near = [
                    k.saturating_sub(STEADY).max(begin) - begin,
                    (k + STEADY + 1).min(end) - begin,
                ];
                error(k) - (sums[near[1]] - sums[near[0]]) / (near[1] - near[0]) as f64
            }));
            begin = end;
        }
        Some(Self { step, errors, ends })
    }

    /// Whether the samples were taken by the clock.
    fn was_kept(&self, positions: &[Vec<f64>]) -> bool {
        let (mut weighted, mut squares) = (0.0, 0.0);
        for q in positions {
            let (found, made) = self.bends(q);
            let noise = found.iter().map(|x| x * x).sum::<f64>() / found.len().max(1) as f64;
            if noise > 0.0 {
                let products = found.iter().zip(&made).map(|(x, y)| x * y);
                weighted += products.sum::<f64>() / noise;
                squares += made.iter().map(|y| y * y).sum::<f64>() / noise;
            }
        }
        squares > 0.0 && weighted / squares + SURE / squares.sqrt() < 0.5
    }

    /// Fourth differences of a position, and those that jitter would have made.
    fn bends(&self, q: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut bends = (Vec::new(), Vec::new());
        let mut begin = 0;
        for &end in &self.ends {
            let inner = begin + SPEED_SPAN..end.saturating_sub(SPEED_SPAN);
            let span = 2.0 * SPEED_SPAN as f64 * self.step;
            let speed = |k: usize| (q[k + SPEED_SPAN] - q[k - SPEED_SPAN]) / span;
            let made: Vec<f64> = inner.clone().map(|k| speed(k) * self.errors[k]).collect();
            let moved = q.get(inner).unwrap_or_default();
            bends.0.extend(moved.windows(5).map(|x| fourth(x, 1)));
            bends.1.extend(made.windows(5).map(|x| fourth(x, 1)));
            begin = end;
        }
        bends
    }
}

/// Where parts without a gap end. After a long step the stamps of a part that goes on catch up with its clock; where samples
/// are missing they stay behind.
fn segments(time: &[f64], step: f64) -> Vec<usize> {
    let mut ends = Vec::new();
    for k in 1..time.len() {
        if time[k] - time[k - 1] <= GAP_STEPS * step {
            continue;
        }
        let behind = |range: std::ops::Range<usize>| {
            let errors: Vec<f64> = range.map(|i| time[i] - step * i as f64).collect();
            median(&errors).unwrap_or(0.0)
        };
        let before = behind(k.saturating_sub(BESIDE)..k);
        let after = behind(k..(k + BESIDE).min(time.len()));
        if after - before > 0.5 * step {
            ends.push(k);
        }
    }
    ends.push(time.len());
    ends
}

/// Mean step of the longest part without a gap, by least squares.
fn slope(time: &[f64], ends: &[usize]) -> Option<f64> {
    let begins = [0].into_iter().chain(ends.iter().copied());
    let (begin, end) = begins
        .zip(ends.iter().copied())
        .max_by_key(|(b, e)| e - b)?;
    let part = &time[begin..end];
    let middle = 0.5 * (part.len() as f64 - 1.0);
    let mean = part.iter().sum::<f64>() / part.len() as f64;
    let products = part.iter().enumerate();
    let products: f64 = products
        .map(|(k, t)| (k as f64 - middle) * (t - mean))
        .sum();
    let squares: f64 = (0..part.len()).map(|k| (k as f64 - middle).powi(2)).sum();
    (squares > 0.0).then(|| products / squares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    const STEP: f64 = 0.01;
    const COUNTS: f64 = 65536.0 / std::f64::consts::TAU;

    /// Clock and stamps with a jitter of 4 ms to both sides.
    fn stamps(seed: u64) -> (Vec<f64>, Vec<f64>) {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let even: Vec<f64> = (0..3000).map(|k| STEP * f64::from(k)).collect();
        let jitter = even
            .iter()
            .map(|t| t + 0.008 * (random.random::<f64>() - 0.5));
        let stamps = jitter.collect();
        (even, stamps)
    }

    fn recording(stamps: Vec<f64>, taken: &[f64]) -> Recording {
        let angle = |t: &f64| ((1.3 * t).sin() + 0.4 * (3.1 * t).cos()) * COUNTS;
        let position: Vec<f64> = taken.iter().map(|t| angle(t).round() / COUNTS).collect();
        Recording {
            time: Some(stamps),
            ..Recording::of_samples("made.csv", vec![position.clone()], vec![position])
        }
    }

    #[test]
    fn recovers_the_clock_that_stamps_jitter_about() {
        let (even, stamps) = stamps(1);
        let found = evened(recording(stamps, &even));
        // 8 ms / √12, and the mean of 501 of them.
        assert!((found.stamp_jitter.unwrap() / 0.0023 - 1.0).abs() < 0.1);
        let time = found.time.unwrap();
        let inner = (300..2700).map(|k| (time[k] - even[k]).abs());
        assert!(inner.fold(0.0, f64::max) < 5e-4);
    }

    #[test]
    fn stamps_of_samples_that_came_unevenly_are_kept() {
        let (_, stamps) = stamps(2);
        let found = evened(recording(stamps.clone(), &stamps));
        assert_eq!((found.stamp_jitter, found.time), (None, Some(stamps)));
    }

    #[test]
    fn gaps_are_kept() {
        let (even, stamps) = stamps(3);
        let kept: Vec<usize> = (0..3000).filter(|k| !(1500..1520).contains(k)).collect();
        let pick = |of: &[f64]| kept.iter().map(|&k| of[k]).collect::<Vec<f64>>();
        let even = pick(&even);
        let time = evened(recording(pick(&stamps), &even)).time.unwrap();
        assert!((time[1500] - time[1499] - 21.0 * STEP).abs() < 0.8 * STEP);
        assert!((time[2000] - even[2000]).abs() < 5e-4);
    }

    #[test]
    fn rest_tells_nothing() {
        let (_, stamps) = stamps(4);
        let mut rest = recording(stamps, &[0.0; 3000]);
        rest.position[0].fill(1.0);
        assert_eq!(evened(rest).stamp_jitter, None);
    }
}
