//! Spikes: single samples far from the median of their neighbours.

use crate::check::context::RawRecording;
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use crate::recording::spikes::{Channel, SPIKE_SIGMA, spikes};

/// Share of the samples up to which spikes cannot move an estimate by a standard deviation or two.
const FEW: f64 = 0.0005;

pub(super) fn check(read: &RawRecording<'_>) -> Vec<Mistake> {
    let signals = read.recording.signal.iter().enumerate();
    let signals = signals
        .filter_map(|(c, s)| Some((read.at_signal(c), "signal", of(read, s, Channel::Jumping)?)));
    let positions = read.recording.position.iter().enumerate();
    let positions = positions
        .filter_map(|(j, s)| Some((read.at_joint(j), "position", of(read, s, Channel::Smooth)?)));
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
                Description::new(
                    "spikes",
                    format!(
                        "the {what} stands out from its neighbours by more than {SPIKE_SIGMA} standard deviations at {} of {} \
                         samples; most, by {:.4}, at {:.3} s",
                        spikes.count,
                        read.samples(),
                        spikes.size,
                        read.time(spikes.at)
                    ),
                    "where they come with nothing in the motion, what their neighbours say takes their place; look for the cause",
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

fn of(read: &RawRecording<'_>, series: &[f64], channel: Channel) -> Option<Spikes> {
    let mut found = spikes(series, channel);
    found.retain(|spike| read.counts(spike.at));
    let largest = found.iter().max_by(|a, b| a.size.total_cmp(&b.size))?;
    Some(Spikes {
        count: found.len(),
        at: largest.at,
        size: largest.size,
    })
}
