//! Effect size: the share of the held-out residual that a finding explains.

use crate::chain::dataset::Prepared;
use crate::chain::effect::{Law, Memory};
use crate::chain::model::Model;
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::clear_band;
use crate::diagnose::residuals::reversal_mask;
use crate::recording::split::Split;
use crate::stats::deviation::rms;
use crate::stats::distribution::Distribution;
use crate::stats::encompassing::correlation_time;

/// An effect matters where it lowers the held-out RMS error of a joint by this share.
pub const MATTERS: f64 = 0.01;

/// Half of the share of the squares of a joint whose loss lowers its RMS error by what matters.
pub const HALF_OF_WHAT_MATTERS: f64 = 0.5 * (1.0 - (1.0 - MATTERS) * (1.0 - MATTERS));

/// An effect that takes less than this share of the RMS signal of every joint is negligible.
pub const OF_TORQUE: f64 = 0.002;

/// An effect that takes less than this many times the RMS noise of a row is negligible: what the errors of
/// differentiation leave at reversals reaches a quarter of the variance of the noise, to which bandwidths are chosen.
pub const OF_NOISE: f64 = 0.5;

/// Probability with which it is refuted that an effect takes so much.
const REFUTED: f64 = 0.95;

/// A delay of less than this share of the interval between samples is none: stamps of samples are not better.
const OF_INTERVAL: f64 = 0.05;

/// Deviations by which the speed around a reversal may be off: one is what noise does, and what the motion of a controller that
/// answers friction does beyond the model of the smoother is some more.
const CLEAR_OF_REVERSALS: f64 = 10.0;

/// Largest share by which the held-out RMS error of a joint falls where the effect is worth the name: what it
/// takes away has to be [`OF_TORQUE`] of the signal itself and [`OF_NOISE`] of the noise. Where it filters the motion
/// only what it takes from frequencies at which that stands clear of its noise counts, and where it shifts the motion
/// in time, by no more than a reversal may be off, only what it takes while the joint is under way. Friction that remembers shows
/// around reversals alone, and has to take more than a speed that is off there leaves.
pub fn error_reduction(context: &Context<'_>, hypothesis: &Hypothesis, pair: FitPair<'_>) -> f64 {
    let FitPair {
        poorer: before,
        richer: after,
    } = pair;
    let held_out = context.recordings(Split::Validation);
    let filters = matches!(hypothesis.effect.law, Law::Spring);
    let band = filters.then(|| clear_band::band(context, hypothesis));
    let shifts = matches!(hypothesis.effect.law, Law::Delay);
    let delay = longest_delay(after, hypothesis);
    if shifts && delay < least_delay(&held_out) {
        return 0.0;
    }
    let is_friction = matches!(hypothesis.effect.law, Law::Motor(_) | Law::Joint(_));
    let remembers = is_friction && hypothesis.effect.needs.memory == Memory::WholeMotion;
    let is_hidden = |joint: &usize| delay < CLEAR_OF_REVERSALS * reversal_error(&held_out, *joint);
    let of = |c: usize| {
        let joint = after.model.channels()[c].joint.filter(|_| shifts);
        let joint = joint.filter(is_hidden);
        let under_way = joint.and_then(|_| reversal_mask::rows(context, after, c));
        let left = |residual: &[f64]| match (band, &under_way) {
            (Some(band), _) => clear_band::rms(residual, band),
            (_, Some(rows)) => rms(&reversal_mask::kept(residual, rows)),
            _ => rms(residual),
        };
        let (old, new) = (left(&before.validation[c]), left(&after.validation[c]));
        let taken = (old * old - new * new).max(0.0).sqrt();
        let signals = held_out.iter().flat_map(|r| r.counted_for(c, r.signal(c)));
        let signal = rms(&signals.collect::<Vec<f64>>());
        // Where nothing tells the noise, it is at most what is left.
        let noise = context.noise.as_ref().map_or(new, |noise| noise[c]);
        let joint = after.model.channels()[c].joint;
        let joint = joint.filter(|joint| remembers && hypothesis.joints.contains(joint));
        let is_clear = |joint| taken >= left_by_reversals(before, &held_out, c, joint);
        let counts = taken >= (OF_TORQUE * signal).max(OF_NOISE * noise);
        (counts && joint.is_none_or(is_clear)).then_some(1.0 - new / old)
    };
    let named = hypothesis.named_joints();
    let own = |joint: Option<usize>| joint.is_none_or(|joint| named.contains(&joint));
    let channels = (0..before.validation.len()).filter(|&c| {
        !before.validation[c].is_empty() && (!shifts || own(after.model.channels()[c].joint))
    });
    channels.filter_map(of).fold(0.0, f64::max)
}

/// Where a model leaves room for an effect that matters: one that takes [`OF_NOISE`] of the noise of a channel. The model without it
/// then leaves 1 + OF_NOISE² of the variance of the noise at least; where so much is refuted by what it leaves (F test), the search need
/// not look.
#[derive(Debug)]
pub struct Room<'a> {
    model: &'a Model,
    /// Whether there is some in each channel; `None` where nothing tells the noise.
    channels: Option<Vec<bool>>,
}

impl<'a> Room<'a> {
    /// Beside a model, on the held-out rows.
    pub fn beside(context: &Context<'_>, fit: &'a ModelFit) -> Self {
        let of_noise = |noise: &Vec<f64>| {
            let channels = fit.validation.iter().zip(noise);
            channels
                .map(|(left, noise)| may_leave_more(left, *noise))
                .collect()
        };
        Self {
            model: &fit.model,
            channels: context.noise.as_ref().map(of_noise),
        }
    }

    /// Whether there is some for a hypothesis, in a channel that it moves. What moves a joint away from its motor moves the loads of all
    /// others, a delay is judged by a part of the rows, and where nothing tells the noise, every hypothesis may matter.
    pub fn has_some_for(&self, hypothesis: &Hypothesis) -> bool {
        let Some(channels) = &self.channels else {
            return true;
        };
        let law = hypothesis.effect.law;
        let in_one = || match law.moves_joints() {
            true => channels.contains(&true),
            false => {
                let moved = hypothesis.moved_channels(self.model);
                moved.into_iter().any(|c| channels[c])
            }
        };
        matches!(law, Law::Delay) || in_one()
    }
}

/// Whether it is not refuted that a residual is of 1 + OF_NOISE² of the variance of the noise.
fn may_leave_more(residual: &[f64], noise: f64) -> bool {
    if residual.is_empty() {
        return false;
    }
    let effective = residual.len() as f64 / correlation_time(residual);
    let spread = Distribution::variance_ratio(effective);
    let most = (1.0 + OF_NOISE * OF_NOISE) * noise * noise;
    let above = spread.upper_tail(rms(residual).powi(2) / most);
    above.is_nan() || above <= REFUTED
}

/// Share by which a model's held-out RMS error exceeds another's, the largest over the joints.
pub fn error_excess(pair: FitPair<'_>, joints: &[usize]) -> f64 {
    let held_out = pair.held_out();
    let of = |&j: &usize| match (held_out.poorer.get(j), held_out.richer.get(j)) {
        (Some(poorer), Some(richer)) if !richer.is_empty() => rms(poorer) / rms(richer) - 1.0,
        _ => 0.0,
    };
    joints.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
}

/// s, of the joints of a hypothesis.
fn longest_delay(fit: &ModelFit, hypothesis: &Hypothesis) -> f64 {
    let joints = hypothesis.joints.iter();
    let delays = joints.filter_map(|&j| fit.model.joints()[j].delay);
    delays.map(|k| fit.values[k].abs()).fold(0.0, f64::max)
}

/// RMS of what a model predicts otherwise of a channel where a joint's speed is off by as much as it may be around reversals.
fn left_by_reversals(
    fit: &ModelFit,
    recordings: &[&Prepared],
    channel: usize,
    joint: usize,
) -> f64 {
    let off = |recording: &&Prepared| {
        let error = recording.experiment.motion_error.as_ref();
        let deviation = error.map_or(0.0, |error| error.velocity.deviation(joint));
        recording.with_speed_off_by(joint, CLEAR_OF_REVERSALS * deviation)
    };
    let off: Vec<Prepared> = recordings.iter().map(off).collect();
    let off: Vec<&Prepared> = off.iter().collect();
    let [there, off] = [recordings, &off]
        .map(|of| ChannelSeries::predicted_of(channel, &fit.model, &fit.values, of));
    let differences = there.iter().zip(&off).map(|(a, b)| a - b);
    rms(&differences.collect::<Vec<f64>>())
}

/// s by which the error of a joint's speed moves its reversals, σ_q̇ over the RMS acceleration; infinite where nothing tells it.
fn reversal_error(recordings: &[&Prepared], joint: usize) -> f64 {
    let of = |recording: &&Prepared| {
        let experiment = &recording.experiment;
        let error = experiment.motion_error.as_ref();
        let acceleration = rms(&experiment.motion.acceleration[joint]);
        error.map_or(f64::INFINITY, |error| {
            error.velocity.deviation(joint) / acceleration
        })
    };
    recordings.iter().map(of).fold(0.0, f64::max)
}

/// s, a delay that is told from none by the stamps of recordings.
pub fn least_delay(recordings: &[&Prepared]) -> f64 {
    OF_INTERVAL * shortest_interval(recordings)
}

/// s between samples of recordings.
fn shortest_interval(recordings: &[&Prepared]) -> f64 {
    let rates = recordings.iter().map(|r| r.experiment.rate_hz);
    rates.map(f64::recip).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::random::{generator, symmetric};

    #[test]
    fn what_is_left_at_its_noise_has_no_room_for_an_effect_that_matters() {
        let mut rng = generator(5);
        let mut noise = |rows: usize| -> Vec<f64> {
            (0..rows)
                .map(|_| symmetric(&mut rng, 3.0_f64.sqrt()))
                .collect()
        };
        let rows = noise(2000);
        assert!(!may_leave_more(&rows, 1.0));
        assert!(may_leave_more(&rows, 0.9));
        // Few rows refute nothing, and those of no noise show all that they leave.
        assert!(may_leave_more(&rows[..50], 1.0));
        assert!(may_leave_more(&rows, 0.0));
        assert!(!may_leave_more(&[], 1.0));
        // What remembers for long is of few rows.
        let slow: Vec<f64> = noise(20).iter().flat_map(|e| [*e; 100]).collect();
        assert!(may_leave_more(&slow, 1.0));
    }
}
