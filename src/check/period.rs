//! The period of the motion, as runs settle it: stated and wrong, or there and not stated.

use crate::check::context::RawRecording;
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use crate::problem_file::choices::DifferentiationMethod;
use crate::recording::period;

pub(super) fn check(read: &RawRecording<'_>) -> Vec<Mistake> {
    let stated = read.context.table.period.as_ref().map(|p| p.value);
    let found = match stated {
        Some(period) => of_stated(read, period),
        None => of_unstated(read),
    };
    found.into_iter().collect()
}

fn of_stated(read: &RawRecording<'_>, stated: f64) -> Option<Mistake> {
    let settled = period::settle(read.recording, &read.timing, Some(stated));
    let message = settled.remark?;
    let remedy = match settled.period {
        Some((found, _)) => format!(
            "set recordings.period = {found:.6}; where recordings have periods of their own, leave it out, and each \
             is averaged over its own"
        ),
        None => "remove recordings.period".to_string(),
    };
    Some(finding(
        Severity::Warning,
        read.place().key("period"),
        Description::new("period-wrong", message, remedy),
    ))
}

fn of_unstated(read: &RawRecording<'_>) -> Option<Mistake> {
    if read.context.problem.fit.is_of_motors() {
        // Strokes at constant speed are cut out, not averaged.
        return None;
    }
    let method = &read.context.table.differentiation.method;
    let sought = |m| m == DifferentiationMethod::Fourier;
    if !method.as_ref().is_none_or(|m| sought(m.value)) {
        return None;
    }
    let found = period::find(read.recording, &read.timing)?;
    let seconds = found.period;
    let repeats = read.samples() as f64 / read.timing.rate_hz / seconds;
    let remedy = if found.is_exact() && !period::is_whole(read.recording, &read.timing, seconds) {
        format!(
            "each holds {:.2} samples: a fit takes its noise from them and every sample for itself; periods of a whole number \
             of samples would be averaged, which is as right and faster",
            seconds * read.timing.rate_hz
        )
    } else if found.is_exact() {
        format!(
            "a fit averages over these periods; set recordings.period = {seconds:.5} to hold it to that, \
             or recordings.differentiation.method = \"lowpass\" to use every sample"
        )
    } else {
        format!(
            "{:.2} % of its power changes from period to period, too much to average unasked; if nothing \
             but noise changes, set recordings.period = {seconds:.5}",
            100.0 * found.changed
        )
    };
    Some(finding(
        Severity::Note,
        read.place().key("period"),
        Description::new(
            "period-not-stated",
            format!("the motion repeats every {seconds:.5} s, {repeats:.1} times"),
            remedy,
        ),
    ))
}
