//! The motion and the signal against the limits in the robot file.

use crate::chain::model::Signal;
use crate::check::context::PreparedRecording;
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};

/// Shares by which limits may be exceeded: controllers overshoot, and files round.
const POSITION_SLACK: f64 = 0.01;
const VELOCITY_SLACK: f64 = 0.05;
const EFFORT_SLACK: f64 = 0.05;

/// Rows beyond an effort limit that are more than noise, as a share.
const EFFORT_ROWS: f64 = 0.001;

pub(super) fn check(ready: &PreparedRecording<'_>) -> Vec<Mistake> {
    let moving = ready.context.moving.iter().copied();
    moving
        .flat_map(|joint| {
            let found = [
                position(ready, joint),
                velocity(ready, joint),
                effort(ready, joint),
            ];
            found.into_iter().flatten()
        })
        .collect()
}

/// How a series overshoots a range.
struct Overshoot {
    /// The value that is farthest beyond, and by how much.
    value: f64,
    by: f64,
    /// Rows that are beyond.
    count: usize,
}

impl Overshoot {
    fn of(series: impl Iterator<Item = f64>, [lower, upper]: [f64; 2]) -> Option<Self> {
        let mut worst: Option<Self> = None;
        for value in series {
            let by = (value - upper).max(lower - value);
            if by > 0.0 {
                let worst = worst.get_or_insert(Self {
                    value,
                    by,
                    count: 0,
                });
                if by > worst.by {
                    (worst.value, worst.by) = (value, by);
                }
                worst.count += 1;
            }
        }
        worst
    }
}

/// `V m`: a series of one joint from those of the motors.
fn of_joint<'a>(
    ready: &PreparedRecording<'_>,
    motors: &'a [Vec<f64>],
    joint: usize,
) -> impl Iterator<Item = f64> + 'a {
    let coupling = ready.model.coupling_of_motions(&ready.model.values());
    let rows = 0..ready.prepared.experiment.rows();
    rows.map(move |k| {
        (0..motors.len())
            .map(|j| coupling[(joint, j)] * motors[j][k])
            .sum()
    })
}

fn position(ready: &PreparedRecording<'_>, joint: usize) -> Option<Mistake> {
    let description = &ready.model.tree().joints()[joint];
    let limits = &description.limits;
    let (lower, upper) = (limits.lower?, limits.upper?);
    let offset = ready.model.offset()[joint];
    let motors = &ready.prepared.experiment.motion.position;
    let joints = of_joint(ready, motors, joint);
    let slack = POSITION_SLACK * (upper - lower);
    let range = [lower - slack, upper + slack];
    let Overshoot { value, by, count } = Overshoot::of(joints.map(|q| q + offset), range)?;
    let unit = description.kind.position_unit();
    Some(finding(
        Severity::Warning,
        ready.at_channel_of(joint),
        Description::new(
            "position-beyond-limits",
            format!(
                "the position reaches {value:.4} {unit}, {:.4} beyond the limits {lower:.4} .. {upper:.4} of the \
                 robot file, in {count} of {} rows",
                by + slack,
                ready.prepared.experiment.rows()
            ),
            "check sign, unit, zero (drive.offset) and joint order of the positions; or correct the limits",
        ),
    ))
}

fn velocity(ready: &PreparedRecording<'_>, joint: usize) -> Option<Mistake> {
    let description = &ready.model.tree().joints()[joint];
    let limit = description.limits.velocity.filter(|limit| *limit > 0.0)?;
    let series = of_joint(ready, &ready.prepared.experiment.motion.velocity, joint);
    let most = (1.0 + VELOCITY_SLACK) * limit;
    let Overshoot { value, count, .. } = Overshoot::of(series, [-most, most])?;
    let unit = description.kind.position_unit();
    Some(finding(
        Severity::Warning,
        ready.at_channel_of(joint),
        Description::new(
            "velocity-beyond-limits",
            format!(
                "the speed reaches {:.4} {unit}/s, the robot file allows {limit:.4} {unit}/s; {count} of {} rows",
                value.abs(),
                ready.prepared.experiment.rows()
            ),
            "check the units of position and time, and recordings.differentiation.cutoff_hz",
        ),
    ))
}

fn effort(ready: &PreparedRecording<'_>, joint: usize) -> Option<Mistake> {
    let description = &ready.model.tree().joints()[joint];
    let limit = description.limits.effort.filter(|limit| *limit > 0.0)?;
    // A coupled motor carries the torque of several joints; an error of the position is no effort.
    let is_effort = !matches!(
        ready.model.signal(),
        Signal::BaseWrench | Signal::PositionCommand
    );
    if !is_effort || !ready.model.is_uncoupled() {
        return None;
    }
    let constant = ready.model.joints()[joint].torque_constant;
    let series = ready.prepared.experiment.signal[joint]
        .iter()
        .map(|s| s * constant);
    let most = (1.0 + EFFORT_SLACK) * limit;
    let Overshoot { value, count, .. } = Overshoot::of(series, [-most, most])?;
    let rows = ready.prepared.experiment.rows();
    let unit = description.kind.effort_unit();
    (count as f64 > EFFORT_ROWS * rows as f64).then(|| {
        finding(
            Severity::Warning,
            ready.at_channel_of(joint),
            Description::new(
                "effort-beyond-limits",
                format!(
                    "{count} of {rows} rows exceed the robot file's limit {limit:.4} {unit}; the largest is \
                     {:.4} {unit}",
                    value.abs()
                ),
                "check recordings.signal (current or torque, motor or joint side) and drive.torque_constant; or \
                 correct the limit",
            ),
        )
    })
}
