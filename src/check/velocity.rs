//! A recorded velocity against the position: `q(t + T) − q(t) = f ∫ q̇ dt` with f = 1.
//!
//! Integrals instead of derivatives: the quantum of an encoder stays one quantum, whatever the rate.

use crate::check::context::RawRecording;
use crate::check::report::finding;
use crate::check::units::DEGREES;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use crate::recording::spikes::quantum;
use crate::stats::deviation::rms;

/// Length T of the integrals, s: longer than the delay of a filter of velocities, shorter than a swing.
const WINDOW_S: f64 = 0.1;

/// Correlation of the two sides from which they are the same motion.
const SAME: f64 = 0.9;

/// Share by which f may miss 1: above what interpolation and filters of velocities do.
const FACTOR_TOLERANCE: f64 = 0.05;

/// Root mean square change of position over T, in quanta of the position, from which f means something.
const LEAST_QUANTA: f64 = 10.0;

/// Known reasons for a factor.
const REASONS: &[(f64, &str, &str)] = &[
    (
        DEGREES,
        "the position is in degrees, or",
        "give positions in radians",
    ),
    (
        1.0 / DEGREES,
        "the velocity is in degrees per second, or",
        "give velocities in rad/s",
    ),
    (
        -1.0,
        "one of the two has the wrong sign, or",
        "give both the sign of the robot's joint",
    ),
    (
        std::f64::consts::TAU / 60.0,
        "the velocity is in turns per minute, or",
        "give velocities in rad/s",
    ),
    (
        1e3,
        "the time is in milliseconds, or",
        "give time in seconds",
    ),
    (
        1e-3,
        "time or position is a thousand times too small, or",
        "give SI units",
    ),
];

pub(super) fn check(read: &RawRecording<'_>) -> Vec<Mistake> {
    let Some(velocity) = &read.recording.velocity else {
        return Vec::new();
    };
    let changes: Vec<Vec<f64>> = read
        .recording
        .position
        .iter()
        .map(|q| changes(read, q))
        .collect();
    let integrals: Vec<Vec<f64>> = velocity.iter().map(|v| integrals(read, v)).collect();
    let moves = |j: &usize| {
        let rms = rms(&changes[*j]);
        rms > LEAST_QUANTA * quantum(&read.recording.position[*j]) && rms > 0.0
    };
    let judged: Vec<usize> = (0..changes.len()).filter(moves).collect();
    let pair = |a: usize, b: usize| correlation(&changes[a], &integrals[b]);
    let mut findings = Vec::new();
    for &j in &judged {
        let own = pair(j, j);
        let other = judged
            .iter()
            .copied()
            .find(|&k| k != j && pair(j, k) > SAME);
        if own.abs() >= SAME {
            findings.extend(of_factor(read, j, factor(&changes[j], &integrals[j])));
        } else if let Some(other) = other {
            findings.push(of_order(read, j, other, [own, pair(j, other)]));
        } else {
            findings.push(of_another_motion(read, j, own));
        }
    }
    findings
}

fn of_factor(read: &RawRecording<'_>, joint: usize, factor: f64) -> Option<Mistake> {
    if (factor - 1.0).abs() <= FACTOR_TOLERANCE {
        return None;
    }
    let near = |(known, ..): &&(f64, &str, &str)| (factor / known - 1.0).abs() <= FACTOR_TOLERANCE;
    let (reason, remedy) = match REASONS.iter().find(near) {
        Some((_, reason, remedy)) => (format!("{reason} "), *remedy),
        None => (
            String::new(),
            "check the units of position, velocity and time",
        ),
    };
    Some(finding(
        Severity::Error,
        read.at_joint(joint),
        Description::new(
            "velocity-factor",
            format!(
                "the position changes {factor:.5} times as fast as the velocity channel says: {reason}the two \
                 do not belong together"
            ),
            format!("{remedy}; or leave out recordings.columns.velocity"),
        ),
    ))
}

fn of_order(
    read: &RawRecording<'_>,
    joint: usize,
    other: usize,
    [own, found]: [f64; 2],
) -> Mistake {
    let other = &read.context.joint(other).name;
    finding(
        Severity::Error,
        read.at_joint(joint),
        Description::new(
            "velocity-order",
            format!(
                "the velocity of this joint does not follow its position (correlation {own:.3}); that of \
                 {other} does ({found:.3})"
            ),
            "put position and velocity columns into the same order in recordings.columns",
        ),
    )
}

fn of_another_motion(read: &RawRecording<'_>, joint: usize, own: f64) -> Mistake {
    finding(
        Severity::Error,
        read.at_joint(joint),
        Description::new(
            "velocity-not-derivative",
            format!(
                "the velocity channel does not follow the position: correlation {own:.3} over {WINDOW_S} s"
            ),
            "name the right column in recordings.columns.velocity, or leave it out",
        ),
    )
}

fn window(read: &RawRecording<'_>) -> usize {
    ((WINDOW_S * read.timing.rate_hz).round() as usize)
        .max(2)
        .min(read.samples() / 4)
}

/// Changes of a series over consecutive windows.
fn changes(read: &RawRecording<'_>, series: &[f64]) -> Vec<f64> {
    let window = window(read);
    let ends: Vec<f64> = series.iter().step_by(window).copied().collect();
    ends.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

/// Integrals of a series over the same windows, by trapezoids.
fn integrals(read: &RawRecording<'_>, series: &[f64]) -> Vec<f64> {
    let window = window(read);
    let area = |k: usize| 0.5 * (series[k] + series[k + 1]) * (read.time(k + 1) - read.time(k));
    let count = (series.len() - 1) / window;
    (0..count)
        .map(|m| (m * window..(m + 1) * window).map(area).sum())
        .collect()
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Correlation about zero: a change that is nothing must have an integral of nothing.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let size = (product(a, a) * product(b, b)).sqrt();
    if size > 0.0 {
        product(a, b) / size
    } else {
        0.0
    }
}

/// Least squares f of `a = f b`.
fn factor(a: &[f64], b: &[f64]) -> f64 {
    product(a, b) / product(b, b)
}
