//! Errors of forward simulations on a terminal.

use crate::outcome::rollout::{Horizon, JointErrors, Rollout, Spread};
use crate::report::number::{ABSENT, optional};
use crate::report::terminal::align;

/// Horizon of the table of joints, s.
const MIDDLE: f64 = 0.5;

/// What a rollout says: every joint at half a second, then all joints over the horizon.
pub(super) fn lines(rollout: &Rollout) -> Vec<String> {
    let mut lines = vec![rollout.summary.clone()];
    let middle = rollout.horizons.iter().rfind(|h| h.horizon <= MIDDLE);
    if let Some(horizon) = middle {
        lines.extend(joints(rollout, horizon));
    }
    lines.extend(over_horizon(rollout));
    lines.extend(rollout.notes.iter().map(|note| format!("note: {note}")));
    lines
}

fn joints(rollout: &Rollout, horizon: &Horizon) -> Vec<String> {
    let has_before = rollout.before.is_some();
    let after = format!("after {} s", horizon.horizon);
    let mut headers = vec![after, "unit".to_string()];
    headers.extend(has_before.then(|| "before".to_string()));
    headers.extend(
        [
            "after",
            "quartiles",
            "RMS",
            "noise alone",
            "lost before, after",
        ]
        .map(str::to_string),
    );
    let mut rows = vec![headers];
    for joint in &horizon.joints {
        let mut row = vec![joint.joint.clone(), joint.unit.clone()];
        row.extend(joint.before.map(|before| optional(before.median)));
        row.extend([
            optional(joint.after.median),
            quartiles(&joint.after),
            optional(joint.after.rms),
            optional(joint.noise.median),
            lost(joint),
        ]);
        rows.push(row);
    }
    align(&rows, 2)
}

/// Half of the errors lie between.
pub(super) fn quartiles(spread: &Spread) -> String {
    match (spread.lower_quartile, spread.upper_quartile) {
        (None, None) => ABSENT.to_string(),
        (lower, upper) => format!("{} to {}", optional(lower), optional(upper)),
    }
}

/// Windows in which the models are lost, before and after.
fn lost(joint: &JointErrors) -> String {
    match joint.before {
        Some(before) => format!(
            "{}, {} of {}",
            before.lost, joint.after.lost, joint.after.windows
        ),
        None => format!("{} of {}", joint.after.lost, joint.after.windows),
    }
}

/// Median errors of the joints by horizon, after over noise alone.
fn over_horizon(rollout: &Rollout) -> Vec<String> {
    let mut headers = vec!["median error after".to_string()];
    let names = rollout.horizons.first().map_or(&[][..], |h| &h.joints);
    headers.extend(names.iter().map(|joint| joint.joint.clone()));
    let mut rows = vec![headers];
    for horizon in &rollout.horizons {
        let mut row = vec![format!("{} s", horizon.horizon)];
        row.extend(horizon.joints.iter().map(|j| optional(j.after.median)));
        rows.push(row);
    }
    align(&rows, 1)
}
