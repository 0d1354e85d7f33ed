//! Additive models as corrections of what no effect explains, chosen and tested on different rows.

use crate::diagnose::findings::unexplained::SearchState;
use crate::diagnose::findings::{probability, sentences};
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::contexts::Contexts;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::additive_model::{self, AdditiveModel};
use crate::diagnose::residuals::noise_level::NoiseLevel;
use crate::diagnose::selection::stepwise::Rules;
use crate::outcome::finding::{Finding, UNNAMED};
use crate::stats::deviation::rms;
use crate::stats::encompassing::ResidualPair;

/// Smooth corrections that one half of the held-out rows asks for, and the other half confirms.
pub struct Corrections {
    /// Over the rows that confirm them.
    confirmed: Vec<AdditiveModel>,
    /// Number of those that were tested.
    tested: usize,
    /// The final model over the same rows.
    full: ModelFit,
}

impl Corrections {
    /// Of a model that a search has come to; none where the search was interrupted.
    pub fn of(contexts: &Contexts<'_>, full: &ModelFit, rules: Rules<'_>) -> Self {
        let mut wanted = match contexts.selection.control.is_interrupted() {
            true => Vec::new(),
            false => additive_model::of_all(&contexts.selection, full),
        };
        let tried = wanted.len();
        let choice = rules.of_choice().significance;
        wanted.retain(|correction| correction.is_needed(choice, tried));
        let tested = wanted.len();
        let full = full.on(&contexts.test);
        let tests = wanted.iter().map(|s| s.on(&contexts.test, &full));
        Self {
            confirmed: tests
                .filter(|test| test.is_confirmed(rules.significance, tested))
                .collect(),
            tested,
            full,
        }
    }

    /// The same over the rows of another context.
    pub fn on(&self, context: &Context<'_>, full: &ModelFit) -> Vec<AdditiveModel> {
        let confirmed = self.confirmed.iter();
        confirmed
            .map(|correction| correction.on(context, full))
            .collect()
    }

    /// The one of a channel, over the rows that confirm it.
    pub fn of_channel(&self, channel: usize) -> Option<&AdditiveModel> {
        self.confirmed.iter().find(|c| c.channel == channel)
    }

    /// What they stand for has no name.
    pub fn findings(&self, noise_level: &NoiseLevel, state: SearchState<'_>) -> Vec<Finding> {
        let confirmed = self.confirmed.iter();
        confirmed
            .map(|correction| self.finding(correction, noise_level, state))
            .collect()
    }

    fn finding(
        &self,
        correction: &AdditiveModel,
        noise_level: &NoiseLevel,
        state: SearchState<'_>,
    ) -> Finding {
        let c = correction.channel;
        let channel = &self.full.model.channels()[c];
        let before = &self.full.validation;
        let after = additive_model::left(&self.full, &[correction]);
        let odds = probability::of_unnamed(&correction.evidence);
        let pair = ResidualPair {
            poorer: before,
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
