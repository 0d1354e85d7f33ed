//! The range over which the nonlinear parameters of a law are searched for, from the motion of its joint.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect::Search;
use crate::chain::effect_parameter::EffectParameter;
use crate::chain::model::Model;
use crate::chain::parameter::Parameter;
use crate::recording::split::Split;
use std::f64::consts::{PI, TAU};

/// Cycles over the range of positions between one order and the next: half of what tells two apart.
const CYCLES: f64 = 0.5;

/// Orders that are scanned at most.
const MOST_ORDERS: usize = 600;

/// Where a parameter starts, and its limits.
#[derive(Debug, Clone, Copy)]
pub struct Bounded {
    /// In the parameter's unit.
    pub value: f64,
    /// Its lower limit.
    pub lower: f64,
    /// Its upper limit.
    pub upper: f64,
}

impl Bounded {
    /// Of a parameter of a model.
    pub fn of(parameter: &Parameter) -> Self {
        Self {
            value: parameter.value,
            lower: parameter.lower,
            upper: parameter.upper,
        }
    }
}

/// What a joint did in recordings, as far as searches depend on it.
#[derive(Debug, Clone, Copy)]
pub struct MotionRange {
    /// Least position of the motor at joint scale, rad (m).
    pub least: f64,
    /// Greatest position, rad (m).
    pub greatest: f64,
    /// Greatest speed, rad/s (m/s).
    pub fastest: f64,
    /// s.
    pub duration: f64,
    /// rad/s or m/s over the rate: the longest way between two rows.
    pub longest_step: f64,
}

impl MotionRange {
    /// Of one joint over all recordings.
    pub fn of(recordings: &[&Prepared], joint: usize) -> Self {
        let mut motion = Self {
            least: f64::INFINITY,
            greatest: f64::NEG_INFINITY,
            fastest: 0.0,
            duration: 0.0,
            longest_step: 0.0,
        };
        for recording in recordings {
            let trajectory = recording.segment().motors;
            for q in &trajectory.q[joint] {
                motion.least = motion.least.min(*q);
                motion.greatest = motion.greatest.max(*q);
            }
            for v in &trajectory.dq[joint] {
                motion.fastest = motion.fastest.max(v.abs());
            }
            let rate = recording.experiment.rate_hz / recording.stride as f64;
            motion.longest_step = motion.longest_step.max(motion.fastest / rate);
            motion.duration = motion.duration.max(recording.rows() as f64 / rate);
        }
        motion
    }

    /// Whether most of what a law does over a scale of speed happens within the speeds of the joint: a Stribeck effect
    /// falls to 37 %, a sigmoid comes to tanh(1), three quarters. Otherwise it is a line with some bend, as others are. What
    /// repeats does so within the range of positions: one cycle at least, where the search begins, less half of what is
    /// between two of its orders.
    pub fn covers(&self, search: Search, value: f64) -> bool {
        match search {
            Search::Speed(_) => value.abs() <= self.fastest,
            Search::OverSpeed(_) => value.abs() * self.fastest >= 2.0,
            Search::Cycles => {
                let range = self.greatest - self.least;
                value.abs() * range >= (1.0 - 0.5 * CYCLES) * TAU
            }
            _ => true,
        }
    }

    /// Values to try of a parameter.
    pub fn grid(&self, search: Search, parameter: Bounded) -> Vec<f64> {
        let Bounded {
            value,
            lower,
            upper,
        } = parameter;
        let range = self.greatest - self.least;
        let shares = |shares: &[f64], of: f64, from: f64| -> Vec<f64> {
            shares.iter().map(|share| from + share * of).collect()
        };
        let mut values = match search {
            Search::Typical => vec![value],
            Search::Values(values) | Search::Rising(values) => values.to_vec(),
            Search::Position(of) => shares(of, range, self.least),
            Search::Range(of) => shares(of, range, 0.0),
            Search::Speed(of) => shares(of, self.fastest, 0.0),
            Search::OverSpeed(of) => shares(of, 1.0 / self.fastest, 0.0),
            Search::Duration(of) | Search::Instant(of) => shares(of, self.duration, 0.0),
            Search::Cycles => {
                let step = TAU * CYCLES / range;
                let most = PI / self.longest_step;
                let count = ((most / step) as usize).min(MOST_ORDERS);
                (2..=count).map(|k| k as f64 * step).collect()
            }
        };
        values.retain(|x| x.is_finite() && (lower..=upper).contains(x));
        if values.is_empty() {
            values.push(value);
        }
        values
    }
}

/// Sizes of a law inside another that are tried, as shares of the joint's largest torque.
const OF_TORQUE: [f64; 3] = [0.02, 0.08, 0.3];

/// Sizes, in the unit of torque, from which searches begin for dry friction that stands inside another law: from too small a one
/// bristles slide at once, and no step by derivatives leads back.
pub fn lent_sizes(model: &Model, recordings: &[&Prepared], joint: usize) -> Vec<f64> {
    let torque = largest_torque(model, recordings, joint).unwrap_or(0.0);
    let shares = OF_TORQUE.iter().filter(|_| torque > 0.0);
    shares.map(|share| share * torque).collect()
}

/// The largest recorded torque of a joint; `None` where there is none.
pub fn largest_torque(model: &Model, recordings: &[&Prepared], joint: usize) -> Option<f64> {
    let mut channels = model.channels().iter();
    let channel = channels.position(|c| c.active && c.joint == Some(joint))?;
    let signals = recordings.iter().flat_map(|r| r.signal(channel));
    let largest = signals.fold(0.0_f64, |largest, s| largest.max(s.abs()));
    let torque = largest * model.torque_per_signal(joint).abs();
    (torque > 0.0).then_some(torque)
}

/// Lets positions that laws are about start within the motion: where they begin outside, a law that acts on one side of them
/// may do nothing, and no search sees it. Starts that were stated, by the problem or the robot's file, stay.
pub fn start_within_motion(model: &mut Model, data: &Dataset) {
    let train: Vec<&Prepared> = data.of(Split::Train).collect();
    let mut moved = Vec::new();
    for (at, parameter) in model.parameters().iter().enumerate() {
        let Some(EffectParameter { joint, info, .. }) = model.effect_parameter(at) else {
            continue;
        };
        let Search::Position(shares) = info.search else {
            continue;
        };
        let motion = MotionRange::of(&train, joint);
        let is_outside = !(motion.least..=motion.greatest).contains(&parameter.value);
        let is_stated = parameter.value != info.typical;
        let may_move = parameter.is_free() && !is_stated;
        if may_move && is_outside && motion.least < motion.greatest {
            let share = shares[shares.len() / 2];
            moved.push((at, motion.least + share * (motion.greatest - motion.least)));
        }
    }
    for (at, value) in moved {
        model.start(at, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_of_speed_shows_where_the_joint_is_fast_enough_for_it_to_change() {
        let motion = MotionRange {
            least: -1.0,
            greatest: 1.0,
            fastest: 2.0,
            duration: 10.0,
            longest_step: 0.01,
        };
        let fall = Search::Speed(&[0.1]);
        assert!(motion.covers(fall, 1.9) && !motion.covers(fall, 2.1));
        let rise = Search::OverSpeed(&[2.0]);
        assert!(motion.covers(rise, 1.1) && motion.covers(rise, -1.1) && !motion.covers(rise, 0.9));
        let cycle = TAU / 2.0;
        assert!(
            motion.covers(Search::Cycles, 0.8 * cycle)
                && !motion.covers(Search::Cycles, 0.7 * cycle)
        );
        assert!(motion.covers(Search::Typical, 1e9));
    }

    #[test]
    fn values_to_try_are_shares_of_what_the_joint_did() {
        let motion = MotionRange {
            least: -1.0,
            greatest: 3.0,
            fastest: 2.0,
            duration: 10.0,
            longest_step: 0.0101,
        };
        let open = Bounded {
            value: 7.0,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
        };
        let of = |search: Search| motion.grid(search, open);
        assert_eq!(of(Search::Position(&[0.25, 1.0])), [0.0, 3.0]);
        assert_eq!(of(Search::Range(&[0.25, 1.0])), [1.0, 4.0]);
        assert_eq!(of(Search::Speed(&[0.25, 1.0])), [0.5, 2.0]);
        assert_eq!(of(Search::OverSpeed(&[0.5, 2.0])), [0.25, 1.0]);
        assert_eq!(of(Search::Duration(&[0.25, 1.0])), [2.5, 10.0]);
        assert_eq!(of(Search::Instant(&[0.25, 1.0])), [2.5, 10.0]);
        assert_eq!(of(Search::Values(&[-3.0, 4.0])), [-3.0, 4.0]);
        assert_eq!(of(Search::Typical), [7.0]);
        // Orders are half a cycle over the range apart, from one cycle to half of the rate of rows.
        let orders = of(Search::Cycles);
        assert_eq!(orders.len(), 395);
        assert!((orders[0] - TAU / 4.0).abs() < 1e-12);
        assert!((orders[394] - 396.0 * TAU / 8.0).abs() < 1e-9);
        let limited = Bounded {
            value: 0.7,
            lower: 0.5,
            upper: 1.0,
        };
        let within = |search: Search| motion.grid(search, limited);
        assert_eq!(within(Search::Range(&[0.125, 0.2, 0.5])), [0.5, 0.8]);
        assert_eq!(within(Search::Range(&[0.5])), [0.7]);
    }
}
