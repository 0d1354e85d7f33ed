//! A delay d between motion and signal: the residual of `s(t + d) = Y(t) π` is least at the true d.
//!
//! Lags are whole samples, and the least lies at the vertex of the parabola through the three lags about the
//! lowest: interpolating the signal would take noise away between samples and pull d there. With residual
//! variance σ² and J the sum of squares, `var d = 2 σ² κ / J''`, κ the long-run variance of the residual
//! over its variance.

use crate::chain::effect::DELAY;
use crate::chain::model::Signal;
use crate::check::context::PreparedRecording;
use crate::check::regression::{Columns, Sampled, columns, factor, rest};
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use crate::stats::robust::median;

/// Longest delay looked for, s, and in samples at least.
const LONGEST_S: f64 = 0.1;
const LEAST_LAGS: usize = 5;

/// Lags tried at once.
const LAGS_AT_ONCE: usize = 21;

/// Shortest delay reported, samples: below it lies what a bus does within one cycle.
const LEAST_SAMPLES: f64 = 0.25;

/// A delay counts from this many of its standard deviations on.
const SIGNIFICANT: f64 = 4.0;

/// Share by which the residual's variance must fall for a delay that most channels agree on.
const LEAST_GAIN: f64 = 0.05;

/// The same for a single channel: bristles, springs and ripple look like a delay of their joint, and leave
/// more than this.
const LEAST_GAIN_ALONE: f64 = 0.6;

/// Share of the delay by which channels with one clock may differ.
const AGREEMENT: f64 = 0.2;

/// Factor of var d for neighbouring rows whose residuals go together.
const COLOURED: f64 = 10.0;

/// Delay of one channel, samples.
struct Delay {
    channel: usize,
    samples: f64,
    deviation: f64,
    /// Share of the residual's variance that the delay explains.
    gain: f64,
}

pub(super) fn check(ready: &PreparedRecording<'_>) -> Vec<Mistake> {
    // Where columns are mixed up, the residual has other reasons; a command that acts late is no error of the position that
    // is late.
    if !ready.other_reading.is_empty() || ready.model.signal() == Signal::PositionCommand {
        return Vec::new();
    }
    let experiment = &ready.prepared.experiment;
    let longest = ((LONGEST_S * experiment.rate_hz).round() as usize).max(LEAST_LAGS);
    let margin = if experiment.periods.is_some() {
        0
    } else {
        longest + 1
    };
    let sampled = Sampled::new(ready.prepared, margin);
    let widest = ready
        .comparison
        .columns
        .iter()
        .map(Vec::len)
        .max()
        .unwrap_or(0);
    if sampled.len() <= 3 * widest {
        return Vec::new();
    }
    let model = &ready.comparison.model;
    let all = columns(model, &sampled, &ready.comparison.parameters);
    let lagged = Lagged {
        ready,
        sampled: &sampled,
        longest,
    };
    let active = (0..all.len()).filter(|&c| model.channels()[c].active);
    let delays: Vec<Delay> = active.filter_map(|c| lagged.delay(c, &all[c])).collect();
    describe(ready, &delays)
}

struct Lagged<'a> {
    ready: &'a PreparedRecording<'a>,
    sampled: &'a Sampled,
    longest: usize,
}

impl Lagged<'_> {
    /// The signal of a channel so many samples later.
    fn signal(&self, channel: usize, lag: i64) -> Vec<f64> {
        let signal = &self.ready.prepared.experiment.signal[channel];
        let length = signal.len() as i64;
        let at = |&row: &usize| signal[(row as i64 + lag).rem_euclid(length) as usize];
        self.sampled.rows.iter().map(at).collect()
    }

    /// Sums of squares of the residual at lags.
    fn squares(&self, channel: usize, columns: &Columns, lags: &[i64]) -> Vec<f64> {
        let signals: Vec<Vec<f64>> = lags.iter().map(|&lag| self.signal(channel, lag)).collect();
        let right: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
        let factor = factor(columns, &right);
        (0..lags.len())
            .map(|k| rest(&factor, columns.len(), k).powi(2))
            .collect()
    }

    fn delay(&self, channel: usize, columns: &Columns) -> Option<Delay> {
        let longest = self.longest as i64;
        let mut centre = 0;
        let mut step = (2 * longest / (LAGS_AT_ONCE as i64 - 1)).max(1);
        let mut half = longest / step;
        loop {
            let lags: Vec<i64> = (-half..=half).map(|k| centre + k * step).collect();
            let squares = self.squares(channel, columns, &lags);
            let least = (0..lags.len()).min_by(|&a, &b| squares[a].total_cmp(&squares[b]))?;
            centre = lags[least];
            if step == 1 {
                break;
            }
            half = 5;
            step = (step / 5).max(1);
        }
        // At the end of the range there is no minimum, only a trend.
        if centre.abs() >= longest {
            return None;
        }
        let about = self.squares(channel, columns, &[centre - 1, centre, centre + 1, 0]);
        let curvature = about[0] - 2.0 * about[1] + about[2];
        if curvature <= 0.0 {
            return None;
        }
        let shift = 0.5 * (about[0] - about[2]) / curvature;
        let least = about[1] - 0.5 * shift * shift * curvature;
        let freedom = (self.sampled.len() - columns.len()) as f64;
        let variance = least.max(0.0) / freedom;
        Some(Delay {
            channel,
            samples: centre as f64 + shift,
            deviation: (2.0 * COLOURED * variance / curvature).sqrt(),
            gain: 1.0 - least / about[3].max(f64::MIN_POSITIVE),
        })
    }
}

fn describe(ready: &PreparedRecording<'_>, delays: &[Delay]) -> Vec<Mistake> {
    let significant = |d: &&Delay| {
        d.samples.abs() > (SIGNIFICANT * d.deviation).max(LEAST_SAMPLES) && d.gain > LEAST_GAIN
    };
    let late: Vec<&Delay> = delays.iter().filter(significant).collect();
    let Some(centre) = median(&late.iter().map(|d| d.samples).collect::<Vec<f64>>()) else {
        return Vec::new();
    };
    // One clock, one delay: two thirds of the channels are late, and none of them by another time.
    let agrees = |d: &Delay| {
        let scatter = (2.0 * d.deviation).max(LEAST_SAMPLES);
        (d.samples - centre).abs() <= scatter.max(AGREEMENT * centre.abs())
    };
    let common =
        delays.len() > 1 && 3 * late.len() >= 2 * delays.len() && late.iter().all(|d| agrees(d));
    let report = |place, samples: f64, (deviation, gain): (f64, f64)| {
        let seconds = samples / ready.prepared.experiment.rate_hz;
        let which = if seconds > 0.0 { "late" } else { "early" };
        finding(
            Severity::Warning,
            place,
            Description::new(
                "delay",
                format!(
                    "the signal is {:.2} ms {which} against the motion ({:.2} samples, standard deviation {:.2}); \
                     without the delay {:.0} % of the residual's variance would go",
                    1e3 * seconds.abs(),
                    samples.abs(),
                    deviation,
                    100.0 * gain
                ),
                format!(
                    "shift the channel by this time, or add \"{}\" to the effects",
                    DELAY.id
                ),
            ),
        )
    };
    if common {
        let count = late.len() as f64;
        let deviation = (late.iter().map(|d| d.deviation.powi(2)).sum::<f64>()).sqrt() / count;
        let gain = late.iter().map(|d| d.gain).sum::<f64>() / count;
        return vec![report(ready.place(), centre, (deviation, gain))];
    }
    late.iter()
        .filter(|d| d.gain > LEAST_GAIN_ALONE)
        .map(|d| {
            report(
                ready.at_channel(d.channel),
                d.samples,
                (d.deviation, d.gain),
            )
        })
        .collect()
}
