//! Preprocessing of a recording: time base, repetition, averaging or smoothing, differentiation, noise.

use crate::fault::Place;
use crate::recording::channels::samples::Recording;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::prepare::aperiodic;
use crate::recording::prepare::experiment::Experiment;
use crate::recording::prepare::periods::period::{self, ChosenPeriod};
use crate::recording::prepare::periods::periodic;
use crate::recording::prepare::settings::{Method, Preparation};
use crate::recording::quality::spikes;
use crate::recording::time_base::clock;
use crate::recording::time_base::sample_rows::with_gaps_masked;
use crate::recording::time_base::timing::{Timing, examine};

/// Makes a recording ready: time base, averaging or smoothing, differentiation, noise.
///
/// Errors: of the time base, of the settings, a recording that is too short, a mask that leaves
/// too little.
pub fn prepare(
    recording: Recording,
    preparation: &Preparation,
) -> Result<Experiment, RecordingError> {
    let timing = examine(&recording, preparation.rate)?;
    preparation.validate(&recording, &timing)?;
    let (mut recording, timing) = with_gaps_masked(recording, timing);
    let settled = period_of(&recording, preparation, &timing)?;
    let period = settled.period.as_ref();
    let spikes = spikes::replace(&mut recording, period.map(|(s, _)| s * timing.rate_hz));
    let held = recording.held_words(timing.rate_hz);
    let clock = clock::words(&recording, timing.rate_hz);
    let drift = recording.clock_drift.as_ref();
    let drift = drift.map(|drift| drift.words(&recording.file));
    let joined = recording.remarks.clone();
    let missing = recording.missing.as_ref();
    let missing = missing.map(|missing| missing.words(&recording.file));
    let lost = recording.lost.as_ref();
    let lost = lost.and_then(|lost| lost.words(&recording.file));
    let mut experiment = match settled.period {
        Some((period, chosen)) if period::is_whole(&recording, &timing, period) => {
            periodic::prepare(recording, preparation, timing, period, chosen)
        }
        other => aperiodic::prepare(recording, preparation, timing, other.map(|(s, _)| s)),
    }?;
    experiment.remarks.extend(
        joined.into_iter().chain(
            [missing, lost, spikes, held, clock, drift, settled.remark]
                .into_iter()
                .flatten(),
        ),
    );
    Ok(experiment)
}

/// The period that is given, if it is that of the motion, or the one that the motion shows.
fn period_of(
    recording: &Recording,
    preparation: &Preparation,
    timing: &Timing,
) -> Result<ChosenPeriod, RecordingError> {
    let method = preparation.differentiation.method;
    let sought = matches!(method, None | Some(Method::Fourier));
    if preparation.period.is_none() && !sought {
        return Ok(ChosenPeriod::default());
    }
    if let Some(stated) = preparation.period {
        periodic::rows_of(recording, timing, stated)?;
    }
    let settled = period::settle(recording, timing, preparation.period);
    if settled.period.is_none() && method == Some(Method::Fourier) {
        let place = Place::file(&recording.file).key("method");
        let kind = RecordingErrorKind::FourierWithoutPeriod;
        return Err(RecordingError::new(place, kind));
    }
    Ok(settled)
}
