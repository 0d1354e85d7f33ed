//! Positions in degrees: as radians they lie beyond what the joint can do, divided by 57.3 they do not.

use std::f64::consts::TAU;

use crate::check::context::RawRecording;
use crate::check::extent::extent;
use crate::check::jumps;
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};

/// Degrees per radian.
pub(super) const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// A position may lie this share of its range beyond the limits before the unit is doubted: robots are
/// driven to their limits, not to a quarter more.
const DOUBT: f64 = 0.25;

pub(super) fn check(read: &RawRecording<'_>) -> Vec<Mistake> {
    let context = read.context;
    if !context.is_uncoupled() {
        return Vec::new();
    }
    let revolute: Vec<usize> = (0..context.moving.len())
        .filter(|&j| context.is_revolute(j))
        .collect();
    let mut beyond: Vec<usize> = revolute
        .iter()
        .copied()
        .filter(|&j| excess(read, j, 1.0) > DOUBT)
        .collect();
    if !beyond.is_empty() {
        let anew = jumps::starting_anew(read.recording);
        beyond.retain(|j| !anew.contains(j));
    }
    let Some(&worst) = beyond
        .iter()
        .max_by(|&&a, &&b| excess(read, a, 1.0).total_cmp(&excess(read, b, 1.0)))
    else {
        return Vec::new();
    };
    // In degrees every joint that is beyond its range must be within it; else it is something else.
    if beyond.iter().any(|&j| excess(read, j, 1.0 / DEGREES) > 0.0) {
        return Vec::new();
    }
    let alone = revolute.len() > 1 && beyond.len() == 1;
    let place = if alone {
        read.at_joint(worst)
    } else {
        read.place()
    };
    let (low, high) = reach(read, worst, 1.0);
    vec![finding(
        Severity::Error,
        place,
        Description::new(
            "position-in-degrees",
            format!(
                "{} of {} turning joints leave their range as radians and keep to it as degrees; {} goes from \
                 {low:.4} to {high:.4}",
                beyond.len(),
                revolute.len(),
                context.joint(worst).name
            ),
            "name the unit under [recordings.columns], as in position = { column = \"q{n}\", unit = \"deg\" } (and deg/s, \
             deg/s^2 of velocities and accelerations)",
        ),
    )]
}

/// Lowest and highest position of a joint, the recorded numbers multiplied by `unit`.
fn reach(read: &RawRecording<'_>, index: usize, unit: f64) -> (f64, f64) {
    let factor = unit * read.context.position_factor(index);
    let offset = read.context.position_offset(index);
    let recorded = read.recording.position[index].iter();
    extent(recorded.map(|q| factor * q + offset))
}

/// How far a joint goes beyond its limits, in shares of their range; without limits one turn each way is
/// what cables allow.
fn excess(read: &RawRecording<'_>, index: usize, unit: f64) -> f64 {
    let limits = &read.context.joint(index).limits;
    let (lower, upper) = match (limits.lower, limits.upper) {
        (Some(lower), Some(upper)) if upper > lower => (lower, upper),
        _ => (-TAU, TAU),
    };
    let (low, high) = reach(read, index, unit);
    (high - upper).max(lower - low) / (upper - lower)
}
