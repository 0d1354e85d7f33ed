//! The time base: unit of the stamps, samples that are missing, uneven steps, a rate that the motion outruns.

use crate::check::context::{PreparedRecording, RawRecording};
use crate::check::report::finding;
use crate::fault::{Description, Place};
use crate::outcome::check::{Mistake, Severity};
use crate::recording::experiment::Chosen;
use crate::recording::samples::Recording;
use crate::recording::units::{FASTEST_HZ, SLOWEST_HZ};
use crate::stats::robust::median;

/// Share of missing samples up to which interpolation across the gaps is of no account.
const FEW_MISSING: f64 = 0.001;

/// Jitter over step that counts: a joint at 1 rad/s is 1 mrad from where it would be at 100 Hz.
const UNEVEN: f64 = 0.1;

/// Jitter over step that makes velocities wrong by as much.
const VERY_UNEVEN: f64 = 0.3;

/// Share of half the rate from which a bandwidth that the data chose has no room for noise above it.
const NO_ROOM: f64 = 0.85;

pub(super) fn check(read: &RawRecording<'_>) -> Vec<Mistake> {
    if let Some(found) = wrong_unit(read.recording) {
        return vec![found];
    }
    let found = joined(read).chain(held(read)).chain(missing(read));
    found.chain(uneven(read)).chain(drifting(read)).collect()
}

/// How the files of a recording were put together.
fn joined<'a>(read: &'a RawRecording<'_>) -> impl Iterator<Item = Mistake> + 'a {
    read.recording.remarks.iter().map(|remark| {
        finding(
            Severity::Note,
            read.place(),
            Description::new(
                "files-joined",
                remark.clone(),
                "list the file of the signal first, and its samples stay as they were recorded",
            ),
        )
    })
}

/// Rows between the samples, repeated or interpolated, which no run uses.
fn held(read: &RawRecording<'_>) -> Option<Mistake> {
    let held = read.recording.held.as_ref()?;
    let words = read.recording.held_words(read.timing.rate_hz)?;
    Some(finding(
        Severity::Warning,
        read.place().key(held.channels),
        Description::new(
            "samples-held",
            words,
            "record every channel at the rate of the file, or write the samples alone",
        ),
    ))
}

/// A clock that does not run as the motion repeats.
fn drifting(read: &RawRecording<'_>) -> Option<Mistake> {
    let drift = read.recording.clock_drift.as_ref()?;
    Some(finding(
        Severity::Warning,
        read.place().key("time"),
        Description::new(
            "clock-drift",
            drift.words(&read.recording.file),
            "stamp samples by the clock of the robot's controller; how fast the clock runs on the average, this cannot tell, \
             and speeds and accelerations are wrong by as much",
        ),
    ))
}

/// Stamps that make sense in milliseconds, microseconds or nanoseconds only.
pub(super) fn wrong_unit(recording: &Recording) -> Option<Mistake> {
    let time = recording.time.as_ref()?;
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let step = median(&steps).filter(|step| *step > 0.0)?;
    if 1.0 / step >= SLOWEST_HZ {
        return None;
    }
    let units = [
        ("milliseconds", 1e3),
        ("microseconds", 1e6),
        ("nanoseconds", 1e9),
    ];
    let (unit, factor) = units.into_iter().find(|(_, factor)| {
        let rate = factor / step;
        (SLOWEST_HZ..=FASTEST_HZ).contains(&rate)
    })?;
    Some(finding(
        Severity::Error,
        Place::file(&recording.file).key("time"),
        Description::new(
            "time-unit",
            format!(
                "the time stamps are {step} apart, which as seconds is a rate of {:.3e} Hz; they look like {unit} \
                 ({:.4} Hz)",
                1.0 / step,
                factor / step
            ),
            format!("give time in seconds: divide the time column by {factor:.0}"),
        ),
    ))
}

fn missing(read: &RawRecording<'_>) -> Option<Mistake> {
    let gaps = &read.timing.gaps;
    let longest = gaps.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let lost: f64 = gaps
        .iter()
        .map(|(_, length)| length * read.timing.rate_hz - 1.0)
        .sum();
    let share = lost / (lost + read.samples() as f64);
    let severity = if share > FEW_MISSING {
        Severity::Warning
    } else {
        Severity::Note
    };
    Some(finding(
        severity,
        read.place().key("time").line(longest.0),
        Description::new(
            "missing-samples",
            format!(
                "gaps in time: {}; about {lost:.0} samples ({:.2} %) are missing; the longest gap is {:.4} s",
                gaps.len(),
                100.0 * share,
                longest.1
            ),
            "rows inside gaps are left out; record again if the gaps fall on the fast parts of the motion",
        ),
    ))
}

fn uneven(read: &RawRecording<'_>) -> Option<Mistake> {
    let of_clock = read.recording.stamp_jitter;
    let jitter = of_clock.unwrap_or(read.timing.jitter_rms_s);
    let relative = jitter * read.timing.rate_hz;
    let severity = if relative > VERY_UNEVEN {
        Severity::Warning
    } else {
        Severity::Note
    };
    let is_uneven = of_clock.is_some() || !read.timing.uniform;
    let used = match of_clock {
        Some(_) => {
            "the motion is smooth by an even clock and not by the stamps, so the clock is used"
        }
        None => "every sample is used at the time of its stamp",
    };
    (is_uneven && relative > UNEVEN).then(|| {
        finding(
            severity,
            read.place().key("time"),
            Description::new(
                "jitter",
                format!(
                    "the steps of time scatter by {:.3} ms about {:.3} ms",
                    1e3 * jitter,
                    1e3 / read.timing.rate_hz
                ),
                format!("stamp the samples where they are taken, not where they arrive; {used}"),
            ),
        )
    })
}

/// A motion that fills the whole spectrum: what lies above half the rate folds back.
pub(super) fn check_bandwidth(ready: &PreparedRecording<'_>) -> Vec<Mistake> {
    let experiment = &ready.prepared.experiment;
    let nyquist = 0.5 * experiment.rate_hz;
    let outrun = |&joint: &usize| {
        let bandwidth = &experiment.bandwidth[joint];
        bandwidth.chosen == Chosen::Data && bandwidth.cutoff_hz > NO_ROOM * nyquist
    };
    let moving = ready.context.moving.iter().copied();
    moving
        .filter(outrun)
        .map(|joint| {
            finding(
                Severity::Warning,
                ready.at_channel_of(joint),
                Description::new(
                    "rate-too-low",
                    format!(
                        "the motion reaches {:.1} Hz, half the rate is {nyquist:.1} Hz",
                        experiment.bandwidth[joint].cutoff_hz
                    ),
                    "record faster, or move more smoothly; or state recordings.differentiation.cutoff_hz",
                ),
            )
        })
        .collect()
}
