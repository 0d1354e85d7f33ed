//! What formulas are made of: the motion of a joint and of others over the fitted rows, the load of its gear, and what the
//! signal shows of a torque.

use crate::chain::dataset::Prepared;
use crate::chain::effect::user_law::{self, ActsOn, LawText, ParameterText, SearchText};
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::quantity::Quantity;

/// A law of nothing that shows what a torque, and what a share of the load, does to the signal.
const PROBE: &str = "formula_probe";
const PROBED: [&str; 2] = ["torque", "share"];

/// Motion and load of a joint, and motion of others.
#[derive(Debug, Clone)]
pub struct FittedRows {
    pub joint: usize,
    series: Vec<(Quantity, Vec<f64>)>,
    /// `v/(|v| + w)`.
    pub direction: Vec<f64>,
    /// What a torque of one adds to the residual of the channel, in units of its deviation.
    pub by_torque: Vec<f64>,
    /// rad or m between two rows at most.
    pub longest_step: f64,
}

/// Least and greatest of a series.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    pub least: f64,
    pub greatest: f64,
}

impl Extent {
    pub fn of(series: &[f64]) -> Self {
        Self {
            least: series.iter().copied().fold(f64::INFINITY, f64::min),
            greatest: series.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    pub fn range(self) -> f64 {
        self.greatest - self.least
    }

    pub fn largest(self) -> f64 {
        self.greatest.abs().max(self.least.abs())
    }
}

/// A channel with recordings along which its formula is sought, and the deviation of its residual.
pub struct Place<'a> {
    pub channel: usize,
    pub recordings: &'a [Prepared],
    pub deviation: f64,
}

impl FittedRows {
    /// Of the joint of a channel; `None` where no torque of its motor shows there.
    pub fn of(context: &Context<'_>, fit: &ModelFit, place: &Place<'_>) -> Option<Self> {
        let joint = fit.model.channels()[place.channel].joint?;
        let recordings: Vec<&Prepared> = place.recordings.iter().collect();
        let [by_torque, by_share] = probed(context, fit, joint, place.channel, &recordings)?;
        let motion = |pick: &dyn Fn(&Prepared) -> Vec<f64>| -> Vec<f64> {
            recordings.iter().flat_map(|r| pick(r)).collect()
        };
        let position =
            |k: usize| motion(&|r| r.counted_for(place.channel, &r.segment().motors.q[k]));
        let velocity =
            |k: usize| motion(&|r| r.counted_for(place.channel, &r.segment().motors.dq[k]));
        let load = by_share.iter().zip(&by_torque);
        let load = load.map(|(share, torque)| share / torque).collect();
        let speed = velocity(joint);
        let direction = speed.iter().map(fit.direction(joint)).collect();
        let step = |r: &&Prepared| {
            let rate = r.experiment.rate_hz / r.stride as f64;
            Extent::of(&r.segment().motors.dq[joint]).largest() / rate
        };
        let longest_step = recordings.iter().map(step).fold(0.0, f64::max);
        let mut series = vec![
            (Quantity::Position, position(joint)),
            (Quantity::Velocity, speed),
            (
                Quantity::Acceleration,
                motion(&|r| r.counted_for(place.channel, &r.segment().motors.ddq[joint])),
            ),
            (Quantity::Load, load),
        ];
        for (k, other) in fit.model.joints().iter().enumerate() {
            let (q, v) = (position(k), velocity(k));
            let moves = Extent::of(&v).range() > 0.0;
            if k != joint && !other.locked && moves && is_written(&other.name) {
                series.push((Quantity::OtherPosition(k), q));
                series.push((Quantity::OtherVelocity(k), v));
            }
        }
        Some(Self {
            joint,
            series,
            direction,
            by_torque: by_torque.iter().map(|x| x / place.deviation).collect(),
            longest_step,
        })
    }

    pub fn series(&self, quantity: Quantity) -> &[f64] {
        let found = self.series.iter().find(|(own, _)| *own == quantity);
        found.map_or(&[], |(_, series)| series.as_slice())
    }

    pub fn extent(&self, quantity: Quantity) -> Extent {
        Extent::of(self.series(quantity))
    }

    /// The other joints that move, by number.
    pub fn others(&self) -> impl Iterator<Item = usize> + '_ {
        self.series
            .iter()
            .filter_map(|(quantity, _)| match quantity {
                Quantity::OtherPosition(joint) => Some(*joint),
                _ => None,
            })
    }

    pub fn count(&self) -> usize {
        self.direction.len()
    }
}

/// Whether a formula can have the name of a joint in it.
fn is_written(joint: &str) -> bool {
    !joint.contains([']', '"', '\'', '\\']) && joint.trim() == joint
}

/// What a torque of one, and the whole load as a torque, add to a channel.
fn probed(
    context: &Context<'_>,
    fit: &ModelFit,
    joint: usize,
    channel: usize,
    recordings: &[&Prepared],
) -> Option<[Vec<f64>; 2]> {
    let parameter = |name: &&str| ParameterText {
        name: (*name).to_string(),
        unit: None,
        meaning: String::new(),
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        typical: 1.0,
        search: SearchText::Typical,
    };
    let text = LawText {
        id: PROBE.to_string(),
        sentence: "What a torque and a share of the load do to the signal.".to_string(),
        source: String::new(),
        acts_on: ActsOn::Motor,
        torque: format!("{} + {}*tau", PROBED[0], PROBED[1]),
        states: Vec::new(),
        parameters: PROBED.iter().map(parameter).collect(),
        refines: Vec::new(),
    };
    let mut hypotheses = fit.hypotheses.clone();
    hypotheses.push(Hypothesis {
        effect: user_law::effect(&text).ok()?,
        joints: vec![joint],
        other: None,
    });
    let model = context.model(&hypotheses).ok()?.model;
    let name = &fit.model.joints()[joint].name;
    let mut columns = Vec::new();
    for parameter in PROBED {
        columns.push(model.position(&format!("{name}.{PROBE}.{parameter}"))?);
    }
    let mut values = fit.values_of(&model);
    columns.iter().for_each(|&k| values[k] = 0.0);
    let series = ChannelSeries::of(&model, &values, &columns, recordings);
    let [torque, share] = [0, 1].map(|k| series.columns[channel][k].clone());
    let torque = torque.filter(|t| t.iter().all(|x| *x != 0.0 && x.is_finite()))?;
    Some([torque, share?])
}

#[cfg(test)]
impl FittedRows {
    /// Random motion and load of a joint, and random motion of joint 1.
    pub fn drawn(count: usize) -> Self {
        use crate::robot::random::{generator, symmetric};
        let series = |seed: u64, size: f64| -> Vec<f64> {
            let mut rng = generator(seed);
            (0..count).map(|_| symmetric(&mut rng, size)).collect()
        };
        let speed = series(2, 1.5);
        Self {
            joint: 0,
            direction: speed.iter().map(|v| v / (v.abs() + 0.01)).collect(),
            series: vec![
                (Quantity::Position, series(1, 2.0)),
                (Quantity::Velocity, speed),
                (Quantity::Acceleration, series(3, 4.0)),
                (Quantity::Load, series(6, 3.0)),
                (Quantity::OtherPosition(1), series(4, 1.0)),
                (Quantity::OtherVelocity(1), series(5, 0.7)),
            ],
            by_torque: vec![1.0; count],
            longest_step: 0.05,
        }
    }
}
