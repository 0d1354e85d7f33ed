//! What is left without a name: joints whose error is beyond noise though no finding names them, and errors that nothing
//! attests to be noise.

use crate::diagnose::conclusion::explanation::{Explanation, TriedModel};
use crate::diagnose::findings::compared::Compared;
use crate::diagnose::findings::probability;
use crate::diagnose::findings::sentences;
use crate::diagnose::residuals::additive_model::{self, AdditiveModel};
use crate::diagnose::residuals::effect_size::OF_TORQUE;
use crate::diagnose::residuals::noise_level::{UNEXPLAINED, chance};
use crate::diagnose::residuals::reversal_mask;
use crate::diagnose::selection::stepwise::Rules;
use crate::outcome::diagnose::Unattested;
use crate::outcome::finding::{Finding, UNNAMED};
use crate::recording::split::Split;
use crate::stats::deviation::rms;
use crate::stats::robust::scale_of_steps;

/// A residual below this share of the RMS signal is of no weight: rows are some hundredths of a second apart, and at
/// every reversal dry friction, a tenth of the usual torque or more, turns over between two of them.
const OF_SIGNAL: f64 = 0.03;

/// Residuals are looked at in all rows and in those under way, where reversals are no excuse.
const VIEWS: usize = 2;

/// What a search has come to beside its findings.
#[derive(Debug, Clone, Copy)]
pub struct SearchState<'a> {
    /// Chance of a finding where there is nothing.
    pub significance: f64,
    /// Joints of names that were withdrawn.
    pub withdrawn: &'a [usize],
    /// It was interrupted.
    pub is_cut_short: bool,
}

impl SearchState<'_> {
    /// Why a finding has no name.
    pub fn nameless(self) -> &'static str {
        match self.is_cut_short {
            false => "no effect of the vocabulary explains",
            true => "had no name yet when the search was interrupted",
        }
    }
}

impl Compared<'_> {
    /// Findings of channels without one whose held-out residual is much larger than noise, and larger than chance would
    /// have it, and not mostly explained by what is found elsewhere: not even where the misfit lies says what it is. What
    /// uncertain parameters add to a prediction is as attested as noise. Where a name was withdrawn there is a misfit of
    /// weight. Where nothing attests the noise it is at most what is left of the rows that were fitted. The one that is furthest beyond
    /// it comes first.
    pub fn unexplained(&self, findings: &[Finding], state: SearchState<'_>) -> Vec<Finding> {
        let fit = self.full;
        let signal = self.context.signal_rms(Split::Validation);
        let channels = fit.model.channels().iter().enumerate();
        let open = channels.filter_map(|(c, channel)| {
            let joint = channel.joint.filter(|_| channel.active)?;
            Some((c, &channel.name, joint))
        });
        let tried = (VIEWS * open.clone().count()) as f64;
        let found = |name: &String| findings.iter().any(|f| f.joints.contains(name));
        let mut unexplained: Vec<(f64, Finding)> = open
            .filter(|(c, name, _)| !found(name) && self.is_left(*c))
            .filter_map(|(c, name, joint)| {
                let residual = &fit.validation[c];
                let least = match state.withdrawn.contains(&joint) {
                    true => 0.0,
                    false => OF_SIGNAL,
                };
                let (noise, than) = match self.noise_level.measured {
                    true => (self.noise_level.rms[c], "the noise"),
                    false => (rms(&fit.train[c]), "that on those that were"),
                };
                let attested = self.predicted.beside(c, noise);
                let under_way = reversal_mask::residual(self.context, fit, c, residual);
                let views: [(&[f64], f64); VIEWS] = [(residual, least), (&under_way, OF_TORQUE)];
                let of_weight = views
                    .into_iter()
                    .filter(|(rows, least)| rms(rows) > least * signal[c]);
                let chances = of_weight.filter_map(|(rows, _)| chance(rows, attested));
                let p_value = (chances.reduce(f64::min)? * tried).min(1.0);
                let odds = probability::of_unexplained(p_value);
                let times = rms(residual) / noise;
                let finding = Finding {
                    effect: UNNAMED.to_string(),
                    joints: vec![name.clone()],
                    parameters: Vec::new(),
                    rmse_validation_before: rms(residual),
                    rmse_validation_after: rms(residual),
                    explained_share: 0.0,
                    p_value,
                    sentence: format!(
                        "Something is missing on {name} that {}, and no smooth correction takes its place: the error on \
                         recordings that were not fitted is {times:.1} times {than}.",
                        state.nameless(),
                    ),
                    rivals: Vec::new(),
                    probability: odds.finding,
                    probability_unnamed: odds.finding,
                    probability_nothing: odds.nothing,
                    formula: None,
                };
                (p_value < state.significance).then_some((times, finding))
            })
            .collect();
        unexplained.sort_by(|a, b| b.0.total_cmp(&a.0));
        let findings = unexplained.into_iter();
        findings.map(|(_, finding)| finding).collect()
    }

    /// Channels of which the residual is of weight, more than 3 % of the signal, and more than [`UNEXPLAINED`] times the variance of
    /// the noise that is known apart from the misfit: by the scatter of periods, by what no motion reaches in the signal, or by
    /// what successive rows of the residual usually differ, in which a misfit that follows the motion has no part, nor have
    /// impacts of a few rows. Slow noise is not told from misfit, and what uncertain parameters add to a prediction is added to it. Whatever the rows show, noise is no
    /// more than a model that was tried leaves, confirmed or not. Where no row counts nothing is known. The final model, with smooth
    /// corrections.
    pub fn unattested(
        &self,
        corrections: &[&AdditiveModel],
        explanation: &Explanation,
        rules: Rules<'_>,
    ) -> Vec<Unattested> {
        let (model, left) = (
            &self.full.model,
            additive_model::left(self.full, corrections),
        );
        let signal = self.context.signal_rms(Split::Validation);
        let channels = model.channels().iter().enumerate();
        let active = channels.filter(|(_, channel)| channel.active);
        let open = active.filter_map(|(c, channel)| {
            if left[c].is_empty() {
                return Some(Unattested {
                    joint: channel.name.clone(),
                    unit: channel.unit.to_string(),
                    rmse_validation: f64::NAN,
                    of_signal: f64::NAN,
                    sentence: sentences::nothing_counts(&channel.name),
                });
            }
            let noise = match self.noise_level.measured {
                true => self.noise_level.rms[c],
                false => {
                    let of_signal = self.context.noise.as_ref().map_or(0.0, |noise| noise[c]);
                    scale_of_steps(&left[c]).unwrap_or(0.0).max(of_signal)
                }
            };
            let residual = rms(&left[c]);
            let by = |tried: &TriedModel<'_>| tried.share * rms(&self.full.validation[c]);
            let tried = explanation.least_tried(c, rules);
            let tried = tried.filter(|tried| by(tried) < noise);
            let noise = tried.as_ref().map_or(noise, by);
            let attested = self.predicted.beside(c, noise);
            let excess = residual > UNEXPLAINED.sqrt() * attested;
            let mut left = Unattested {
                joint: channel.name.clone(),
                unit: channel.unit.to_string(),
                rmse_validation: residual,
                of_signal: residual / signal[c],
                sentence: String::new(),
            };
            left.sentence = sentences::unattested(&left, tried);
            (excess && left.of_signal > OF_SIGNAL).then_some(left)
        });
        open.collect()
    }
}
