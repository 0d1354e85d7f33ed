//! A signal with the wrong sign: friction would drive the joint instead of braking it.
//!
//! `P = mean((Fc·sign(q̇) + Fv·q̇)·q̇)` is the power lost in friction, which cannot be negative; nor can the
//! factor between the signal and the torque that the robot file's inertials give.

use crate::chain::effect::knowledge::JointTerm;
use crate::check::context::PreparedRecording;
use crate::check::regression::{Comparison, factor, last_coefficients, rest};
use crate::check::report::finding;
use crate::check::scale;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use nalgebra::DVector;

/// Standard deviations by which the power must be negative. Residuals of neighbouring rows go together, so
/// the true deviation is a few times the one of independent rows.
const NEGATIVE_SIGMA: f64 = 15.0;

/// Share of the signal that the negative friction must make up.
const LEAST_SHARE: f64 = 0.03;

pub(super) fn check(ready: &PreparedRecording<'_>) -> Vec<Mistake> {
    let comparison = &ready.comparison;
    // Where columns are mixed up, what they say of friction is no evidence.
    if !comparison.is_meaningful() || !ready.other_reading.is_empty() {
        return Vec::new();
    }
    let factors = scale::factors(ready);
    let channels = comparison.joint_channels();
    channels
        .into_iter()
        .filter(|&(_, joint)| comparison.moves(joint))
        .filter_map(|(channel, joint)| {
            let friction = friction(comparison, channel, joint)?;
            let against_file = factors.iter().find(|f| f.channel == channel && f.value < 0.0);
            let (severity, reason) = match (friction.is_negative(), against_file) {
                (true, _) => (
                    Severity::Error,
                    format!(
                        "friction would give the joint {:.3} W on the average instead \
                         of taking it ({:.0} standard deviations)",
                        -friction.power,
                        friction.deviations()
                    ),
                ),
                // Without friction that speaks, the file's centres of mass may be what is wrong.
                (false, Some(f)) if friction.power <= 0.0 => (
                    Severity::Warning,
                    format!(
                        "the torque is {:.3} times what the robot file's inertials give, if these are right",
                        f.value
                    ),
                ),
                _ => return None,
            };
            Some(finding(
                severity,
                ready.at_channel(channel),
                Description::new(
                    "signal-sign",
                    format!("the signal has the wrong sign: {reason}"),
                    "signals are what the motor exerts, positive along positive motion: change the sign of this \
                     channel (a negative torque constant does)",
                ),
            ))
        })
        .collect()
}

/// Friction of a joint as its own channel shows it.
struct Friction {
    /// Mean power lost, W.
    power: f64,
    deviation: f64,
    /// Root mean square friction over that of the signal.
    share: f64,
}

impl Friction {
    fn deviations(&self) -> f64 {
        self.power.abs() / self.deviation.max(f64::MIN_POSITIVE)
    }

    fn is_negative(&self) -> bool {
        self.power < -NEGATIVE_SIGMA * self.deviation && self.share > LEAST_SHARE
    }
}

fn friction(comparison: &Comparison, channel: usize, joint: usize) -> Option<Friction> {
    let model = &comparison.model;
    let own = |term: JointTerm| {
        let found = model.joints()[joint]
            .effects
            .iter()
            .find(|(effect, _)| effect.knowledge.term == Some(term));
        found.map(|(_, first)| *first)
    };
    let friction = [
        own(JointTerm::DryFriction)?,
        own(JointTerm::ViscousFriction)?,
    ];
    let is_friction = |p: usize| friction.contains(&p);
    let mut columns = comparison.columns[channel].clone();
    // Friction last: its coefficients follow from the last rows of the factor alone.
    columns.sort_by_key(|(p, _)| (is_friction(*p), *p));
    if columns.iter().filter(|(p, _)| is_friction(*p)).count() != 2 {
        return None;
    }
    let torque = &comparison.torque[channel];
    let factor = factor(&columns, &[torque]);
    let (coefficients, covariance) = last_coefficients(&factor, columns.len(), 2)?;
    let rows = comparison.sampled.len() as f64;
    let velocity = &comparison.sampled.velocity[joint];
    let series = [&columns[columns.len() - 2].1, &columns[columns.len() - 1].1];
    let mean = |column: &[f64]| column.iter().zip(velocity).map(|(y, v)| y * v).sum::<f64>() / rows;
    let weights = DVector::from_vec(vec![mean(series[0]), mean(series[1])]);
    let variance = rest(&factor, columns.len(), 0).powi(2) / rows;
    let loss = |k: usize| coefficients[0] * series[0][k] + coefficients[1] * series[1][k];
    let lost: f64 = (0..velocity.len()).map(|k| loss(k).powi(2)).sum();
    let total: f64 = torque.iter().map(|t| t * t).sum();
    Some(Friction {
        power: weights.dot(&coefficients),
        deviation: (variance * (weights.transpose() * covariance * &weights)[(0, 0)]).sqrt(),
        share: (lost / total.max(f64::MIN_POSITIVE)).sqrt(),
    })
}
