//! The period of the motion: stated and wrong, or there and not stated.

use crate::check::finding;
use crate::check::setting::Read;
use crate::outcome::check::{Finding, Severity};
use crate::problem_file::choices::DifferentiationMethod;
use crate::recording::period::detect_period;
use crate::recording::timing::{Grid, resample};

/// A motion repeats if a hundredth of its power changes from period to period; a stated period at which
/// this share changes is another one.
const CHANGED: f64 = 0.02;

/// Samples to which a recording is thinned: periods need no more.
const MOST_SAMPLES: usize = 40_000;

pub(super) fn check(read: &Read<'_>) -> Vec<Finding> {
    let (positions, rate_hz) = thinned(read);
    let stated = read.setting.table.period.as_ref().map(|p| p.value);
    let found = match stated {
        Some(period) => of_stated(read, (&positions, rate_hz), period),
        None => of_unstated(read, (&positions, rate_hz)),
    };
    found.into_iter().collect()
}

/// Positions on an even grid, with their rate in Hz.
fn thinned(read: &Read<'_>) -> (Vec<Vec<f64>>, f64) {
    let rate_hz = read.timing.rate_hz;
    let even = match (&read.recording.time, read.timing.uniform) {
        (Some(time), false) => {
            resample(read.recording.clone(), Grid::spanning(time, rate_hz)).position
        }
        _ => read.recording.position.clone(),
    };
    let stride = even
        .first()
        .map_or(1, |q| q.len().div_ceil(MOST_SAMPLES))
        .max(1);
    let thin = |q: &Vec<f64>| q.iter().step_by(stride).copied().collect();
    (even.iter().map(thin).collect(), rate_hz / stride as f64)
}

fn of_stated(
    read: &Read<'_>,
    (positions, rate_hz): (&[Vec<f64>], f64),
    period: f64,
) -> Option<Finding> {
    let changed = share_changed(positions, period * rate_hz)?;
    if changed < CHANGED {
        return None;
    }
    let what = match detect_period(positions, rate_hz) {
        Some(found) => (
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

/// Σ (q(k) − q(k + l))² / 2 Var q over all joints, l between samples by linear interpolation.
fn share_changed(positions: &[Vec<f64>], lag: f64) -> Option<f64> {
    let (whole, part) = (lag.floor() as usize, lag.fract());
    let (mut change, mut variance) = (0.0, 0.0);
    for q in positions {
        // Fewer samples than a tenth of the period behind it say nothing.
        let count = q
            .len()
            .checked_sub(whole + 1)
            .filter(|n| *n as f64 > 0.1 * lag)?;
        let mean = q.iter().sum::<f64>() / q.len() as f64;
        variance += q.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / q.len() as f64;
        let later = |k: usize| q[k + whole] + part * (q[k + whole + 1] - q[k + whole]);
        change += (0..count).map(|k| (q[k] - later(k)).powi(2)).sum::<f64>() / count as f64;
    }
    (variance > 0.0).then(|| change / (2.0 * variance))
}

fn of_unstated(read: &Read<'_>, (positions, rate_hz): (&[Vec<f64>], f64)) -> Option<Finding> {
    let method = &read.setting.table.differentiation.method;
    if method
        .as_ref()
        .is_some_and(|m| m.value == DifferentiationMethod::Lowpass)
    {
        return None;
    }
    let found = detect_period(positions, rate_hz)?;
    let duration = positions.first()?.len() as f64 / rate_hz;
    Some(finding(
        Severity::Note,
        read.place().key("period"),
        (
            "period-not-stated",
            format!(
                "the motion repeats every {found:.5} s, {:.1} times",
                duration / found
            ),
            format!(
                "set recordings.period = {found:.5}: the average over periods has less noise, and their \
                 differences show how much"
            ),
        ),
    ))
}
