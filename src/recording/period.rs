//! The period of a recorded motion, where nobody has stated it.
//!
//! d(l) = Σ_j Σ_k (q_j(k) - q_j(k + l))² / (n - l) / (2 Var q) is near 1 for unrelated samples and 0
//! where the motion repeats; the least lag l at which it returns to its lowest level is the period.
//! Source: de Cheveigné and Kawahara (2002), eq. 6, for the pitch of speech.

use realfft::num_complex::Complex;

use crate::recording::spectrum::{coefficients, synthesis};

/// The motion must have left its start by this much of its variance before it can return.
const LEFT: f64 = 0.1;

/// A lag at which d falls below this is a repetition: a hundredth of the motion's power remains, as
/// noise and wandering from period to period.
const RETURNED: f64 = 0.01;

/// Of several repetitions the first whose d is within this of the best.
const AS_GOOD: f64 = 3.0;

/// Period of the positions `[j][k]`, in seconds; None if nothing repeats twice.
pub fn detect_period(positions: &[Vec<f64>], rate_hz: f64) -> Option<f64> {
    let d = repetition(positions)?;
    let left = d.iter().position(|value| *value > LEFT)?;
    let inner = left.max(1)..d.len().saturating_sub(1);
    let minima: Vec<(f64, f64, f64)> = inner
        .filter(|&l| d[l] < RETURNED && d[l] <= d[l - 1] && d[l] <= d[l + 1])
        .map(|l| vertex(&d, l))
        .collect();
    // The curvature bounds what the parabola misses between lags, as noise bounds the depth.
    let best = minima.iter().map(|m| m.1 + VERTEX_ERROR * m.2);
    let best = best.fold(f64::INFINITY, f64::min);
    let (lag, ..) = minima.iter().find(|m| m.1 <= AS_GOOD * best)?;
    Some(lag / rate_hz)
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
fn repetition(positions: &[Vec<f64>]) -> Option<Vec<f64>> {
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
        let period = detect_period(&positions, 100.0).unwrap();
        // A parabola through the lowest three lags of a smooth minimum: within a hundredth of a step.
        assert!((period - 12.004).abs() < 1e-4, "{period}");
    }

    #[test]
    fn finds_none_where_nothing_repeats() {
        let sweep: Vec<f64> = (0..5000).map(|k| ((k * k) as f64 * 1e-5).sin()).collect();
        assert_eq!(detect_period(&[sweep], 100.0), None);
        assert_eq!(detect_period(&[vec![1.0; 100]], 100.0), None);
        assert_eq!(detect_period(&[], 100.0), None);
    }
}
