//! Forecast evidence: how much better a richer model predicts the held-out rows than a poorer one.
//!
//! Models that differ in a few rows alone, at the impacts of a play or while something is touched, differ in so few
//! blocks that these do not tell the variance of what they leave. There the noise that is known from what repeats takes
//! its place, on rows under way: around reversals a few rows are off by more than noise in every model.

use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::estimation_error::FittedInNoise;
use crate::diagnose::fit::model_fit::FitPair;
use crate::diagnose::residuals::noise_level;
use crate::diagnose::residuals::reversal_mask;
use crate::recording::split::Split;
use crate::stats::encompassing::{Encompassing, Known, ResidualPair};

/// Fewer degrees of freedom do not tell a variance: at 3 the upper bound of a standard deviation, at 95 %, is three times
/// its estimate.
const FEW: f64 = 3.0;

/// Whether `richer` forecasts what `poorer` leaves.
pub fn forecast(context: &Context<'_>, pair: FitPair<'_>) -> Encompassing {
    let evidence = KeptRows::all(context, pair).encompassing(None);
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
    KeptRows::under_way(context, pair).encompassing(noise)
}

/// Two models over rows of the held-out recordings.
struct KeptRows<'a> {
    context: &'a Context<'a>,
    pair: FitPair<'a>,
    /// Rows that are looked at, per channel; all where there is no list.
    kept: Vec<Option<Vec<bool>>>,
}

impl<'a> KeptRows<'a> {
    fn all(context: &'a Context<'_>, pair: FitPair<'a>) -> Self {
        Self {
            context,
            pair,
            kept: vec![None; pair.richer.validation.len()],
        }
    }

    fn under_way(context: &'a Context<'_>, pair: FitPair<'a>) -> Self {
        let channels = 0..pair.richer.model.channels().len();
        let kept = channels.map(|channel| reversal_mask::rows(context, pair.richer, channel));
        Self {
            context,
            pair,
            kept: kept.collect(),
        }
    }

    fn of(&self, channel: usize, series: &[f64]) -> Vec<f64> {
        match &self.kept[channel] {
            Some(rows) => reversal_mask::kept(series, rows),
            None => series.to_vec(),
        }
    }

    fn encompassing(&self, noise: Option<&[f64]>) -> Encompassing {
        let of = |residuals: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let channels = residuals.iter().enumerate();
            channels.map(|(c, series)| self.of(c, series)).collect()
        };
        let residuals = ResidualPair {
            poorer: &of(&self.pair.poorer.validation),
            richer: &of(&self.pair.richer.validation),
        };
        let FitPair { poorer, richer } = self.pair;
        let fitted = self.context.recordings(Split::Train);
        FittedInNoise {
            context: self.context,
            poorer,
            noise: &|| {
                let problem = richer.problem(&fitted);
                problem.counted_residuals(&richer.solution.x)
            },
            kept: &self.kept,
        }
        .test(&|estimates| {
            residuals.encompassing(Known { noise, estimates }, self.context.residual_rows())
        })
    }
}
