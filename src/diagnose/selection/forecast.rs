//! The evidence of a richer model against a poorer one on the rows that were held out.
//!
//! Models that differ in a few rows alone, at the impacts of a play or while something is touched, differ in so few
//! blocks that these do not tell the variance of what they leave. There the noise that is known from what repeats takes
//! its place, on rows under way: around reversals a few rows are off by more than noise in every model.

use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::noise_level;
use crate::diagnose::residuals::reversal_mask;
use crate::stats::encompassing::{Encompassing, ResidualPair};

/// Fewer degrees of freedom do not tell a variance: at 3 the upper bound of a standard deviation, at 95 %, is three times
/// its estimate.
const FEW: f64 = 3.0;

/// Whether `richer` forecasts what `poorer` leaves.
pub fn forecast(context: &Context<'_>, pair: FitPair<'_>) -> Encompassing {
    let evidence = pair.held_out().encompassing(None, context.residual_rows());
    if evidence.freedom >= FEW {
        return evidence;
    }
    let Some(noise) = noise_level::known(context, pair.richer) else {
        return evidence;
    };
    under_way(context, pair, Some(&noise))
}

/// The same on rows at which joints are under way.
pub fn under_way(context: &Context<'_>, pair: FitPair<'_>, noise: Option<&[f64]>) -> Encompassing {
    let of = |fit: &ModelFit| -> Vec<Vec<f64>> {
        let channels = fit.validation.iter().enumerate();
        let kept = |(c, residual): (usize, &Vec<f64>)| {
            reversal_mask::residual(context, pair.richer, c, residual)
        };
        channels.map(kept).collect()
    };
    let kept = ResidualPair {
        poorer: &of(pair.poorer),
        richer: &of(pair.richer),
    };
    kept.encompassing(noise, context.residual_rows())
}
