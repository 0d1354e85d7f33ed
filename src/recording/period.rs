//! The period of a recorded motion, where nobody has stated it.
//!
//! d(l) = Σ_j Σ_k (q_j(k) - q_j(k + l))² / (n - l) / (2 Var q) is near 1 for unrelated samples and 0
//! where the motion repeats; the least lag l at which it returns to its lowest level is the period.
//! Source: de Cheveigné and Kawahara (2002), eq. 6, for the pitch of speech.

use realfft::num_complex::Complex;

use crate::recording::columns::Recording;
use crate::recording::spectrum::{coefficients, synthesis};
use crate::recording::table::LEAST_ROWS;
use crate::recording::timing::{Grid, Timing, resample};

/// The motion must have left its start by this much of its variance before it can return.
const LEFT: f64 = 0.1;

/// A lag at which d falls below this is a repetition: a hundredth of the motion's power remains, as
/// noise and wandering from period to period.
const RETURNED: f64 = 0.01;

/// Of several repetitions the first whose d is within this of the best.
const AS_GOOD: f64 = 3.0;

/// A motion that repeats this well is averaged over its periods unasked: a hundredth of its amplitude, as
/// a controller and its encoders repeat a commanded motion.
const EXACT: f64 = 1e-4;

/// A period whose whole number of samples drifts by less than this many steps over the recording is that
/// whole number: controllers repeat a table of samples.
const WHOLE_STEPS: f64 = 0.05;

/// Samples to which a recording is thinned: periods need no more.
const MOST_SAMPLES: usize = 40_000;

/// A motion that repeats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repetition {
    /// s.
    pub period: f64,
    /// Share of the motion's power that changes from period to period, d at the period.
    pub changed: f64,
}

impl Repetition {
    /// Whether periods may be averaged: nothing but noise changes from one to the next.
    pub fn is_exact(&self) -> bool {
        self.changed <= EXACT
    }
}

/// How the motion of a recording repeats; None if it does not, or not twice.
pub fn find(recording: &Recording, timing: &Timing) -> Option<Repetition> {
    let (positions, rate_hz) = thinned(recording, timing);
    let found = of_positions(&positions, rate_hz)?;
    let exact = found.period * timing.rate_hz;
    if exact < LEAST_ROWS as f64 {
        return None;
    }
    let samples = recording.position.first().map_or(0, Vec::len);
    let drift = (exact.round() - exact).abs() * samples as f64 / exact;
    let period = match timing.uniform && drift <= WHOLE_STEPS {
        true => exact.round() / timing.rate_hz,
        false => found.period,
    };
    Some(Repetition { period, ..found })
}

/// Positions of a recording on an even grid of at most so many samples, with their rate in Hz.
pub fn thinned(recording: &Recording, timing: &Timing) -> (Vec<Vec<f64>>, f64) {
    let even = match (&recording.time, timing.uniform) {
        (Some(time), false) => {
            let grid = Grid::spanning(time, timing.rate_hz);
            resample(recording.clone(), grid).position
        }
        _ => recording.position.clone(),
    };
    let stride = even
        .first()
        .map_or(1, |q| q.len().div_ceil(MOST_SAMPLES))
        .max(1);
    let thin = |q: &Vec<f64>| q.iter().step_by(stride).copied().collect();
    (
        even.iter().map(thin).collect(),
        timing.rate_hz / stride as f64,
    )
}

/// How the positions `[j][k]` repeat; None if nothing repeats twice.
pub fn of_positions(positions: &[Vec<f64>], rate_hz: f64) -> Option<Repetition> {
    let d = differences(positions)?;
    let left = d.iter().position(|value| *value > LEFT)?;
    let inner = left.max(1)..d.len().saturating_sub(1);
    let minima: Vec<(f64, f64, f64)> = inner
        .filter(|&l| d[l] < RETURNED && d[l] <= d[l - 1] && d[l] <= d[l + 1])
        .map(|l| vertex(&d, l))
        .collect();
    // The curvature bounds what the parabola misses between lags, as noise bounds the depth.
    let best = minima.iter().map(|m| m.1 + VERTEX_ERROR * m.2);
    let best = best.fold(f64::INFINITY, f64::min);
    let (lag, value, curvature) = *minima.iter().find(|m| m.1 <= AS_GOOD * best)?;
    Some(Repetition {
        period: over_many(&d, lag) / rate_hz,
        changed: (value - VERTEX_ERROR * curvature).max(0.0),
    })
}

/// The lag of one period from that of as many as there are: what the vertex misses is divided by them.
fn over_many(d: &[f64], lag: f64) -> f64 {
    let (mut lag, mut count) = (lag, 1.0);
    loop {
        // Twice as far, what is missed so far is still within a step.
        let near = (2.0 * count * lag).round() as usize;
        let window = near.saturating_sub(1)..=near + 1;
        if *window.end() + 1 >= d.len() {
            return lag;
        }
        let Some(at) = window.min_by(|a, b| d[*a].total_cmp(&d[*b])) else {
            return lag;
        };
        if d[at] > d[at - 1] || d[at] > d[at + 1] || d[at] >= RETURNED {
            return lag;
        }
        count *= 2.0;
        lag = vertex(d, at).0 / count;
    }
}

/// A parabola through three lags is right at its vertex to this fraction of its curvature.
const VERTEX_ERROR: f64 = 1e-3;

/// Lag, value and curvature at the vertex of the parabola about a minimum.
fn vertex(d: &[f64], l: usize) -> (f64, f64, f64) {
    let curvature = (d[l - 1] - 2.0 * d[l] + d[l + 1]).max(ROUNDING);
    let slope = 0.5 * (d[l + 1] - d[l - 1]);
    let lag = l as f64 - slope / curvature;
    (lag, d[l] - 0.5 * slope * slope / curvature, curvature)
}

/// d below this is rounding of the transform, relative to the variance.
const ROUNDING: f64 = 1e-12;

/// d(l) for lags up to half the length; None if nothing moves.
fn differences(positions: &[Vec<f64>]) -> Option<Vec<f64>> {
    let n = positions.first()?.len();
    let mut sum = vec![0.0; n / 2 + 1];
    let mut variance = 0.0;
    for recorded in positions {
        let mean = recorded.iter().sum::<f64>() / n as f64;
        let series: Vec<f64> = recorded.iter().map(|q| q - mean).collect();
        variance += series.iter().map(|q| q * q).sum::<f64>() / n as f64;
        add_differences(&series, &mut sum);
    }
    let moves = variance > 0.0;
    sum.iter_mut().for_each(|d| *d /= 2.0 * variance);
    moves.then_some(sum)
}

/// Adds Σ_k (x(k) - x(k + l))² / (n - l) = (E(0, n-l) + E(l, n) - 2 R(l)) / (n - l) for each lag l.
fn add_differences(series: &[f64], sum: &mut [f64]) {
    let n = series.len();
    let padded = (n + sum.len()).next_power_of_two();
    let mut extended = series.to_vec();
    extended.resize(padded, 0.0);
    let power = coefficients(&extended)
        .into_iter()
        .map(|c| Complex::from(c.norm_sqr()));
    let correlation = synthesis(power.collect(), padded);
    let total: f64 = series.iter().map(|x| x * x).sum();
    let (mut head, mut tail) = (total, total);
    for (l, d) in sum.iter_mut().enumerate() {
        let squares = head + tail - 2.0 * correlation[l] * padded as f64;
        *d += squares.max(0.0) / (n - l) as f64;
        head -= series[n - 1 - l].powi(2);
        tail -= series[l].powi(2);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn motion(period: f64, harmonics: &[usize]) -> Vec<f64> {
        let of = |k: usize, h: usize| (TAU * h as f64 * k as f64 / period + h as f64).sin();
        (0..5000)
            .map(|k| harmonics.iter().map(|&h| of(k, h) / h as f64).sum())
            .collect()
    }

    #[test]
    fn recovers_known_period_between_samples() {
        // Two joints that repeat after a half and a third of the common period.
        let positions = [motion(1200.4, &[2, 4, 6]), motion(1200.4, &[3, 6])];
        let found = of_positions(&positions, 100.0).unwrap();
        // A parabola through the lowest three lags of a smooth minimum: within a hundredth of a step, over
        // the two periods that a lag of half the recording spans.
        assert!((found.period - 12.004).abs() < 0.5e-4, "{found:?}");
        assert!(found.is_exact(), "{found:?}");
    }

    #[test]
    fn finds_none_where_nothing_repeats() {
        let sweep: Vec<f64> = (0..5000).map(|k| ((k * k) as f64 * 1e-5).sin()).collect();
        assert_eq!(of_positions(&[sweep], 100.0), None);
        assert_eq!(of_positions(&[vec![1.0; 100]], 100.0), None);
        assert_eq!(of_positions(&[], 100.0), None);
    }

    #[test]
    fn recovers_known_share_that_changes_between_periods() {
        // Amplitudes 1, 1 + e, 1: the mean of (e sin)² over 2 Var q.
        let e = 0.05;
        let grown: Vec<f64> = (0..3000)
            .map(|k| {
                let size = if k / 1000 == 1 { 1.0 + e } else { 1.0 };
                size * (TAU * k as f64 / 1000.0).sin()
            })
            .collect();
        let found = of_positions(&[grown], 100.0).unwrap();
        let expected = 0.5 * e * e / ((2.0 + (1.0 + e) * (1.0 + e)) / 3.0);
        assert!((found.changed / expected - 1.0).abs() < 0.05, "{found:?}");
        assert!(!found.is_exact());
    }
}
