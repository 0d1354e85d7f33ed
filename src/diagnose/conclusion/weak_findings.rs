//! Weak findings: those that explain less of a residual than they leave.
//!
//! A finding takes something of a channel's excess over the noise, L − 1 with the lack of fit L, and what is left no
//! name of the vocabulary explains. Where more is left than the finding takes, it may as well stand for the
//! unexplained physics elsewhere: a torque constant that is off by as much as some other channel leaks into this
//! one on the average. Such a name is withdrawn, and the misfit reported without one. At a reversal dry friction turns over between
//! two rows, and what the model leaves there says little of other physics: a name that explains more than it leaves while its joint is
//! under way is kept.

use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::noise_level::{NoiseLevel, UNEXPLAINED};
use crate::diagnose::residuals::reversal_mask;
use crate::diagnose::selection::rival_models::RivalComparison;

/// A finding explains most of an excess where it explains more than it leaves.
const MOST: f64 = 0.5;

/// The finding that explains the least share of what there would be without it, if that is less than half of all rows and of those
/// under way; only where the noise is measured, and judged in the channel in which it explains most.
pub fn weakest(
    context: &Context<'_>,
    noise_level: &NoiseLevel,
    full: &ModelFit,
    comparisons: &[RivalComparison],
) -> Option<usize> {
    if !noise_level.measured {
        return None;
    }
    let all = |fit: &ModelFit, c: usize| noise_level.lack_of_channel(&fit.validation[c], c);
    let under_way = |fit: &ModelFit, c: usize| {
        let rows = reversal_mask::residual(context, full, c, &fit.validation[c]);
        noise_level.lack_of_channel(&rows, c)
    };
    let shares = (0..comparisons.len()).filter_map(|k| {
        let channels = full.hypotheses[k].moved_channels(&full.model);
        let pair = FitPair {
            poorer: &comparisons[k].without,
            richer: full,
        };
        let of_all = weak_share(pair, &channels, &all)?;
        let of_moving = weak_share(pair, &channels, &under_way)?;
        Some((k, of_all.max(of_moving)))
    });
    let least = shares.min_by(|a, b| a.1.total_cmp(&b.1));
    least.map(|(k, _)| k)
}

/// Share of the excess of a model without a finding that it explains of the channel in which it explains most; `None` where that is half
/// of it, or what is left there may be noise.
fn weak_share(
    pair: FitPair<'_>,
    channels: &[usize],
    lack: &dyn Fn(&ModelFit, usize) -> f64,
) -> Option<f64> {
    let both = |&c: &usize| (lack(pair.poorer, c), lack(pair.richer, c));
    let lacks = channels.iter().map(both);
    let (before, after) = lacks.max_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)))?;
    let share = (before - after) / (before - 1.0);
    (after > UNEXPLAINED && share < MOST).then_some(share)
}
