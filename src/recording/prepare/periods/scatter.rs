//! The noise of recorded samples where no whole number of them is a period: how each differs from what the periods beside it have
//! at the same phase,
//!
//! ```text
//! e(t) = y(t) − (1/M) Σ_m ŷ(t + m T),    Var e = σ² (1 + g / M),
//! ```
//!
//! with ŷ by cubics between samples, which leave the share g of the variance of noise.

use crate::recording::channels::samples::Recording;
use crate::recording::prepare::experiment::Noise;
use crate::recording::prepare::periods::row_noise::Scatter;
use crate::recording::series::interpolation::{Stencil, brackets};
use crate::recording::series::zero_phase::ZeroPhase;

/// Periods beside a sample, on either side, with which it is compared: the mean of eight adds a sixteenth to the deviation of what
/// differs from it.
const BESIDE: i32 = 4;

/// Noise of one sample of a motion that repeats after `period` s, of samples at these times; `None` of less than two periods.
pub(in crate::recording) fn noise(
    recording: &Recording,
    time: &[f64],
    period: f64,
    parallel: Option<&ZeroPhase>,
) -> Option<Noise> {
    let others = Others::new(recording, time, period)?;
    let scatter = |channels: &[Vec<f64>]| -> Vec<Vec<f64>> {
        channels.iter().map(|s| others.scatter(s)).collect()
    };
    let mut signal = scatter(&recording.signal);
    if let Some(filter) = parallel {
        signal.iter_mut().for_each(|series| filter.apply(series));
    }
    let of_samples = Scatter {
        signal,
        position: scatter(&recording.position),
        divisor: others.counted(),
        degrees: others.degrees(),
        averaged: 1.0,
        period,
        samples: (time.len() as f64 / others.periods) as usize,
    };
    Some(of_samples.noise())
}

/// What other periods have at the phase of every sample.
struct Others {
    /// Of every sample; none of a sample that does not count.
    stencils: Vec<Vec<Stencil>>,
    /// In the recording.
    periods: f64,
}

impl Others {
    fn new(recording: &Recording, time: &[f64], period: f64) -> Option<Self> {
        let (first, last) = (time[0], time[time.len() - 1]);
        let periods = (last - first) / period;
        if periods < 2.0 {
            return None;
        }
        let mask = recording.signal_mask();
        let counts = |k: usize| mask.as_ref().is_none_or(|mask| mask[k]);
        let mut stencils: Vec<Vec<Stencil>> = vec![Vec::new(); time.len()];
        for m in (-BESIDE..=BESIDE).filter(|m| *m != 0) {
            let shift = f64::from(m) * period;
            let there = |k: &usize| (first..=last).contains(&(time[*k] + shift));
            let samples: Vec<usize> = (0..time.len()).filter(there).collect();
            let times: Vec<f64> = samples.iter().map(|&k| time[k] + shift).collect();
            for (&k, at) in samples.iter().zip(brackets(time, &times)) {
                if counts(k) && counts(at.before) && counts(at.before + 1) {
                    stencils[k].push(Stencil::at(time, at));
                }
            }
        }
        let others = Self { stencils, periods };
        (others.counted() > 0.0).then_some(others)
    }

    /// Samples that have others.
    fn counted(&self) -> f64 {
        self.stencils.iter().filter(|s| !s.is_empty()).count() as f64
    }

    /// Degrees of freedom: M samples of M + 1 are free of their mean.
    fn degrees(&self) -> f64 {
        let shares = self.stencils.iter().map(|s| s.len() as f64);
        shares.map(|m| m / (m + 1.0)).sum()
    }

    /// e over the root of 1 + g / M; 0 of samples that do not count. Of white noise g is that of the weights, of slow noise 1: the
    /// middle of both is within a twentieth of either.
    fn scatter(&self, series: &[f64]) -> Vec<f64> {
        let of = |(value, stencils): (&f64, &Vec<Stencil>)| {
            if stencils.is_empty() {
                return 0.0;
            }
            let m = stencils.len() as f64;
            let mean = stencils.iter().map(|s| s.of(series)).sum::<f64>() / m;
            let white = stencils.iter().map(Stencil::variance).sum::<f64>() / m;
            (value - mean) / (1.0 + 0.5 * (1.0 + white) / m).sqrt()
        };
        series.iter().zip(&self.stencils).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use std::f64::consts::TAU;

    /// White noise, and noise of which 0.95 stays from sample to sample, on a motion that repeats after 1000.46 samples.
    #[test]
    fn recovers_known_noise_of_samples() {
        let (rate, rows) = (100.0, 5200);
        let period = 10.0046;
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(11);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let time: Vec<f64> = (0..rows).map(|k| f64::from(k) / rate).collect();
        let clean = |t: f64| (TAU * t / period).sin() + 0.2 * (TAU * 7.0 * t / period).cos();
        let white: Vec<f64> = time.iter().map(|t| clean(*t) + 0.1 * draw()).collect();
        let mut red = 0.0;
        let slow: Vec<f64> = time
            .iter()
            .map(|t| {
                red = 0.95 * red + 0.1 * draw();
                clean(*t) + red
            })
            .collect();
        let position = time.iter().map(|t| clean(*t)).collect();
        let recording = Recording::of_samples("made.csv", vec![position], vec![white, slow]);
        let noise = noise(&recording, &time, period, None).unwrap();
        let deviation = |c: usize| noise.signal_covariance[(c, c)].sqrt();
        // Of 5200 samples, and of about 5200 (1 − 0.95) / (1 + 0.95) = 130 independent ones.
        assert!((deviation(0) / 0.1 - 1.0).abs() < 0.05, "{}", deviation(0));
        let exact = 0.1 / (1.0_f64 - 0.95 * 0.95).sqrt();
        assert!((deviation(1) / exact - 1.0).abs() < 0.2, "{}", deviation(1));
        let lag = |c: usize, l: usize| noise.autocovariance[c][l] / noise.autocovariance[c][0];
        assert!(lag(0, 1).abs() < 0.06 && (lag(1, 1) - 0.95).abs() < 0.02);
        assert!(noise.recorded_position_sd[0] < 1e-6);
        assert!(noise.degrees > 0.7 * f64::from(rows) && noise.degrees < f64::from(rows));
    }
}
