//! Single channels: cut off at a limit, standing still while the joint moves, too coarse.

use crate::check::context::RawRecording;
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use crate::recording::lost::{Loss, LostChannel};
use crate::recording::noise_level::{hiding_step, pieces};
use crate::recording::spikes::quantum;
use crate::stats::deviation::range;

/// Fewest encoder steps in the range of the motion: with fewer, friction near standstill lies within one.
const LEAST_STEPS: f64 = 1000.0;

/// Fewest steps in the range of a signal: with fewer, rounding is more than a tenth of a friction that is a tenth of the range.
const LEAST_SIGNAL_STEPS: f64 = 100.0;

pub(super) fn check(read: &RawRecording<'_>) -> Vec<Mistake> {
    let lost_channels = read.recording.lost.iter().flat_map(|found| &found.channels);
    let mut findings: Vec<Mistake> = lost_channels.map(|found| lost(read, found)).collect();
    for channel in 0..read.recording.signal.len() {
        findings.extend(coarse_signal(read, channel));
    }
    findings.extend((0..read.context.moving.len()).filter_map(|joint| coarse(read, joint)));
    findings
}

/// Samples at which a channel of the signal is cut off or stands still.
fn lost(read: &RawRecording<'_>, lost: &LostChannel) -> Mistake {
    let (count, of) = (lost.samples.len(), read.samples());
    let values: Vec<String> = lost.values.iter().map(f64::to_string).collect();
    let values = values.join(" and ");
    let samples = match lost.left_out {
        true => "these samples are left out of every fit and of held-out errors",
        false => "leave these samples out with recordings.columns.mask",
    };
    let description = match lost.loss {
        Loss::Saturated => Description::new(
            "saturated",
            format!("{count} of {of} samples stand exactly at the signal's limit {values}"),
            format!("drive less hard; {samples}"),
        ),
        Loss::Stuck => Description::new(
            "stuck",
            format!(
                "the signal does not change for {count} of {of} samples while the joint moves, first at {:.3} s with the \
                 value {values}",
                read.time(lost.samples[0])
            ),
            format!("check that the channel is connected; {samples}"),
        ),
    };
    finding(Severity::Warning, read.at_signal(lost.channel), description)
}

/// A signal in steps that are coarser than its noise, and few.
fn coarse_signal(read: &RawRecording<'_>, channel: usize) -> Option<Mistake> {
    let series = &read.recording.signal[channel];
    let step = hiding_step(&pieces(series, read.recording.signal_mask().as_deref()))?;
    let steps = range(series) / step;
    (steps < LEAST_SIGNAL_STEPS).then(|| {
        finding(
            Severity::Warning,
            read.at_signal(channel),
            Description::new(
                "coarse-signal",
                format!(
                    "the signal changes in steps of {step:.3e}, which hide its noise; all of it is {steps:.0} of them"
                ),
                "record the signal with all its digits",
            ),
        )
    })
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
