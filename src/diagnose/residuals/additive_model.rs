//! A smooth model of what no effect of the vocabulary explains: a sum of piecewise linear functions of one variable, of the
//! joint's own motion and load or of another's, and of bilinear ones of two together, beside all parameters of the model.
//!
//! ```text
//! e ≈ Σ f_k(x) + g_k(x) d + Σ h_k(x, y) − J δ,    d = sign(v)
//! ```
//!
//! A generalised additive model with interactions (Hastie and Tibshirani 1986).

use crate::chain::dataset::Prepared;
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::estimation_error::FittedInNoise;
use crate::diagnose::fit::linear_model::LinearModel;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::covariates::Covariates;
use crate::diagnose::residuals::effect_size::{MATTERS, OF_NOISE};
use crate::diagnose::residuals::folds::FoldedModel;
use crate::diagnose::residuals::hats::Arguments;
use crate::diagnose::residuals::quantity::Quantity;
use crate::diagnose::residuals::smooth_fit::{Chosen, FoldedChannel, Smoothed};
use crate::estimate::noise::ResidualSeries;
use crate::recording::split::Split;
use crate::stats::autoregression::{Autoregression, OrderCriterion, largest_order};
use crate::stats::deviation::{of_steps, rms};
use crate::stats::encompassing::{Encompassing, Known, ResidualPair};
use nalgebra::DVector;
use rayon::prelude::*;
use std::sync::Arc;

/// A residual of less than so many times the variance of the noise is taken for noise.
const MUCH: f64 = 1.5;

/// Noise of which a row tells less than this share is forgotten there.
const FORGOTTEN: f64 = 0.01;

/// Rows along which functions are chosen: a function of two variables has some dozens of factors.
const ENOUGH: usize = 4000;

/// A smooth model of one channel, with what the model's unknowns change beside it in all channels.
#[derive(Debug, Clone)]
pub struct AdditiveModel {
    /// Its place among the channels.
    pub channel: usize,
    /// Names of its variables.
    pub over: Vec<String>,
    /// The variables of the motion that each of its functions is made of, the foremost function first.
    pub made_of: Vec<Vec<Quantity>>,
    /// Whether its foremost function is of the joint itself alone.
    pub is_own: bool,
    /// Models of the channel that it was chosen from by the held-out rows.
    pub tried: usize,
    /// Whether it forecasts the residual on held-out rows.
    pub evidence: Encompassing,
    /// Share by which the held-out RMS error of its channel falls.
    pub error_reduction: f64,
    /// RMS of what it takes from the held-out rows of its channel over that of what it leaves.
    pub taken: f64,
    /// To be subtracted from the residual over the fitted rows, `[channel][row]`.
    pub train: Vec<Vec<f64>>,
    /// The same over the held-out rows.
    pub validation: Vec<Vec<f64>>,
    curves: Arc<Smoothed>,
}

impl AdditiveModel {
    /// What it changes of the model's unknowns.
    pub fn step(&self) -> &DVector<f64> {
        &self.curves.step
    }

    /// Whether each of its functions is of the motion, and none of time.
    pub fn is_of_motion(&self) -> bool {
        self.made_of.iter().all(|of| !of.is_empty())
    }

    /// Takes it off the series of the recordings of a split, `[channel][row]` each, at the rows that count.
    pub fn take_off<'s>(
        &self,
        split: Split,
        series: impl Iterator<Item = (&'s Prepared, &'s mut Vec<Vec<f64>>)>,
    ) {
        let own = match split {
            Split::Train => &self.train,
            Split::Validation => &self.validation,
        };
        let mut own: Vec<_> = own.iter().map(|channel| channel.iter()).collect();
        for (recording, channels) in series {
            for (c, (channel, own)) in channels.iter_mut().zip(&mut own).enumerate() {
                for (row, by) in recording.counting_for(c).zip(own) {
                    channel[row] -= by;
                }
            }
        }
    }

    /// Whether it says something that is significant and matters, as one of so many channels' models.
    pub fn is_needed(&self, significance: f64, channels: usize) -> bool {
        let tried = (channels * self.tried) as f64;
        self.evidence.p_value * tried < significance
            && self.error_reduction >= MATTERS
            && self.taken >= OF_NOISE
    }

    /// The same correction over other rows, with the evidence of these beside other corrections.
    pub fn on(&self, context: &Context<'_>, fit: &ModelFit, beside: &[&Self]) -> Self {
        let rows = Rows::both(context, fit);
        let place = Place {
            fit,
            channel: self.channel,
            rows: &rows,
        };
        let curves = Arc::clone(&self.curves);
        let model = place.model(curves, self.tried);
        model.map_or_else(|| self.clone(), |model| model.judged(context, fit, beside))
    }

    /// The same with what another one takes of some held-out rows, or with nothing there; `is_other` says of which,
    /// `[channel][row]`.
    pub fn with_rows_of(mut self, other: Option<&Self>, is_other: &[Vec<bool>]) -> Self {
        for (c, (taken, is_other)) in self.validation.iter_mut().zip(is_other).enumerate() {
            for (row, taken) in taken
                .iter_mut()
                .enumerate()
                .filter(|(row, _)| is_other[*row])
            {
                *taken = other.map_or(0.0, |other| other.validation[c][row]);
            }
        }
        self
    }

    /// With the evidence of the held-out rows, beside other corrections.
    fn judged(mut self, context: &Context<'_>, fit: &ModelFit, beside: &[&Self]) -> Self {
        let poorer = left(fit, beside);
        let richer = left(fit, &[beside, &[&self]].concat());
        let (before, after) = (&poorer[self.channel], &richer[self.channel]);
        self.error_reduction = 1.0 - rms(after) / rms(before);
        self.taken = taken(before, after);
        self.evidence = self.forecasts(
            context,
            fit,
            beside,
            ResidualPair {
                poorer: &poorer,
                richer: &richer,
            },
        );
        self
    }

    /// Whether it forecasts what the model leaves of the held-out rows of its channel.
    fn forecasts(
        &self,
        context: &Context<'_>,
        fit: &ModelFit,
        beside: &[&Self],
        held_out: ResidualPair<'_>,
    ) -> Encompassing {
        // What it changes in other channels is none of its evidence.
        let mut richer = held_out.poorer.to_vec();
        richer[self.channel].clone_from(&held_out.richer[self.channel]);
        let residuals = ResidualPair {
            richer: &richer,
            ..held_out
        };
        let rows = context.residual_rows();
        let kept = vec![None; richer.len()];
        FittedInNoise {
            context,
            poorer: fit,
            noise: &|| left_of_fitted(context, fit, &[beside, &[self]].concat()),
            kept: &kept,
        }
        .test(&|estimates| {
            let noise = None;
            residuals.encompassing(Known { noise, estimates }, rows)
        })
    }
}

/// What a model with smooth corrections leaves of the fitted rows, `[recording][channel][row]`.
fn left_of_fitted(
    context: &Context<'_>,
    fit: &ModelFit,
    corrections: &[&AdditiveModel],
) -> ResidualSeries {
    let recordings = context.recordings(Split::Train);
    let problem = fit.problem(&recordings);
    let mut left = problem.counted_residuals(&fit.solution.x);
    for correction in corrections {
        let series = recordings.iter().copied().zip(&mut left);
        correction.take_off(Split::Train, series);
    }
    left
}

/// A model along rows, with its derivatives.
pub(super) struct Rows<'a> {
    recordings: Vec<&'a Prepared>,
    series: ChannelSeries,
}

impl<'a> Rows<'a> {
    /// Those that were fitted, and those that are held out.
    pub(super) fn both(context: &'a Context<'_>, fit: &ModelFit) -> [Self; 2] {
        [Split::Train, Split::Validation].map(|split| Self::of(context, fit, split))
    }

    fn of(context: &'a Context<'_>, fit: &ModelFit, split: Split) -> Self {
        let recordings = context.recordings(split);
        let unknowns = fit.unknowns.positions();
        let series = ChannelSeries::of(&fit.model, &fit.values, &unknowns, &recordings);
        Self { recordings, series }
    }

    fn covariates(&self, fit: &ModelFit, channel: usize) -> Option<Covariates> {
        Covariates::of(&fit.model, channel, &self.series.loads, &self.recordings)
    }

    /// What smooth functions of one channel take of the residual of each.
    fn taken(&self, curves: &Smoothed, covariates: &Covariates, channel: usize) -> Vec<Vec<f64>> {
        let of = |c: usize| {
            let columns = &self.series.columns[c];
            if c == channel {
                return curves.at(covariates, columns);
            }
            let shift = curves.shift(columns, self.series.predicted[c].len());
            shift.iter().map(|x| -x).collect()
        };
        (0..self.series.columns.len()).map(of).collect()
    }
}

/// A channel of a model.
pub(super) struct Place<'a> {
    pub(super) fit: &'a ModelFit,
    pub(super) channel: usize,
    pub(super) rows: &'a [Rows<'a>; 2],
}

impl Place<'_> {
    /// Smooth functions along the rows, not judged yet; `None` where the channel is that of no joint.
    pub(super) fn model(&self, curves: Arc<Smoothed>, tried: usize) -> Option<AdditiveModel> {
        let channel = self.channel;
        let [fitted, held_out] = self.rows;
        let covariates = [
            fitted.covariates(self.fit, channel)?,
            held_out.covariates(self.fit, channel)?,
        ];
        let of = |k: usize| self.rows[k].taken(&curves, &covariates[k], channel);
        let functions = || curves.functions.iter();
        Some(AdditiveModel {
            channel,
            over: functions().map(|hats| hats.name(&covariates[0])).collect(),
            made_of: functions()
                .map(|hats| hats.made_of(&covariates[0]))
                .collect(),
            is_own: functions()
                .next()
                .is_some_and(|hats| hats.is_own(&covariates[0])),
            tried,
            evidence: Encompassing::of_nothing(),
            error_reduction: 0.0,
            taken: 0.0,
            train: of(0),
            validation: of(1),
            curves,
        })
    }
}

/// Held-out residuals of a model with smooth corrections.
pub fn left(fit: &ModelFit, corrections: &[&AdditiveModel]) -> Vec<Vec<f64>> {
    let mut left = fit.validation.clone();
    for correction in corrections {
        for (left, taken) in left.iter_mut().zip(&correction.validation) {
            left.iter_mut().zip(taken).for_each(|(e, f)| *e -= f);
        }
    }
    left
}

/// Rows after which noise is forgotten in some channels: as the scatter of periods tells it, or what a model with corrections leaves of
/// the fitted rows.
pub fn memory(
    context: &Context<'_>,
    fit: &ModelFit,
    corrections: &[&AdditiveModel],
    channels: &[usize],
) -> usize {
    let recordings = context.recordings(Split::Train);
    let left = left_of_fitted(context, fit, corrections);
    let of_recording = |c: usize, recording: &Prepared, left: &[f64]| {
        let known = recording.experiment.noise.as_ref();
        let known = known.and_then(|noise| noise.autocovariance.get(c));
        let model = match known {
            Some(known) => Autoregression::of_autocovariance(known, recording.rows()),
            None => {
                let most = largest_order(left.len());
                Autoregression::fit(&[left], most, OrderCriterion::Bic)
            }
        };
        model.map_or(0, |model| model.memory(FORGOTTEN))
    };
    let of_channel = |&c: &usize| {
        let each = recordings.iter().zip(&left);
        each.map(|(recording, left)| of_recording(c, recording, &left[c]))
            .max()
    };
    channels.iter().filter_map(of_channel).max().unwrap_or(0)
}

/// RMS of what a correction takes over that of what it leaves.
fn taken(before: &[f64], after: &[f64]) -> f64 {
    let squares = rms(before).powi(2) - rms(after).powi(2);
    squares.max(0.0).sqrt() / rms(after)
}

/// Smooth models of what a fit leaves of some channels where that is much, chosen among few by the held-out rows.
pub fn of_some(context: &Context<'_>, fit: &ModelFit, channels: &[usize]) -> Vec<AdditiveModel> {
    let is_active = |c: &usize| fit.model.channels()[*c].active;
    let active = channels.iter().copied().filter(is_active);
    let much = active.filter(|&c| leaves_much(context, &fit.validation, c));
    let any = much.map(|channel| Sought {
        channel,
        like: None,
    });
    sought(context, fit, &any.collect::<Vec<_>>())
}

/// Smooth models of what another fit leaves of the channels of some, of their functions or of others.
pub fn in_place(
    context: &Context<'_>,
    fit: &ModelFit,
    of: &[&AdditiveModel],
) -> Vec<AdditiveModel> {
    let like = of.iter().map(|known| Sought {
        channel: known.channel,
        like: Some(known),
    });
    sought(context, fit, &like.collect::<Vec<_>>())
}

/// A channel of which a smooth model is sought.
struct Sought<'a> {
    channel: usize,
    /// A model with functions that are tried by themselves too.
    like: Option<&'a AdditiveModel>,
}

fn sought(context: &Context<'_>, fit: &ModelFit, channels: &[Sought<'_>]) -> Vec<AdditiveModel> {
    if channels.is_empty() {
        return Vec::new();
    }
    let linearised = LinearisedRows::of(fit, &context.recordings(Split::Train));
    let Some(folded) = FoldedModel::of(&linearised.linear) else {
        return Vec::new();
    };
    let rows = Rows::both(context, fit);
    let of_channel = |of: &Sought<'_>| {
        let mut all = linearised.smoothed(fit, &folded, of.channel, &candidates)?;
        if let Some(like) = of.like {
            let again = |_: &Covariates| like.curves.arguments();
            all.extend(linearised.smoothed(fit, &folded, of.channel, &again)?);
        }
        let place = Place {
            fit,
            channel: of.channel,
            rows: &rows,
        };
        let tried = 2 * all.len();
        // A model that was stepped is not where it leaves least.
        let to_optimum = |mut beside_all: Smoothed| {
            beside_all.step += &linearised.linear.step;
            beside_all
        };
        let all = all.into_iter().flat_map(|chosen| {
            let [beside_all, as_it_is] = chosen.both;
            [to_optimum(beside_all), as_it_is]
        });
        let all = all.filter_map(|curves| place.model(Arc::new(curves), tried));
        let error = |model: &AdditiveModel| rms(&left(fit, &[model])[of.channel]);
        let best = all.min_by(|a, b| error(a).total_cmp(&error(b)))?;
        Some(best.judged(context, fit, &[]))
    };
    channels.par_iter().filter_map(of_channel).collect()
}

/// A fitted model linearised along some rows of recordings.
pub(super) struct LinearisedRows {
    pub(super) linear: LinearModel,
    recordings: Vec<Prepared>,
}

impl LinearisedRows {
    pub(super) fn of(fit: &ModelFit, recordings: &[&Prepared]) -> Self {
        let (linear, recordings) = LinearModel::along_few(fit, recordings, ENOUGH);
        Self { linear, recordings }
    }

    pub(super) fn covariates(&self, fit: &ModelFit, channel: usize) -> Option<Covariates> {
        let recordings: Vec<&Prepared> = self.recordings.iter().collect();
        Covariates::of(&fit.model, channel, &self.linear.loads, &recordings)
    }

    /// Smooth functions that forecast what is left of a channel, one more each time; `None` where the channel is that of no joint.
    pub(super) fn smoothed(
        &self,
        fit: &ModelFit,
        model: &FoldedModel<'_>,
        channel: usize,
        candidates: &dyn Fn(&Covariates) -> Vec<Arguments>,
    ) -> Option<Vec<Chosen>> {
        let covariates = self.covariates(fit, channel)?;
        let folded = FoldedChannel {
            channel,
            covariates: &covariates,
            model,
        };
        Some(folded.smoothed(&candidates(&covariates)))
    }
}

/// Whether a model leaves more than noise of a channel: what repeats tells it, or what successive rows differ by.
pub fn leaves_much(context: &Context<'_>, left: &[Vec<f64>], channel: usize) -> bool {
    let residual = &left[channel];
    let noise = match &context.noise {
        Some(noise) => noise[channel].powi(2),
        None => of_steps(residual, 1),
    };
    rms(residual).powi(2) > MUCH * noise
}

/// Functions of one variable, and of two states of which one is the joint's own or both are of one other.
pub(super) fn candidates(covariates: &Covariates) -> Vec<Arguments> {
    let variables = &covariates.variables;
    let ones = (0..variables.len()).map(Arguments::One);
    let states: Vec<usize> = (0..variables.len())
        .filter(|&k| variables[k].is_state)
        .collect();
    let other = |k: usize| variables[k].other;
    let are_near = |[a, b]: &[usize; 2]| {
        a < b && (other(*a).is_none() || other(*b).is_none() || other(*a) == other(*b))
    };
    let pairs = states
        .iter()
        .flat_map(|&a| states.iter().map(move |&b| [a, b]));
    let twos = pairs.filter(are_near).map(Arguments::Two);
    ones.chain(twos).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// √(before² − after²)/after.
    #[test]
    fn what_is_taken_is_the_root_of_the_difference_of_squares() {
        assert!((taken(&[5.0, -5.0], &[3.0, 3.0]) - 4.0 / 3.0).abs() < 1e-15);
        assert_eq!(taken(&[1.0], &[2.0]), 0.0);
    }
}
