//! Efforts that are magnitudes: no joint's is ever negative, though joints move both ways.

use crate::check::context::RawRecording;
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use crate::problem_file::choices::Signal;

/// Least share of the steps of a joint in either direction for it to move both ways.
const BOTH_WAYS: f64 = 0.1;

/// Joints at least: gravity may hold one joint's torque on one side of zero whatever it does, and where friction turns
/// over with the motion hardly that of a second.
const LEAST_JOINTS: usize = 2;

pub(super) fn check(read: &RawRecording<'_>) -> Vec<Mistake> {
    let kind = read.context.table.signal.value;
    let other = matches!(kind, Signal::BaseWrench | Signal::PositionCommand);
    let joints = 0..read.context.moving.len();
    let turning: Vec<usize> = joints.filter(|&j| moves_both_ways(read, j)).collect();
    let series = |joint: usize| read.recording.signal.get(joint);
    let is_magnitude = |joint: &usize| {
        let never_negative =
            |s: &Vec<f64>| s.iter().all(|x| *x >= 0.0) && s.iter().any(|x| *x > 0.0);
        series(*joint).is_some_and(never_negative)
    };
    if other || turning.len() < LEAST_JOINTS || !turning.iter().all(is_magnitude) {
        return Vec::new();
    }
    vec![finding(
        Severity::Error,
        read.at_signal(turning[0]),
        Description::new(
            "effort-magnitude",
            format!(
                "no sample of any of {} joints that move both ways is negative: the signal is a magnitude",
                turning.len()
            ),
            "record the signed current or torque; a magnitude does not tell what drives from what brakes",
        ),
    )]
}

fn moves_both_ways(read: &RawRecording<'_>, joint: usize) -> bool {
    let steps = read.recording.position[joint]
        .windows(2)
        .map(|w| w[1] - w[0]);
    let (forth, back) = steps.fold((0_usize, 0_usize), |(forth, back), step| {
        (
            forth + usize::from(step > 0.0),
            back + usize::from(step < 0.0),
        )
    });
    let all = (forth + back) as f64;
    forth.min(back) as f64 > BOTH_WAYS * all
}
