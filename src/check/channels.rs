//! Single channels: cut off at a limit, standing still while the joint moves, too coarse.

use crate::check::context::RawRecording;
use crate::check::extent::extent;
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use crate::recording::spikes::quantum;

/// Samples in a row at the extreme value that make a plateau.
const PLATEAU: usize = 4;

/// Share of the samples that plateaus must hold to matter.
const PLATEAU_SHARE: f64 = 0.002;

/// The extreme value must be hit this many times as often as the value next to it: the turning point of a
/// smooth quantised signal stays 1/(√2 − 1) = 2.4 times as long at its last step as at the one before.
const PILE: f64 = 6.0;

/// Shortest time for which a channel may not stand still while its joint moves, s: longer than a sample is
/// held on any bus.
const STUCK_S: f64 = 0.25;

/// Steps of the encoder that the joint takes meanwhile for it to count as moving, and least share of its
/// range.
const MOVING_QUANTA: f64 = 20.0;
const MOVING_SHARE: f64 = 0.01;

/// Fewest encoder steps in the range of the motion: with fewer, friction near standstill lies within one.
const LEAST_STEPS: f64 = 1000.0;

pub(super) fn check(read: &RawRecording<'_>) -> Vec<Mistake> {
    let mut findings = Vec::new();
    for channel in 0..read.recording.signal.len() {
        findings.extend(saturated(read, channel).or_else(|| stuck(read, channel)));
    }
    findings.extend((0..read.context.moving.len()).filter_map(|joint| coarse(read, joint)));
    findings
}

/// Value, samples in plateaus at it, and samples at it in all, of the upper (or with sign −1 lower) end.
fn plateau(series: &[f64], sign: f64) -> (f64, usize, usize) {
    let extreme = sign
        * series
            .iter()
            .fold(f64::NEG_INFINITY, |m, x| m.max(sign * x));
    let (mut run, mut held, mut all) = (0, 0, 0);
    for value in series.iter().chain([&f64::NAN]) {
        if *value == extreme {
            run += 1;
            all += 1;
        } else {
            held += if run >= PLATEAU { run } else { 0 };
            run = 0;
        }
    }
    (extreme, held, all)
}

/// How often the value next to the extreme one occurs.
fn beside(series: &[f64], extreme: f64) -> usize {
    let distance = |x: &f64| (x - extreme).abs();
    let nearest = series
        .iter()
        .filter(|x| **x != extreme)
        .map(distance)
        .fold(f64::INFINITY, f64::min);
    series.iter().filter(|x| distance(x) == nearest).count()
}

fn saturated(read: &RawRecording<'_>, channel: usize) -> Option<Mistake> {
    let series = &read.recording.signal[channel];
    let mut total = 0;
    let mut limits: Vec<String> = Vec::new();
    for sign in [1.0, -1.0] {
        let (extreme, held, all) = plateau(series, sign);
        let piled = all as f64 >= PILE * beside(series, extreme) as f64;
        if held as f64 >= PLATEAU_SHARE * series.len() as f64 && piled {
            total += all;
            limits.push(format!("{extreme}"));
        }
    }
    (total > 0).then(|| {
        finding(
            Severity::Warning,
            read.at_signal(channel),
            Description::new(
                "saturated",
                format!(
                    "{total} of {} samples stand exactly at the signal's limit {}",
                    series.len(),
                    limits.join(" and ")
                ),
                "drive less hard, or leave these samples out with recordings.columns.mask",
            ),
        )
    })
}

fn stuck(read: &RawRecording<'_>, channel: usize) -> Option<Mistake> {
    let series = &read.recording.signal[channel];
    let least = (STUCK_S * read.timing.rate_hz).ceil().max(10.0) as usize;
    let joint = channel.min(read.context.moving.len() - 1);
    let position = &read.recording.position[joint];
    let enough = MOVING_QUANTA * quantum(position);
    let enough = enough
        .max(MOVING_SHARE * range(position))
        .max(f64::MIN_POSITIVE);
    let (mut total, mut first) = (0, None);
    let mut start = 0;
    for k in 1..=series.len() {
        if k < series.len() && series[k] == series[start] {
            continue;
        }
        let moved = range(&position[start..k]) > enough;
        if k - start >= least && moved && read.counts(start) {
            total += k - start;
            first = first.or(Some(start));
        }
        start = k;
    }
    let first = first?;
    Some(finding(
        Severity::Warning,
        read.at_signal(channel),
        Description::new(
            "stuck",
            format!(
                "the signal does not change for {total} of {} samples while the joint moves, first at {:.3} s \
                 with the value {}",
                series.len(),
                read.time(first),
                series[first]
            ),
            "check that the channel is connected; leave these samples out with recordings.columns.mask",
        ),
    ))
}

fn coarse(read: &RawRecording<'_>, joint: usize) -> Option<Mistake> {
    let series = &read.recording.position[joint];
    let (step, range) = (quantum(series), range(series));
    let steps = range / step;
    // A joint that stands still shows a few steps of noise; that is not the encoder's fault.
    let moves = range > 0.02;
    (step > 0.0 && steps < LEAST_STEPS && moves).then(|| {
        finding(
            Severity::Warning,
            read.at_joint(joint),
            Description::new(
                "coarse-position",
                format!(
                    "the position changes in steps of {step:.3e}, the whole motion is {steps:.0} of them; \
                     velocity and acceleration will be coarse"
                ),
                "record positions with all their digits; move further; or use the motor's encoder",
            ),
        )
    })
}

fn range(series: &[f64]) -> f64 {
    let (low, high) = extent(series.iter().copied());
    high - low
}
