//! Additive models as corrections of what no effect explains, fitted and tested on different rows.
//!
//! One motion tells little of how a law and the parameters that it has bent share what they have in common, and the recordings that
//! are held out are of other motions. A correction is therefore fitted to the fitted rows and to the half of the held-out rows by which
//! models were chosen, and the other half tests it. Of the first half the figures are those of a correction that was fitted to the
//! other one (cross-fitting: Stone 1974), so that no row is forecast by what was fitted to it.

use crate::diagnose::findings::unexplained::SearchState;
use crate::diagnose::findings::{probability, sentences};
use crate::diagnose::fit::contexts::Contexts;
use crate::diagnose::fit::held_out::apart;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::additive_model::{self, AdditiveModel};
use crate::diagnose::residuals::noise_level::NoiseLevel;
use crate::diagnose::residuals::pooled::Pooled;
use crate::diagnose::selection::stepwise::Rules;
use crate::outcome::finding::{Finding, UNNAMED};
use crate::recording::split::Split;
use crate::stats::deviation::rms;
use crate::stats::encompassing::ResidualPair;

/// A correction that was fitted beside the rows that choose, over those that test, and one that was fitted beside these.
struct Exchanged {
    tested: AdditiveModel,
    /// If there is one.
    other: Option<AdditiveModel>,
}

/// Smooth corrections that the rows confirm which no choice has seen.
pub struct Corrections {
    /// What the parameters change where they are fitted to the same rows as the corrections.
    refit: Option<Exchanged>,
    confirmed: Vec<Exchanged>,
    /// Number of those that were tested.
    tested: usize,
    /// Rows after which noise is forgotten.
    memory: usize,
    /// The final model over the rows that test.
    pub full: ModelFit,
}

impl Corrections {
    /// Of a model that a search has come to; none where the search was interrupted.
    pub fn of(contexts: &Contexts<'_>, full: &ModelFit, rules: Rules<'_>) -> Self {
        let (selection, test) = (&contexts.selection, &contexts.test);
        let mut corrections = Self {
            refit: None,
            confirmed: Vec::new(),
            tested: 0,
            memory: 0,
            full: full.on(test),
        };
        if selection.control.is_interrupted() {
            return corrections;
        }
        let chose = |memory: usize| apart(selection.data, test.data, memory);
        let mut sought = Pooled::of_much(selection, full, &chose(0));
        let channels: Vec<usize> = sought.corrections.iter().map(|c| c.channel).collect();
        // What they leave tells noise from misfit better than what was left without them.
        let memory = additive_model::memory(selection, full, &sought.all(), &channels);
        if memory > 0 {
            sought = Pooled::of_channels(selection, full, &chose(memory), &channels);
        }
        corrections.memory = memory;
        corrections.tested = sought.corrections.len();
        let tested = |sought: &AdditiveModel, beside: &[&AdditiveModel]| {
            sought.on(test, &corrections.full, beside)
        };
        let refit = sought.refit.as_ref().map(|refit| tested(refit, &[]));
        let mut needed: Vec<AdditiveModel> = Vec::new();
        for correction in &sought.corrections {
            let beside: Vec<&AdditiveModel> = refit.iter().chain(&needed).collect();
            let tested = tested(correction, &beside);
            if tested.is_needed(rules.significance, corrections.tested) {
                needed.push(tested);
            }
        }
        if needed.is_empty() {
            return corrections;
        }
        let channels: Vec<usize> = needed.iter().map(|tested| tested.channel).collect();
        let rows = apart(test.data, selection.data, corrections.memory);
        let mut other = Pooled::of_channels(test, &corrections.full, &rows, &channels);
        corrections.refit = refit.map(|tested| Exchanged {
            tested,
            other: other.refit.take(),
        });
        let confirmed = needed.into_iter().map(|tested| {
            let mut others = other.corrections.iter();
            let other = others.find(|other| other.channel == tested.channel);
            Exchanged {
                other: other.cloned(),
                tested,
            }
        });
        corrections.confirmed = confirmed.collect();
        corrections
    }

    /// Over all rows, of which each is forecast by what was not fitted to it.
    pub fn over_all_rows(&self, contexts: &Contexts<'_>, full: &ModelFit) -> Vec<AdditiveModel> {
        let context = &contexts.whole;
        let chose: Vec<Vec<bool>> = (0..full.validation.len())
            .map(|channel| rows_that_chose(contexts, channel))
            .collect();
        let of = |correction: &Exchanged| {
            let over = |of: &AdditiveModel| of.on(context, full, &[]);
            let other = correction.other.as_ref().map(over);
            over(&correction.tested).with_rows_of(other.as_ref(), &chose)
        };
        self.refit.iter().chain(&self.confirmed).map(of).collect()
    }

    /// Rows after which noise is forgotten in a channel, whether it has a correction or not.
    pub fn memory(&self, contexts: &Contexts<'_>, channel: usize) -> usize {
        let own = additive_model::memory(&contexts.test, &self.full, &self.all(), &[channel]);
        own.max(self.memory)
    }

    /// What the parameters change and all corrections, over the rows that confirm them.
    pub fn all(&self) -> Vec<&AdditiveModel> {
        let all = self.refit.iter().chain(&self.confirmed);
        all.map(|correction| &correction.tested).collect()
    }

    /// What they leave of the rows that confirm them.
    pub fn left(&self) -> Vec<Vec<f64>> {
        additive_model::left(&self.full, &self.all())
    }

    /// The one of a channel, over the rows that confirm it.
    pub fn of_channel(&self, channel: usize) -> Option<&AdditiveModel> {
        let mut all = self.confirmed.iter().map(|correction| &correction.tested);
        all.find(|tested| tested.channel == channel)
    }

    /// What they stand for has no name.
    pub fn findings(&self, noise_level: &NoiseLevel, state: SearchState<'_>) -> Vec<Finding> {
        let all = self.all();
        let refitted = all.len() - self.confirmed.len();
        let numbers = refitted..all.len();
        numbers
            .map(|k| self.finding(all[k], &all[..k], noise_level, state))
            .collect()
    }

    /// The finding of one beside those before it.
    fn finding(
        &self,
        correction: &AdditiveModel,
        beside: &[&AdditiveModel],
        noise_level: &NoiseLevel,
        state: SearchState<'_>,
    ) -> Finding {
        let c = correction.channel;
        let channel = &self.full.model.channels()[c];
        let before = additive_model::left(&self.full, beside);
        let after = additive_model::left(&self.full, &[beside, &[correction]].concat());
        let odds = probability::of_unnamed(&correction.evidence);
        let pair = ResidualPair {
            poorer: &before,
            richer: &after,
        };
        let (of_before, of_after) = (rms(&before[c]), rms(&after[c]));
        Finding {
            effect: UNNAMED.to_string(),
            joints: vec![channel.name.clone()],
            parameters: Vec::new(),
            rmse_validation_before: of_before,
            rmse_validation_after: of_after,
            explained_share: noise_level.share(pair, &[c]),
            p_value: (correction.evidence.p_value * self.tested as f64).min(1.0),
            sentence: format!(
                "Something is missing on {} that {}; a smooth correction over {} takes its place, and {}.",
                channel.name,
                state.nameless(),
                correction.over.join(", "),
                sentences::improvement(of_before, of_after, channel.unit)
            ),
            rivals: Vec::new(),
            probability: odds.finding,
            probability_unnamed: odds.finding,
            probability_nothing: odds.nothing,
            formula: None,
        }
    }
}

/// Of the held-out rows that count for a channel those by which models were chosen.
fn rows_that_chose(contexts: &Contexts<'_>, channel: usize) -> Vec<bool> {
    let [all, chose] =
        [&contexts.whole, &contexts.selection].map(|c| c.recordings(Split::Validation));
    let pairs = all.into_iter().zip(chose);
    let chose = pairs.flat_map(|(all, chose)| {
        let rows = all.counting_for(channel);
        rows.map(|row| chose.counts_for(channel, row))
    });
    chose.collect()
}
