//! Weak findings: those that explain less of a residual than they leave.
//!
//! A finding takes something of a channel's excess over the noise, L − 1 with the lack of fit L, and what is left no
//! name of the vocabulary explains. Where more is left than the finding takes, it may as well stand for the
//! unexplained physics elsewhere: a torque constant that is off by as much as some other channel leaks into this
//! one on the average. Such a name is withdrawn, and the misfit reported without one.

use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::noise_level::{NoiseLevel, UNEXPLAINED};
use crate::diagnose::selection::rival_models::RivalComparison;

/// A finding explains most of an excess where it explains more than it leaves.
const MOST: f64 = 0.5;

/// The finding that explains the least share of what there would be without it, if that is less than half; only
/// where the noise is measured, and judged in the channel in which it explains most.
pub fn weakest(
    noise_level: &NoiseLevel,
    full: &ModelFit,
    comparisons: &[RivalComparison],
) -> Option<usize> {
    if !noise_level.measured {
        return None;
    }
    let shares = (0..comparisons.len()).filter_map(|k| {
        let channels = full.hypotheses[k].moved_channels(&full.model);
        let pair = FitPair {
            poorer: &comparisons[k].without,
            richer: full,
        };
        let share = share(noise_level, pair, &channels)?;
        (share < MOST).then_some((k, share))
    });
    let least = shares.min_by(|a, b| a.1.total_cmp(&b.1));
    least.map(|(k, _)| k)
}

/// Share of the excess of a model without a finding in some channels that it explains, where what it leaves is unexplained.
fn share(noise_level: &NoiseLevel, pair: FitPair<'_>, channels: &[usize]) -> Option<f64> {
    let lacks = channels.iter().map(|&c| {
        let of = |fit: &ModelFit| noise_level.lack_of_channel(&fit.validation[c], c);
        (of(pair.poorer), of(pair.richer))
    });
    let (before, after) = lacks.max_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)))?;
    (after > UNEXPLAINED).then(|| (before - after) / (before - 1.0))
}
