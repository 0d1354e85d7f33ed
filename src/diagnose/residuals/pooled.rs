//! Smooth models of several channels, fitted to the rows of a model and to others together.

use crate::chain::dataset::Prepared;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::additive_model::{
    AdditiveModel, LinearisedRows, Place, Rows, candidates, leaves_much, left,
};
use crate::diagnose::residuals::folds::FoldedModel;
use crate::diagnose::residuals::smooth_fit::{Chosen, Smoothed};
use crate::recording::split::Split;
use nalgebra::DVector;
use rayon::prelude::*;
use std::sync::Arc;

/// Smooth models that were fitted to the rows of a model and to held-out rows, one channel after the other, each beside those before
/// it: these rows say nothing for or against them.
pub struct Pooled {
    /// What the parameters of the model change where it is fitted to these rows: a correction without functions.
    pub refit: Option<AdditiveModel>,
    /// Beside it.
    pub corrections: Vec<AdditiveModel>,
}

impl Pooled {
    /// Of channels of which a fit leaves much, the one in which most is forecast first.
    pub fn of_much(context: &Context<'_>, fit: &ModelFit, held_out: &[Prepared]) -> Self {
        let channels = fit.model.channels().iter().enumerate();
        let active = channels.filter(|(_, channel)| channel.active);
        let mut rows = PooledRows::of(context, fit, held_out);
        let mut open: Vec<usize> = active.map(|(c, _)| c).collect();
        let mut pooled = rows.refitted();
        loop {
            let left = left(fit, &pooled.all());
            open.retain(|&c| leaves_much(context, &left, c));
            let Some(next) = rows.foremost(&open) else {
                return pooled;
            };
            open.retain(|c| *c != next.channel);
            pooled.corrections.push(next);
        }
    }

    /// Of channels in their order.
    pub fn of_channels(
        context: &Context<'_>,
        fit: &ModelFit,
        held_out: &[Prepared],
        channels: &[usize],
    ) -> Self {
        let mut rows = PooledRows::of(context, fit, held_out);
        let refitted = rows.refitted();
        let each = channels.iter().filter_map(|c| rows.foremost(&[*c]));
        Self {
            corrections: each.collect(),
            ..refitted
        }
    }

    /// The refit and the corrections.
    pub fn all(&self) -> Vec<&AdditiveModel> {
        self.refit.iter().chain(&self.corrections).collect()
    }
}

/// Fitted and held-out rows, less what corrections have taken of them.
struct PooledRows<'a> {
    fit: &'a ModelFit,
    linearised: LinearisedRows,
    rows: [Rows<'a>; 2],
    /// Of each channel, when it was last looked at; infinite before.
    gains: Vec<f64>,
}

impl<'a> PooledRows<'a> {
    fn of(context: &'a Context<'_>, fit: &'a ModelFit, held_out: &[Prepared]) -> Self {
        let mut recordings = context.recordings(Split::Train);
        // Values of the parameters of a held-out recording are not those that derivatives are taken at.
        if fit.own.is_empty() {
            recordings.extend(held_out);
        }
        Self {
            linearised: LinearisedRows::of(fit, &recordings),
            rows: Rows::both(context, fit),
            gains: vec![f64::INFINITY; fit.validation.len()],
            fit,
        }
    }

    /// Without corrections yet.
    fn refitted(&self) -> Pooled {
        let curves = Smoothed {
            functions: Vec::new(),
            factors: DVector::zeros(0),
            step: self.linearised.linear.step.clone(),
        };
        let channels = self.fit.model.channels().iter();
        let place = Place {
            fit: self.fit,
            // Without functions it is of no channel more than of another.
            channel: channels.take_while(|c| c.joint.is_none()).count(),
            rows: &self.rows,
        };
        Pooled {
            refit: place.model(Arc::new(curves), 1),
            corrections: Vec::new(),
        }
    }

    /// The model of the channel in which one forecasts most, and takes what it takes.
    fn foremost(&mut self, channels: &[usize]) -> Option<AdditiveModel> {
        let (channel, Chosen { both, .. }) = self.most_gain(channels)?;
        let [curves, _] = both;
        let (fit, linearised) = (self.fit, &mut self.linearised);
        let covariates = linearised.covariates(fit, channel)?;
        linearised
            .linear
            .take(channel, &curves.at(&covariates, &[]), &curves.step);
        let place = Place {
            fit,
            channel,
            rows: &self.rows,
        };
        place.model(Arc::new(curves), 1)
    }

    /// Functions of the channel in which they forecast most. What others have taken lowers a gain: a channel is looked at anew if
    /// it was the foremost before.
    fn most_gain(&mut self, channels: &[usize]) -> Option<(usize, Chosen)> {
        let (fit, linearised) = (self.fit, &self.linearised);
        let folded = FoldedModel::of(&linearised.linear)?;
        let mut at_present: Vec<(usize, Chosen)> = Vec::new();
        loop {
            let gain = |c: &usize| self.gains[*c];
            let greatest = channels.iter().map(gain).fold(f64::NEG_INFINITY, f64::max);
            let is_greatest = |c: &usize| gain(c) == greatest;
            let foremost: Vec<usize> = channels.iter().copied().filter(is_greatest).collect();
            let is_at_present = |of: &(usize, Chosen)| foremost.contains(&of.0);
            if let Some(k) = at_present.iter().position(is_at_present) {
                return Some(at_present.swap_remove(k));
            }
            if greatest == f64::NEG_INFINITY {
                return None;
            }
            let of_channel = |&channel: &usize| {
                let all = linearised.smoothed(fit, &folded, channel, &candidates);
                (channel, all.and_then(|all| all.into_iter().last()))
            };
            let each: Vec<(usize, Option<Chosen>)> = foremost.par_iter().map(of_channel).collect();
            for (channel, chosen) in each {
                let gain = chosen.as_ref().map(|chosen| chosen.gain);
                self.gains[channel] = gain.unwrap_or(f64::NEG_INFINITY);
                at_present.extend(chosen.map(|chosen| (channel, chosen)));
            }
        }
    }
}
