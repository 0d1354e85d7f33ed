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
use crate::diagnose::residuals::smooth_fit::{FoldedChannel, Smoothed};
use crate::estimate::noise::ResidualSeries;
use crate::recording::split::Split;
use crate::stats::deviation::{of_steps, rms};
use crate::stats::encompassing::{Encompassing, Known, ResidualPair};
use rayon::prelude::*;
use std::sync::Arc;

/// A residual of less than so many times the variance of the noise is taken for noise.
const MUCH: f64 = 1.5;

/// Rows along which functions are chosen: a function of two variables has some dozens of factors.
const ENOUGH: usize = 4000;

/// A smooth model of one channel.
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
    /// Share by which the held-out RMS error falls.
    pub error_reduction: f64,
    /// RMS of what it takes from the held-out rows over that of what it leaves.
    pub taken: f64,
    /// To be subtracted from the residual, over the fitted and over the held-out rows.
    pub train: Vec<f64>,
    /// The same over the held-out rows.
    pub validation: Vec<f64>,
    curves: Arc<Smoothed>,
}

impl AdditiveModel {
    /// Whether it says something that is significant and matters, on the rows that chose it among so many channels' models.
    pub fn is_needed(&self, significance: f64, channels: usize) -> bool {
        let tried = (channels * self.tried) as f64;
        self.evidence.p_value * tried < significance
            && self.error_reduction >= MATTERS
            && self.taken >= OF_NOISE
    }

    /// Whether rows that have not chosen it confirm it, as one of so many tests.
    pub fn is_confirmed(&self, significance: f64, tests: usize) -> bool {
        self.evidence.p_value * (tests as f64) < significance && self.error_reduction > 0.0
    }

    /// The same correction over other rows than those by which it was chosen, with the evidence of these.
    pub fn on(&self, context: &Context<'_>, fit: &ModelFit) -> Self {
        let rows = Rows::both(context, fit);
        let place = Place {
            fit,
            channel: self.channel,
            rows: &rows,
        };
        let curves = Arc::clone(&self.curves);
        let model = place.model(curves, self.tried);
        model.map_or_else(|| self.clone(), |model| model.judged(context, fit))
    }

    /// With the evidence of the held-out rows.
    fn judged(mut self, context: &Context<'_>, fit: &ModelFit) -> Self {
        self.evidence = self.forecasts(context, fit);
        self
    }

    /// Whether it forecasts what the model leaves of the held-out rows.
    fn forecasts(&self, context: &Context<'_>, fit: &ModelFit) -> Encompassing {
        let richer = left(fit, &[self]);
        let residuals = ResidualPair {
            poorer: &fit.validation,
            richer: &richer,
        };
        let rows = context.residual_rows();
        let kept = vec![None; richer.len()];
        FittedInNoise {
            context,
            poorer: fit,
            noise: &|| self.left_of_fitted(context, fit),
            kept: &kept,
        }
        .test(&|estimates| {
            let noise = None;
            residuals.encompassing(Known { noise, estimates }, rows)
        })
    }

    /// What it leaves of the fitted rows, `[recording][channel][row]`.
    fn left_of_fitted(&self, context: &Context<'_>, fit: &ModelFit) -> ResidualSeries {
        let recordings = context.recordings(Split::Train);
        let problem = fit.problem(&recordings);
        let mut left = problem.counted_residuals(&fit.solution.x);
        let mut taken = self.train.iter();
        for (recording, residuals) in recordings.iter().zip(&mut left) {
            for (row, by) in recording.counting_for(self.channel).zip(taken.by_ref()) {
                residuals[self.channel][row] -= by;
            }
        }
        left
    }
}

/// A model along rows, with its derivatives.
struct Rows<'a> {
    recordings: Vec<&'a Prepared>,
    series: ChannelSeries,
}

impl<'a> Rows<'a> {
    /// Those that were fitted, and those that are held out.
    fn both(context: &'a Context<'_>, fit: &ModelFit) -> [Self; 2] {
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
}

/// A channel of a model.
struct Place<'a> {
    fit: &'a ModelFit,
    channel: usize,
    rows: &'a [Rows<'a>; 2],
}

impl Place<'_> {
    /// Smooth functions along the rows, not judged yet; `None` where the channel is that of no joint.
    fn model(&self, curves: Arc<Smoothed>, tried: usize) -> Option<AdditiveModel> {
        let channel = self.channel;
        let [fitted, held_out] = self.rows;
        let covariates = [
            fitted.covariates(self.fit, channel)?,
            held_out.covariates(self.fit, channel)?,
        ];
        let of = |k: usize| curves.at(&covariates[k], &self.rows[k].series.columns[channel]);
        let (train, validation) = (of(0), of(1));
        let before = &self.fit.validation[channel];
        let after: Vec<f64> = before.iter().zip(&validation).map(|(e, f)| e - f).collect();
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
            error_reduction: 1.0 - rms(&after) / rms(before),
            taken: taken(before, &after),
            train,
            validation,
            curves,
        })
    }
}

/// Held-out residuals of a model with smooth corrections.
pub fn left(fit: &ModelFit, corrections: &[&AdditiveModel]) -> Vec<Vec<f64>> {
    let mut left = fit.validation.clone();
    for correction in corrections {
        let pairs = left[correction.channel]
            .iter_mut()
            .zip(&correction.validation);
        pairs.for_each(|(e, f)| *e -= f);
    }
    left
}

/// The same, with what the changed unknowns add in the other channels.
pub fn left_everywhere(
    context: &Context<'_>,
    fit: &ModelFit,
    corrections: &[&AdditiveModel],
) -> Vec<Vec<f64>> {
    let rows = Rows::of(context, fit, Split::Validation);
    let mut left = left(fit, corrections);
    for correction in corrections {
        let others = left.iter_mut().enumerate();
        for (c, residual) in others.filter(|(c, _)| *c != correction.channel) {
            let curves = &correction.curves;
            let shift = curves.shift(&rows.series.columns[c], residual.len());
            residual.iter_mut().zip(shift).for_each(|(e, by)| *e += by);
        }
    }
    left
}

/// RMS of what a correction takes over that of what it leaves.
fn taken(before: &[f64], after: &[f64]) -> f64 {
    let squares = rms(before).powi(2) - rms(after).powi(2);
    squares.max(0.0).sqrt() / rms(after)
}

/// Smooth models of what a fit leaves where that is much, at most one per channel of a joint.
pub fn of_all(context: &Context<'_>, fit: &ModelFit) -> Vec<AdditiveModel> {
    let all: Vec<usize> = (0..fit.model.channels().len()).collect();
    of_some(context, fit, &all)
}

/// The same of some channels.
pub fn of_some(context: &Context<'_>, fit: &ModelFit, channels: &[usize]) -> Vec<AdditiveModel> {
    let is_active = |c: &usize| fit.model.channels()[*c].active;
    let active = channels.iter().copied().filter(is_active);
    let much = active.filter(|&c| leaves_much(context, fit, c));
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
    let model = &fit.model;
    let is_of_joint = |of: &&Sought<'_>| model.channels()[of.channel].joint.is_some();
    let open: Vec<&Sought<'_>> = channels.iter().filter(is_of_joint).collect();
    if open.is_empty() {
        return Vec::new();
    }
    let train = context.recordings(Split::Train);
    let rows: usize = train.iter().map(|r| r.counting().count()).sum();
    let every = (rows / ENOUGH).max(1);
    let thinned = train.iter().map(|r| r.thinned(every));
    let thinned: Vec<Prepared> = thinned.collect();
    let thinned: Vec<&Prepared> = thinned.iter().collect();
    let linear = LinearModel::of(fit, every, &thinned);
    let Some(folded) = FoldedModel::of(&linear) else {
        return Vec::new();
    };
    let all_rows = Rows::both(context, fit);
    let of_channel = |of: &&Sought<'_>| {
        let covariates = Covariates::of(model, of.channel, &linear.loads, &thinned)?;
        let folded = FoldedChannel {
            channel: of.channel,
            covariates: &covariates,
            model: &folded,
        };
        let place = Place {
            fit,
            channel: of.channel,
            rows: &all_rows,
        };
        let mut all = folded.smoothed(&candidates(&covariates));
        if let Some(like) = of.like {
            all.extend(folded.smoothed(&like.curves.arguments()));
        }
        let tried = all.len();
        let all = all.into_iter();
        let all = all.filter_map(|curves| place.model(Arc::new(curves), tried));
        let best = all.max_by(|a, b| a.error_reduction.total_cmp(&b.error_reduction))?;
        Some(best.judged(context, fit))
    };
    open.par_iter().filter_map(of_channel).collect()
}

/// Whether a model leaves more than noise of a channel: what repeats tells it, or what successive rows differ by.
fn leaves_much(context: &Context<'_>, fit: &ModelFit, channel: usize) -> bool {
    let residual = &fit.validation[channel];
    let noise = match &context.noise {
        Some(noise) => noise[channel].powi(2),
        None => of_steps(residual, 1),
    };
    rms(residual).powi(2) > MUCH * noise
}

/// Functions of one variable, and of two states of which one is the joint's own or both are of one other.
fn candidates(covariates: &Covariates) -> Vec<Arguments> {
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
