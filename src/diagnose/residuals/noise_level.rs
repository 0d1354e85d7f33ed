//! The noise level of a channel, with which residuals are compared.

use crate::chain::dataset::Prepared;
use crate::chain::model::Model;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::additive_model::{self, AdditiveModel};
use crate::estimate::goodness_of_fit::noise_rms;
use crate::outcome::joint::JointFigures;
use crate::stats::deviation::{of_steps, rms};
use crate::stats::distribution::Distribution;
use crate::stats::encompassing::{ResidualPair, block_length};

/// Least excess over the noise that shares are taken of.
pub const LEAST_EXCESS: f64 = 0.05;

/// A held-out residual of more than this many times the variance of the noise is not explained: more of it is misfit than
/// noise.
pub const UNEXPLAINED: f64 = 2.0;

/// Mean square of one row that is noise, per channel, and where it comes from.
#[derive(Debug, Clone)]
pub struct NoiseLevel {
    /// Its root per channel, in the unit of the signal.
    pub rms: Vec<f64>,
    /// Evidence between periods; otherwise the least residual of any model.
    pub measured: bool,
}

impl NoiseLevel {
    /// Lack of fit pooled over channels: mean of the squared residual over the squared noise.
    pub fn lack_of_fit(&self, residuals: &[Vec<f64>], channels: &[usize]) -> f64 {
        let (mut sum, mut rows) = (0.0, 0.0);
        for &c in channels.iter().filter(|&&c| !residuals[c].is_empty()) {
            let count = residuals[c].len() as f64;
            sum += count * self.lack_of_channel(&residuals[c], c);
            rows += count;
        }
        if rows > 0.0 { sum / rows } else { 1.0 }
    }

    /// Lack of fit of one channel: mean square of some rows of its residual over the squared noise; 1 of none.
    pub fn lack_of_channel(&self, residual: &[f64], channel: usize) -> f64 {
        match residual {
            [] => 1.0,
            rows => (rms(rows) / self.rms[channel]).powi(2),
        }
    }

    /// Holds the held-out errors of active channels against this noise.
    pub fn judge(&self, model: &Model, joints: &mut [JointFigures]) {
        let channels = model.channels().iter().zip(&self.rms);
        let active = channels.filter(|(channel, _)| channel.active);
        for ((_, noise), joint) in active.zip(joints) {
            let held_out = joint.rmse_validation.unwrap_or(joint.rmse_train);
            joint.noise_rms = Some(*noise);
            joint.lack_of_fit = Some((held_out / noise).powi(2));
        }
    }

    /// Share of the excess over the noise that a second model does not have.
    pub fn share(&self, pair: ResidualPair<'_>, channels: &[usize]) -> f64 {
        let before = self.lack_of_fit(pair.poorer, channels);
        let after = self.lack_of_fit(pair.richer, channels);
        ((before - after) / (before - 1.0).max(LEAST_EXCESS)).clamp(0.0, 1.0)
    }
}

/// Probability that noise alone leaves as much in some rows, where that is beyond [`UNEXPLAINED`].
pub fn chance(residual: &[f64], noise: f64) -> Option<f64> {
    let lack = (rms(residual) / noise).powi(2);
    let effective = residual.len() as f64 / block_length(&[residual.to_vec()]) as f64;
    let spread = Distribution::variance_ratio(effective);
    (lack > UNEXPLAINED).then(|| spread.upper_tail(lack))
}

/// Whether held-out rows are no more than noise by what successive ones differ, in which a misfit that follows the motion has no
/// part, or by noise that is known otherwise. Slow noise is not told from misfit.
pub fn is_noise(residual: &[f64], known: f64) -> bool {
    let attested = of_steps(residual, 1).max(known * known);
    rms(residual).powi(2) <= UNEXPLAINED * attested
}

/// Rows apart at which noise that forgets from row to row differs no more than from one to the next.
const APART: usize = 4;

/// By how much it may: three deviations of the ratio of two such variances of a thousand rows, and what a residual
/// changes within a few rows.
const FORGETS: f64 = 1.25;

/// Deviation of noise that forgets from row to row; `None` where it does not.
fn deviation_of_steps(series: &[f64]) -> Option<f64> {
    let (near, far) = (of_steps(series, 1), of_steps(series, APART));
    (far <= FORGETS * near).then(|| near.sqrt())
}

/// RMS noise of one row per channel where the motion repeats: the scatter of the periods whose averages the rows are,
/// or of successive samples in what a model leaves.
pub fn known(context: &Context<'_>, model: &ModelFit) -> Option<Vec<f64>> {
    let repeats = |r: &Prepared| r.experiment.noise.is_some();
    match context.in_time {
        false => context.noise.clone(),
        true if context.data.recordings.iter().all(repeats) => model
            .validation
            .iter()
            .map(|e| deviation_of_steps(e))
            .collect(),
        true => None,
    }
}

/// The noise of one row: between periods where there are some, of successive rows where rows are in the order of
/// time, else what the best model leaves.
pub fn of_rows(
    context: &Context<'_>,
    full: &ModelFit,
    corrections: &[&AdditiveModel],
) -> NoiseLevel {
    if context.in_time
        && let Some(rms) = known(context, full)
    {
        return NoiseLevel {
            rms,
            measured: true,
        };
    }
    let repeats = |r: &Prepared| r.experiment.noise.is_some();
    let averaged = context.data.recordings.iter().all(repeats);
    match noise_rms(&full.model, &full.values, context.data).filter(|_| averaged) {
        Some(rms) => NoiseLevel {
            rms,
            measured: true,
        },
        // White noise of successive samples says nothing of slower noise.
        None => NoiseLevel {
            rms: additive_model::left(full, corrections)
                .iter()
                .map(|e| rms(e))
                .collect(),
            measured: false,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::random::{generator, symmetric};

    /// A wave of a hundred rows changes little from one to the next.
    #[test]
    fn what_follows_a_motion_is_no_noise_unless_something_knows_it_to_be() {
        let mut rng = generator(3);
        let mut noise = || -> Vec<f64> { (0..2000).map(|_| symmetric(&mut rng, 1.0)).collect() };
        let white = noise();
        let wave = |(k, e): (usize, f64)| e + 2.0 * (0.0628 * k as f64).sin();
        let slow: Vec<f64> = noise().into_iter().enumerate().map(wave).collect();
        assert!(is_noise(&white, 0.0));
        assert!(!is_noise(&slow, 0.0));
        assert!(is_noise(&slow, rms(&slow)));
    }
}
