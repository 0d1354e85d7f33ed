//! The period of the motion: stated and wrong, or there and not stated.

use crate::check::finding;
use crate::check::setting::Read;
use crate::outcome::check::{Finding, Severity};
use crate::problem_file::choices::DifferentiationMethod;
use crate::recording::period::{self, Repetition};

/// A motion repeats if a hundredth of its power changes from period to period; a stated period at which
/// this share changes is another one.
const CHANGED: f64 = 0.02;

pub(super) fn check(read: &Read<'_>) -> Vec<Finding> {
    let stated = read.setting.table.period.as_ref().map(|p| p.value);
    let found = match stated {
        Some(period) => of_stated(read, period),
        None => of_unstated(read),
    };
    found.into_iter().collect()
}

fn of_stated(read: &Read<'_>, period: f64) -> Option<Finding> {
    let (positions, rate_hz) = period::thinned(read.recording, &read.timing);
    let changed = period::changed_after(&positions, period * rate_hz)?;
    if changed < CHANGED {
        return None;
    }
    let what = match period::of_positions(&positions, rate_hz) {
        Some(Repetition { period: found, .. }) => (
            format!("the motion repeats after {found:.5} s"),
            format!("set recordings.period = {found:.5}"),
        ),
        None => (
            "it does not repeat at all".to_string(),
            "remove recordings.period".to_string(),
        ),
    };
    Some(finding(
        Severity::Error,
        read.place().key("period"),
        (
            "period-wrong",
            format!(
                "after the stated period of {period} s the motion differs by {:.1} % of its power; {}",
                100.0 * changed,
                what.0
            ),
            what.1,
        ),
    ))
}

fn of_unstated(read: &Read<'_>) -> Option<Finding> {
    let method = &read.setting.table.differentiation.method;
    if method
        .as_ref()
        .is_some_and(|m| m.value == DifferentiationMethod::Lowpass)
    {
        return None;
    }
    let found = period::find(read.recording, &read.timing)?;
    let period = found.period;
    let repeats = read.samples() as f64 / read.timing.rate_hz / period;
    let remedy = if found.is_exact() {
        format!(
            "a fit averages over these periods; set recordings.period = {period:.5} to hold it to that, \
             or recordings.differentiation.method = \"lowpass\" to use every sample"
        )
    } else {
        format!(
            "{:.2} % of its power changes from period to period, too much to average unasked; if nothing \
             but noise changes, set recordings.period = {period:.5}",
            100.0 * found.changed
        )
    };
    Some(finding(
        Severity::Note,
        read.place().key("period"),
        (
            "period-not-stated",
            format!("the motion repeats every {period:.5} s, {repeats:.1} times"),
            remedy,
        ),
    ))
}
