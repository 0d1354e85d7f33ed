//! The variables over which a residual may be spread: speed, position, load, acceleration, time, distance since
//! the last reversal, the motion of other joints.

use crate::chain::dataset::Prepared;
use crate::chain::model::{JointModel, Model};
use crate::robot::tree::JointKind;

/// One variable of one joint over the rows that count, recording after recording.
#[derive(Debug, Clone)]
pub struct Variable {
    pub name: String,
    pub unit: &'static str,
    pub values: Vec<f64>,
    /// Whether the residual is looked at by direction of motion too.
    pub by_direction: bool,
}

/// The variables of one joint, and the direction of its motion.
#[derive(Debug, Clone)]
pub struct Regimes {
    pub variables: Vec<Variable>,
    /// +1 or −1.
    pub direction: Vec<f64>,
}

impl Regimes {
    /// Variables of `joint`; `load` is the torque that the model predicts there, over the same rows.
    pub fn of(model: &Model, (joint, load): (usize, &[f64]), recordings: &[&Prepared]) -> Self {
        let kind = model.joints()[joint].kind;
        let series = |pick: &dyn Fn(&Prepared) -> Vec<f64>| -> Vec<f64> {
            let of = |r: &&Prepared| {
                let all = pick(r);
                let counting = r.counting();
                counting.map(|row| all[row]).collect::<Vec<f64>>()
            };
            recordings.iter().flat_map(of).collect()
        };
        let velocity = series(&|r| r.segment().motors.dq[joint].to_vec());
        let named = |name: &str, unit, values, by_direction| Variable {
            name: name.to_string(),
            unit,
            values,
            by_direction,
        };
        let turns = kind == JointKind::Revolute;
        let unit = |turning, sliding| if turns { turning } else { sliding };
        let mut variables = vec![
            named("speed", unit("rad/s", "m/s"), velocity.clone(), false),
            named(
                "position",
                unit("rad", "m"),
                series(&|r| r.segment().motors.q[joint].to_vec()),
                true,
            ),
            named("load", model.channels()[joint].unit, load.to_vec(), true),
            named(
                "acceleration",
                unit("rad/s²", "m/s²"),
                series(&|r| r.segment().motors.ddq[joint].to_vec()),
                false,
            ),
            named("time", "s", series(&times), false),
            named(
                "reversal",
                unit("rad", "m"),
                series(&|r| since_reversal(r, joint)),
                true,
            ),
        ];
        for (k, other) in others(model, joint) {
            let turns = other.kind == JointKind::Revolute;
            let unit = |turning, sliding| if turns { turning } else { sliding };
            let speed = series(&|r| r.segment().motors.dq[k].to_vec());
            let product = speed.iter().zip(&velocity).map(|(a, b)| a * b).collect();
            let position = series(&|r| r.segment().motors.q[k].to_vec());
            let name = |of: &str| format!("{of} {}", other.name);
            variables.extend([
                named(&name("speed of"), unit("rad/s", "m/s"), speed, false),
                named(&name("position of"), unit("rad", "m"), position, true),
                named(&name("speed times that of"), "1/s²", product, false),
            ]);
        }
        Self {
            variables,
            direction: velocity.iter().map(|v| 1.0_f64.copysign(*v)).collect(),
        }
    }
}

/// The other joints that move.
fn others(model: &Model, joint: usize) -> impl Iterator<Item = (usize, &JointModel)> {
    let joints = model.joints().iter().enumerate();
    joints.filter(move |(k, other)| *k != joint && !other.locked)
}

fn times(recording: &Prepared) -> Vec<f64> {
    (0..recording.rows()).map(|k| recording.time(k)).collect()
}

/// Whether a speed changes sign between the row before and this one.
pub fn turns(speed: &[f64], row: usize) -> bool {
    row > 0 && (speed[row] < 0.0) != (speed[row - 1] < 0.0)
}

/// Way of a joint since its speed changed sign last, at every row; from the first row on until it does.
fn since_reversal(recording: &Prepared, joint: usize) -> Vec<f64> {
    let motors = recording.segment().motors;
    let (q, v) = (&motors.q[joint], &motors.dq[joint]);
    let mut turned = q.first().copied().unwrap_or(0.0);
    let mut out = Vec::with_capacity(q.len());
    for k in 0..q.len() {
        if turns(v, k) {
            turned = q[k];
        }
        out.push((q[k] - turned).abs());
    }
    out
}
