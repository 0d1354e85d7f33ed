//! The steady parts of a recording: one joint moves at constant speed, all others stand.

use std::ops::Range;

/// What counts as steady.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steadiness {
    /// Slower is standing, rad/s (m/s).
    pub least_speed: f64,
    /// Largest departure from the mean speed of the part, as a share of it.
    pub tolerance: f64,
    /// Shortest part, s, without its ends.
    pub least_duration: f64,
}

impl Default for Steadiness {
    fn default() -> Self {
        Self {
            least_speed: 0.02,
            tolerance: 0.05,
            least_duration: 0.3,
        }
    }
}

/// A steady part of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// The joint that moves.
    pub joint: usize,
    /// Its rows in the recording.
    pub samples: Range<usize>,
    /// Mean speed over the part, rad/s (m/s), from its positions.
    pub speed: f64,
}

/// Length over which a slope is taken, s: long against the steps of an encoder, short against a motion.
const WINDOW: f64 = 0.1;

/// Fewest samples that tell a slope and its scatter.
const LEAST_SAMPLES: usize = 10;

/// The steady parts, in the order of time. `position[j][k]`: joint j at time `time[k]`, s.
pub fn steady(time: &[f64], position: &[Vec<f64>], rule: &Steadiness) -> Vec<Segment> {
    let speeds: Vec<Vec<f64>> = position.iter().map(|q| slopes(time, q)).collect();
    let mut segments = Vec::new();
    let mut at = 0;
    while at < time.len() {
        let Some(joint) = single_mover(&speeds, at, rule) else {
            at += 1;
            continue;
        };
        let end = end_of_run(&speeds, joint, at, rule);
        segments.extend(trimmed(time, &position[joint], joint, at..end, rule));
        at = end.max(at + 1);
    }
    segments
}

/// Slope of a least-squares line over the window around each sample.
fn slopes(time: &[f64], position: &[f64]) -> Vec<f64> {
    let mut slopes = Vec::with_capacity(time.len());
    let (mut first, mut last) = (0, 0);
    for &t in time {
        while time[first] < t - WINDOW / 2.0 {
            first += 1;
        }
        while last < time.len() && time[last] <= t + WINDOW / 2.0 {
            last += 1;
        }
        // At a low rate the window holds few samples: the neighbours are taken at least.
        let range = first.min(last.saturating_sub(3))..last.max((first + 3).min(time.len()));
        slopes.push(slope(&time[range.clone()], &position[range]));
    }
    slopes
}

fn slope(time: &[f64], position: &[f64]) -> f64 {
    let count = time.len() as f64;
    let mean_t = time.iter().sum::<f64>() / count;
    let mean_q = position.iter().sum::<f64>() / count;
    let (mut tt, mut tq) = (0.0, 0.0);
    for (t, q) in time.iter().zip(position) {
        tt += (t - mean_t) * (t - mean_t);
        tq += (t - mean_t) * (q - mean_q);
    }
    if tt > 0.0 { tq / tt } else { 0.0 }
}

/// The joint that moves while no other does.
fn single_mover(speeds: &[Vec<f64>], at: usize, rule: &Steadiness) -> Option<usize> {
    let fast = |joint: &usize| speeds[*joint][at].abs() > rule.least_speed;
    let mut moving = (0..speeds.len()).filter(fast);
    match (moving.next(), moving.next()) {
        (Some(joint), None) => Some(joint),
        _ => None,
    }
}

/// End of the run from a sample on in which the speed keeps to its mean.
fn end_of_run(speeds: &[Vec<f64>], joint: usize, start: usize, rule: &Steadiness) -> usize {
    let (mut mean, mut count) = (speeds[joint][start], 1.0);
    let mut end = start + 1;
    while end < speeds[joint].len() && single_mover(speeds, end, rule) == Some(joint) {
        let speed = speeds[joint][end];
        if (speed - mean).abs() > rule.tolerance * mean.abs() {
            break;
        }
        count += 1.0;
        mean += (speed - mean) / count;
        end += 1;
    }
    end
}

/// The run without its ends, where the slope still sees the ramps; None if too little is left.
fn trimmed(
    time: &[f64],
    position: &[f64],
    joint: usize,
    run: Range<usize>,
    rule: &Steadiness,
) -> Option<Segment> {
    let (from, to) = (time[run.start] + WINDOW, time[run.end - 1] - WINDOW);
    let start = run.clone().find(|&k| time[k] >= from)?;
    let end = run.rev().find(|&k| time[k] <= to)? + 1;
    if end < start + LEAST_SAMPLES || time[end - 1] - time[start] < rule.least_duration {
        return None;
    }
    Some(Segment {
        joint,
        samples: start..end,
        speed: slope(&time[start..end], &position[start..end]),
    })
}
