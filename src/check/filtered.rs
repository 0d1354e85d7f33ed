//! Signals that were low-passed before they were logged, while their motion was not.

use crate::chain::model::Signal;
use crate::check::context::PreparedRecording;
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use crate::recording::filtered::{LowPass, band_of_motion, low_pass};

/// Share of a cut-off below which a filter of second order takes a sixteenth of a signal at most.
const PARALLEL: f64 = 0.5;

pub(super) fn check(ready: &PreparedRecording<'_>) -> Vec<Mistake> {
    let experiment = &ready.prepared.experiment;
    // Behind a parallel filter the model is low-passed as well. Commands are told, and have no noise of a converter.
    if experiment.parallel.is_some() || ready.model.signal() == Signal::PositionCommand {
        return Vec::new();
    }
    let speeds = experiment.motion.velocity.iter();
    let motion_hz = speeds
        .map(|speed| band_of_motion(speed, experiment.rate_hz))
        .fold(0.0, f64::max);
    let rate_hz = experiment.timing.rate_hz;
    let mask = experiment.raw.mask.as_deref();
    let channels = ready.model.channels().iter().zip(&experiment.raw.signal);
    let found = channels.filter_map(|(channel, series)| {
        let found = low_pass(series, mask, rate_hz, motion_hz)?;
        Some((channel.name.as_str(), found))
    });
    let (names, found): (Vec<&str>, Vec<LowPass>) = found.unzip();
    said(ready, &names, &found).into_iter().collect()
}

fn said(ready: &PreparedRecording<'_>, names: &[&str], found: &[LowPass]) -> Option<Mistake> {
    let least = found
        .iter()
        .min_by(|a, b| a.cutoff_hz.total_cmp(&b.cutoff_hz))?;
    let names = names.join(", ");
    Some(finding(
        Severity::Warning,
        ready.place().key(&names),
        Description::new(
            "filter",
            format!(
                "the signal was low-passed at about {:.1} Hz before it was logged, or interpolated by curves: its spectrum \
                 falls by {:.0} dB within an octave, as neither friction nor noise does, and friction is rounded off with it",
                least.cutoff_hz, least.fall_db
            ),
            format!(
                "record the signal without a filter; or low-pass signal and model alike with \
                 recordings.differentiation.parallel_hz = {:.1}",
                PARALLEL * least.cutoff_hz
            ),
        ),
    ))
}
