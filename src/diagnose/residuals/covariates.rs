//! Covariates: the variables over which a residual may be spread: speed, position, load, acceleration, time, distance since
//! the last reversal, the motion and the load of other joints.

use crate::chain::dataset::Prepared;
use crate::chain::model::{JointModel, Model};
use crate::diagnose::residuals::quantity::Quantity::{
    self, Acceleration, Load, OtherPosition, OtherVelocity, Position, Velocity,
};
use crate::robot::tree::JointKind;

/// One variable of one joint over the rows that count, recording after recording.
#[derive(Debug, Clone)]
pub struct Covariate {
    /// In words, with the joint where it is another one.
    pub name: String,
    /// Of its values.
    pub unit: &'static str,
    /// Row by row.
    pub values: Vec<f64>,
    /// Whether the residual is looked at by direction of motion too.
    pub by_direction: bool,
    /// The other joint that it is of.
    pub other: Option<usize>,
    /// The variables of the motion that it is made of.
    pub made_of: Vec<Quantity>,
    /// Whether it is one of these as it is, of which functions of two variables are made.
    pub is_state: bool,
}

/// The variables of one joint, and the direction of its motion.
#[derive(Debug, Clone)]
pub struct Covariates {
    /// Those that vary over the rows.
    pub variables: Vec<Covariate>,
    /// +1 or −1.
    pub direction: Vec<f64>,
}

impl Covariates {
    /// Variables of the joint of a channel over the rows that count for it; `loads` are what the model predicts, per channel, over
    /// all rows that count. `None` where the channel is that of no joint.
    pub fn of(
        model: &Model,
        channel: usize,
        loads: &[Vec<f64>],
        recordings: &[&Prepared],
    ) -> Option<Self> {
        let joint = model.channels()[channel].joint?;
        let rows = Rows {
            model,
            channel,
            loads,
            recordings,
        };
        let velocity = rows.speed(joint);
        let mut variables = rows.of_joint(joint);
        for (k, other) in others(model, joint) {
            variables.extend(rows.of_another(k, other, &velocity));
        }
        Some(Self {
            variables,
            direction: velocity.iter().map(|v| 1.0_f64.copysign(*v)).collect(),
        })
    }
}

/// The rows that count for a channel.
struct Rows<'a> {
    model: &'a Model,
    channel: usize,
    loads: &'a [Vec<f64>],
    recordings: &'a [&'a Prepared],
}

impl Rows<'_> {
    fn series(&self, pick: &dyn Fn(&Prepared) -> Vec<f64>) -> Vec<f64> {
        let of = |r: &&Prepared| r.counted_for(self.channel, &pick(r));
        self.recordings.iter().flat_map(of).collect()
    }

    /// A series over all rows that count, at those that count for the channel.
    fn own(&self, series: &[f64]) -> Vec<f64> {
        let counts = self.recordings.iter().flat_map(|r| {
            let counting = r.counting();
            counting.map(|row| r.counts_for(self.channel, row))
        });
        let pairs = series.iter().zip(counts).filter(|(_, counts)| *counts);
        pairs.map(|(x, _)| *x).collect()
    }

    fn position(&self, joint: usize) -> Vec<f64> {
        self.series(&|r| r.segment().motors.q[joint].to_vec())
    }

    fn speed(&self, joint: usize) -> Vec<f64> {
        self.series(&|r| r.segment().motors.dq[joint].to_vec())
    }

    /// What the model predicts for a joint.
    fn load(&self, joint: usize, name: &str) -> Option<Covariate> {
        let mut channels = self.model.channels().iter().zip(self.loads);
        let own = channels.find(|(channel, _)| channel.joint == Some(joint) && channel.active)?;
        Some(named(name, own.0.unit, self.own(own.1)))
    }

    fn of_joint(&self, joint: usize) -> Vec<Covariate> {
        let unit = units(&self.model.joints()[joint]);
        let acceleration = self.series(&|r| r.segment().motors.ddq[joint].to_vec());
        let reversal = self.series(&|r| since_reversal(r, joint));
        let load = self.load(joint, "load");
        vec![
            named("speed", unit[1], self.speed(joint)).state(Velocity),
            named("position", unit[0], self.position(joint))
                .by_direction()
                .state(Position),
            load.unwrap_or_else(|| named("load", "", Vec::new()))
                .by_direction()
                .state(Load),
            named("acceleration", unit[2], acceleration).state(Acceleration),
            named("time", "s", self.series(&times)),
            named("reversal", unit[0], reversal)
                .by_direction()
                .made_of(&[Position, Velocity]),
        ]
    }

    fn of_another(&self, k: usize, other: &JointModel, velocity: &[f64]) -> Vec<Covariate> {
        let unit = units(other);
        let name = |of: &str| format!("{of} {}", other.name);
        let speed = self.speed(k);
        let product = speed.iter().zip(velocity).map(|(a, b)| a * b).collect();
        let motion = [
            named(&name("speed of"), unit[1], speed).state(OtherVelocity(k)),
            named(&name("position of"), unit[0], self.position(k))
                .by_direction()
                .state(OtherPosition(k)),
            named(&name("speed times that of"), "1/s²", product)
                .made_of(&[Velocity, OtherVelocity(k)]),
        ];
        let load = self.load(k, &name("load of"));
        let all = motion.into_iter().chain(load);
        all.map(|variable| Covariate {
            other: Some(k),
            ..variable
        })
        .collect()
    }
}

fn named(name: &str, unit: &'static str, values: Vec<f64>) -> Covariate {
    Covariate {
        name: name.to_string(),
        unit,
        values,
        by_direction: false,
        other: None,
        made_of: Vec::new(),
        is_state: false,
    }
}

impl Covariate {
    fn by_direction(self) -> Self {
        Self {
            by_direction: true,
            ..self
        }
    }

    fn state(self, of: Quantity) -> Self {
        Self {
            made_of: vec![of],
            is_state: true,
            ..self
        }
    }

    fn made_of(self, of: &[Quantity]) -> Self {
        Self {
            made_of: of.to_vec(),
            ..self
        }
    }
}

/// Units of position, speed and acceleration.
fn units(joint: &JointModel) -> [&'static str; 3] {
    match joint.kind {
        JointKind::Revolute => ["rad", "rad/s", "rad/s²"],
        JointKind::Prismatic => ["m", "m/s", "m/s²"],
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
