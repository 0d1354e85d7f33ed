//! Forecast evidence: how much better a richer model predicts the held-out rows than a poorer one.
//!
//! Models that differ in a few rows alone, at the impacts of a play or while something is touched, differ in so few
//! blocks that these do not tell the variance of what they leave. There the noise that is known from what repeats takes
//! its place, on rows under way: around reversals a few rows are off by more than noise in every model. Where these outweigh what
//! two models differ by, the others are compared alone.

use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::estimation_error::FittedInNoise;
use crate::diagnose::fit::hypothesis::channels_of;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::noise_level::{self, NoiseLevel};
use crate::diagnose::residuals::reversal_mask;
use crate::recording::split::Split;
use crate::stats::encompassing::{Encompassing, Known, ResidualPair};
use std::borrow::Cow;

/// Fewer degrees of freedom do not tell a variance: at 3 the upper bound of a standard deviation, at 95 %, is three times
/// its estimate.
const FEW: f64 = 3.0;

/// A model leaves clearly more than another where it leaves at least half as much again above the noise: what neither explains tilts
/// the comparison of the two as much as their physics.
pub const IN_DOUBT: f64 = 0.5;

/// Held-out rows on which two models are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ComparedRows {
    /// All.
    All,
    /// Those at which joints are under way.
    UnderWay,
}

impl ComparedRows {
    /// The rows on which the difference of two models in the channels of some joints is not small beside what neither explains: all,
    /// where they tell the two, or those under way; all where the noise is not measured, and none where neither tells them.
    pub fn clear(
        context: &Context<'_>,
        noise_level: &NoiseLevel,
        pair: FitPair<'_>,
        joints: &[usize],
    ) -> Option<Self> {
        if !noise_level.measured {
            return Some(Self::All);
        }
        let channels = channels_of(&pair.richer.model, joints);
        let is_clear = |rows: &Self| rows.of(context, pair).leaves_more(noise_level, &channels);
        [Self::All, Self::UnderWay].into_iter().find(is_clear)
    }

    /// Whether `richer` forecasts on these rows what `poorer` leaves.
    pub fn forecast(self, context: &Context<'_>, pair: FitPair<'_>) -> Encompassing {
        let evidence = self.of(context, pair).encompassing(None);
        if evidence.freedom >= FEW {
            return evidence;
        }
        let Some(noise) = noise_level::known(context, pair.richer) else {
            return evidence;
        };
        under_way(context, pair, Some(&noise))
    }

    fn of<'a>(self, context: &'a Context<'_>, pair: FitPair<'a>) -> KeptRows<'a> {
        match self {
            Self::All => KeptRows::all(context, pair),
            Self::UnderWay => KeptRows::under_way(context, pair),
        }
    }
}

/// Whether `richer` forecasts what `poorer` leaves.
pub fn forecast(context: &Context<'_>, pair: FitPair<'_>) -> Encompassing {
    ComparedRows::All.forecast(context, pair)
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

    fn of<'s>(&self, channel: usize, series: &'s [f64]) -> Cow<'s, [f64]> {
        match &self.kept[channel] {
            Some(rows) => Cow::Owned(reversal_mask::kept(series, rows)),
            None => Cow::Borrowed(series),
        }
    }

    /// Whether the poorer model leaves more above the noise than the richer one in one of some channels, by half of that at least.
    fn leaves_more(&self, noise_level: &NoiseLevel, channels: &[usize]) -> bool {
        let FitPair { poorer, richer } = self.pair;
        channels.iter().any(|&c| {
            let lack =
                |fit: &ModelFit| noise_level.lack_of_channel(&self.of(c, &fit.validation[c]), c);
            let least = lack(richer);
            lack(poorer) - least > IN_DOUBT * (least - 1.0).max(0.0)
        })
    }

    fn encompassing(&self, noise: Option<&[f64]>) -> Encompassing {
        let of = |residuals: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let channels = residuals.iter().enumerate();
            let kept = channels.map(|(c, series)| self.of(c, series).into_owned());
            kept.collect()
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
