//! Coverage: whether a motion varies what the law of each effect of the model depends on, as a law shows only where it does.

use crate::chain::effect::Dependence;
use crate::chain::model::Model;
use crate::design::trajectory::motion::Motion;
use crate::setup::limits::JointLimits;

/// Share of the largest speed below which motion is slow, and the least share of time that has to be.
const SLOW: f64 = 0.05;
const SLOW_TIME: f64 = 0.02;

/// Share of the velocity limit, of the range of positions and of the acceleration limit that counts as use.
const FAST: f64 = 0.3;
const WIDE: f64 = 0.3;

/// Least share of time in each direction, and with each sign of transmitted power.
const EACH_WAY: f64 = 0.1;

/// Range of the transmitted torque as a multiple of its mean size.
const LOAD_RANGE: f64 = 0.5;

/// What a motion shows of one effect on one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectCoverage {
    /// Name of the joint.
    pub joint: String,
    /// Identifier of the effect.
    pub effect: &'static str,
    /// The motion varies what the effect's law depends on.
    pub shown: bool,
    /// The same in words, with the figures.
    pub sentence: String,
}

/// What one joint does.
struct Figures {
    fast: f64,
    slow_time: f64,
    forward: f64,
    reversals: usize,
    range: f64,
    acceleration: f64,
    driving: f64,
    load_range: f64,
}

impl Figures {
    fn of(motion: [&[f64]; 3], torque: &[f64], limits: &JointLimits) -> Self {
        let [q, dq, ddq] = motion;
        let peak = |series: &[f64]| series.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let count = q.len() as f64;
        let share =
            |test: &dyn Fn(usize) -> bool| (0..q.len()).filter(|k| test(*k)).count() as f64 / count;
        let largest = peak(dq);
        let spread = |series: &[f64]| {
            let low = series.iter().copied().fold(f64::INFINITY, f64::min);
            series.iter().copied().fold(f64::NEG_INFINITY, f64::max) - low
        };
        let mean = torque.iter().map(|t| t.abs()).sum::<f64>() / count;
        let next = |k: usize| (k + 1) % dq.len();
        Self {
            fast: largest / limits.velocity,
            slow_time: share(&|k| dq[k].abs() < SLOW * largest),
            forward: share(&|k| dq[k] > 0.0),
            reversals: (0..dq.len())
                .filter(|&k| (dq[k] > 0.0) != (dq[next(k)] > 0.0))
                .count(),
            range: spread(q) / (limits.upper - limits.lower),
            acceleration: peak(ddq) / limits.acceleration,
            driving: share(&|k| torque[k] * dq[k] > 0.0),
            load_range: if mean > 0.0 {
                spread(torque) / mean
            } else {
                0.0
            },
        }
    }

    /// Whether the motion varies a variable enough, and the figure that says so.
    fn judge(&self, on: Dependence) -> Variation {
        let percent = |x: f64| format!("{:.0} %", 100.0 * x);
        let (is_enough, figure) = match on {
            Dependence::Direction => (
                (EACH_WAY..=1.0 - EACH_WAY).contains(&self.forward),
                format!(
                    "{} reversals, forward {} of the time",
                    self.reversals,
                    percent(self.forward)
                ),
            ),
            Dependence::Speed => (
                self.fast >= FAST && self.slow_time >= SLOW_TIME,
                format!(
                    "up to {} of the velocity limit, slow {} of the time",
                    percent(self.fast),
                    percent(self.slow_time)
                ),
            ),
            Dependence::Position => (
                self.range >= WIDE,
                format!("{} of the range of positions", percent(self.range)),
            ),
            Dependence::Acceleration => (
                self.acceleration >= 0.1 * FAST,
                format!(
                    "up to {} of the acceleration limit",
                    percent(self.acceleration)
                ),
            ),
            // A current is a load that a motor gives.
            Dependence::Load | Dependence::Current => (
                (EACH_WAY..=1.0 - EACH_WAY).contains(&self.driving)
                    && self.load_range >= LOAD_RANGE,
                format!(
                    "the joint's torque drives {} of the time and ranges over {:.1} times its mean size",
                    percent(self.driving),
                    self.load_range
                ),
            ),
            Dependence::Time => (true, "the motion repeats".to_string()),
            Dependence::OtherJoints => (true, "the other joints move".to_string()),
            Dependence::Gravity => (
                self.range >= WIDE,
                format!("gravity turns over {} of the range", percent(self.range)),
            ),
            Dependence::Temperature => (
                false,
                "no motion of one length makes a drive warm: record it cold and warm".to_string(),
            ),
            Dependence::Nothing => (true, "a constant needs no motion of its own".to_string()),
        };
        Variation { is_enough, figure }
    }
}

/// How far a motion varies a variable.
struct Variation {
    is_enough: bool,
    figure: String,
}

/// What a motion shows of all effects; `torques` are the joint torques along it.
pub fn of_motion(
    model: &Model,
    motors: &Motion,
    torques: &[Vec<f64>],
    limits: &[JointLimits],
) -> Vec<EffectCoverage> {
    let mut all = Vec::new();
    for (j, joint) in model.joints().iter().enumerate().filter(|(_, j)| !j.locked) {
        let [q, dq, ddq] = &motors.values;
        let figures = Figures::of([&q[j], &dq[j], &ddq[j]], &torques[j], &limits[j]);
        for (effect, _) in &joint.effects {
            let variations: Vec<Variation> = effect
                .depends_on
                .iter()
                .map(|on| figures.judge(*on))
                .collect();
            let shown = variations.iter().all(|v| v.is_enough);
            let weak: Vec<String> = variations
                .into_iter()
                .filter(|v| shown || !v.is_enough)
                .map(|v| v.figure)
                .collect();
            all.push(EffectCoverage {
                joint: joint.name.clone(),
                effect: effect.id,
                shown,
                sentence: weak.join("; "),
            });
        }
    }
    all
}
