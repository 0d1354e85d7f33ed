//! Positions from a sensor of its own: in another file, at its own rate and with its own noise, on the same clock.
//!
//! The sensor's samples become positions at the times of the signal by the natural cubic spline through them, which
//! bends no more than a motion within half the sensor's rate does: what lies above is for the low-pass of the positions
//! (`recordings.differentiation`). Samples of the signal before the sensor's first or after its last are dropped.

use std::path::Path;

use crate::recording::column_map::ColumnMap;

use crate::recording::columns::{Parts, RecordedJoint, Recording, SignalKind, read_parts};
use crate::recording::error::RecordingError;
use crate::recording::table::require_rows;
use crate::recording::timing::{examine, stamps};

/// Reads the signal from one file and the positions of the joints from another, both with time stamps.
///
/// Errors: those of both files, time stamps that are missing or do not increase, no common time.
pub fn read_apart(
    (path, positions): (&Path, &Path),
    map: &ColumnMap,
    joints: &[RecordedJoint],
    kind: SignalKind,
) -> Result<Recording, RecordingError> {
    let mut recording = read_parts(path, map, joints, (kind, Parts::WithoutPosition))?;
    let sensor = read_parts(positions, map, joints, (kind, Parts::Position))?;
    examine(&sensor, None)?;
    let (time, knots) = (stamps(&recording)?, stamps(&sensor)?);
    let inside = |t: &f64| (knots[0]..=knots[knots.len() - 1]).contains(t);
    let kept: Vec<usize> = (0..time.len()).filter(|&k| inside(&time[k])).collect();
    require_rows(path, kept.len())?;
    let times: Vec<f64> = kept.iter().map(|&k| time[k]).collect();
    let splines = sensor.position.iter().map(|q| spline(knots, q, &times));
    let position = splines.collect();
    recording.keep(&kept);
    recording.position = position;
    Ok(recording)
}

impl Recording {
    /// Keeps some samples.
    pub(super) fn keep(&mut self, kept: &[usize]) {
        let pick = |series: &mut Vec<f64>| *series = kept.iter().map(|&k| series[k]).collect();
        let groups = [
            &mut self.velocity,
            &mut self.acceleration,
            &mut self.temperature,
        ];
        groups.into_iter().flatten().flatten().for_each(pick);
        self.position.iter_mut().for_each(pick);
        self.signal.iter_mut().for_each(pick);
        self.time.iter_mut().for_each(pick);
        if let Some(mask) = &mut self.mask {
            *mask = kept.iter().map(|&k| mask[k]).collect();
        }
        self.first_line += kept.first().copied().unwrap_or(0);
    }
}

/// The natural cubic spline through (knots, values) at increasing times between the first and the last knot:
/// s'' is linear between knots, zero at both ends, and makes s' continuous.
fn spline(knots: &[f64], values: &[f64], times: &[f64]) -> Vec<f64> {
    let bend = second_derivatives(knots, values);
    let mut at = 0;
    let mut out = Vec::with_capacity(times.len());
    for &t in times {
        while at + 2 < knots.len() && knots[at + 1] <= t {
            at += 1;
        }
        let step = knots[at + 1] - knots[at];
        let (a, b) = ((knots[at + 1] - t) / step, (t - knots[at]) / step);
        let curve = (a.powi(3) - a) * bend[at] + (b.powi(3) - b) * bend[at + 1];
        out.push(a * values[at] + b * values[at + 1] + curve * step * step / 6.0);
    }
    out
}

/// `h_k s''_k + 2 (h_k + h_{k+1}) s''_{k+1} + h_{k+1} s''_{k+2} = 6 (slope_{k+1} − slope_k)`, by elimination.
fn second_derivatives(knots: &[f64], values: &[f64]) -> Vec<f64> {
    let count = knots.len();
    let step = |k: usize| knots[k + 1] - knots[k];
    let slope = |k: usize| (values[k + 1] - values[k]) / step(k);
    let mut bend = vec![0.0; count];
    let mut share = vec![0.0; count];
    for k in 1..count.saturating_sub(1) {
        let pivot = 2.0 * (step(k - 1) + step(k)) - step(k - 1) * share[k - 1];
        share[k] = step(k) / pivot;
        bend[k] = (6.0 * (slope(k) - slope(k - 1)) - step(k - 1) * bend[k - 1]) / pivot;
    }
    for k in (1..count.saturating_sub(1)).rev() {
        bend[k] -= share[k] * bend[k + 1];
    }
    bend
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors of a natural spline fall with the fourth power of the step away from its ends.
    #[test]
    fn matches_a_smooth_motion_between_uneven_samples() {
        let worst = |rate: f64| {
            let knots: Vec<f64> = (0..(4.0 * rate) as usize)
                .map(|k| (k as f64 + 0.2 * (k as f64).sin()) / rate)
                .collect();
            let values: Vec<f64> = knots.iter().map(|t| (3.0 * t).sin()).collect();
            let times: Vec<f64> = (0..2000).map(|k| 1.0 + k as f64 / 1000.0).collect();
            let found = spline(&knots, &values, &times);
            let errors = found
                .iter()
                .zip(&times)
                .map(|(s, t)| (s - (3.0 * t).sin()).abs());
            errors.fold(0.0, f64::max)
        };
        // 5/384 h⁴ |q''''| with q'''' of 81 and steps of at most 1.4 of the mean.
        let bound = |rate: f64| 5.0 / 384.0 * (1.4 / rate).powi(4) * 81.0;
        for rate in [20.0, 40.0, 80.0] {
            assert!(worst(rate) < bound(rate), "{} at {rate} Hz", worst(rate));
        }
    }
}
