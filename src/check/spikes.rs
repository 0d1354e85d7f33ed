//! Spikes: single samples far from the median of their neighbours.

use crate::check::finding;
use crate::check::setting::Read;
use crate::check::velocity::quantum;
use crate::outcome::check::{Finding, Severity};
use crate::stats::robust::mad_scale;

/// Robust standard deviations that make a spike: once in 10^15 samples of normal noise.
const SPIKE_SIGMA: f64 = 8.0;

/// A spike also has this share of the channel's range: heavy tails and friction at reversals stay below.
const SPIKE_SHARE: f64 = 0.25;

/// Share of the samples up to which spikes cannot move an estimate by a standard deviation or two.
const FEW: f64 = 0.0005;

/// Steps of a coarse channel that a spike has to exceed.
const SPIKE_QUANTA: f64 = 8.0;

/// Half the width of the median's window: follows every monotone change of three samples or more.
const HALF: usize = 2;

pub(super) fn check(read: &Read<'_>) -> Vec<Finding> {
    let signals = read.recording.signal.iter().enumerate();
    let signals =
        signals.filter_map(|(c, series)| Some((read.at_signal(c), "signal", of(read, series)?)));
    let positions = read.recording.position.iter().enumerate();
    let positions =
        positions.filter_map(|(j, s)| Some((read.at_joint(j), "position", of(read, s)?)));
    let severity = |count: usize| {
        if count as f64 > FEW * read.samples() as f64 {
            Severity::Warning
        } else {
            Severity::Note
        }
    };
    signals
        .chain(positions)
        .map(|(place, what, spikes)| {
            finding(
                severity(spikes.count),
                place.line(read.recording.line(spikes.at)),
                (
                    "spikes",
                    format!(
                        "{} samples of the {what} stand out by more than {SPIKE_SIGMA} standard deviations; the \
                         largest by {:.4} at {:.3} s",
                        spikes.count,
                        spikes.size,
                        read.time(spikes.at)
                    ),
                    "leave them out with recordings.columns.mask, or use estimator = \"irls\"".to_string(),
                ),
            )
        })
        .collect()
}

struct Spikes {
    count: usize,
    /// The largest.
    at: usize,
    size: f64,
}

fn of(read: &Read<'_>, series: &[f64]) -> Option<Spikes> {
    let deviations: Vec<f64> = (HALF..series.len().saturating_sub(HALF))
        .map(|k| {
            let mut window = [0.0; 2 * HALF + 1];
            window.copy_from_slice(&series[k - HALF..=k + HALF]);
            window.sort_by(f64::total_cmp);
            series[k] - window[HALF]
        })
        .collect();
    // Most samples of a smooth channel are their own median: the scale is that of the others.
    let others: Vec<f64> = deviations.iter().copied().filter(|d| *d != 0.0).collect();
    let scale = mad_scale(&others)?;
    let mut sorted: Vec<f64> = series.to_vec();
    let (cut, last) = (series.len() / 200, series.len() - 1);
    sorted.sort_by(f64::total_cmp);
    // The range without its ends: spikes must not raise their own threshold.
    let (low, high) = (sorted[cut], sorted[last - cut]);
    let threshold = (SPIKE_SIGMA * scale)
        .max(SPIKE_SHARE * (high - low))
        .max(SPIKE_QUANTA * quantum(series));
    let spikes = deviations
        .iter()
        .enumerate()
        .filter(|(k, d)| d.abs() > threshold && read.counts(k + HALF));
    let count = spikes.clone().count();
    let (at, size) = spikes.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    Some(Spikes {
        count,
        at: at + HALF,
        size: size.abs(),
    })
}
