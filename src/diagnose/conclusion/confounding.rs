//! Confounding: names for a part of a law that the vocabulary does not have.
//!
//! Where something is left beside a finding, in the same channel, what is missing there may be one law of another joint's
//! motion: a channel that hears the current of another, friction that grows with a neighbour's position. Such a law has shapes
//! in common with many names, its mean with a torque offset, its slope over the load with a gain, and the name that it resembles
//! most takes a large part of it. In the place of the name there is put a smooth correction, or a formula of which every term is of
//! another joint's motion, beside all parameters of the model:
//!
//! ```text
//! ‖e_k − c_k‖² ≤ (1 + IN_DOUBT) ‖e − c‖²    in every channel, e_k without the name and e with it
//! ```
//!
//! If that leaves hardly more of recordings that were not fitted than the name and a correction beside it, and less than the name
//! alone by what matters, the name is not that of the physics, and is withdrawn; so it is where no correction takes what is left and a
//! formula does, if it leaves hardly more than the name with that formula beside it, and forecasts more of what the name leaves than
//! one of so many does by chance. What leaves as much as the name is another wording of it, and says nothing against it: a correction
//! by the joint's own motion and load, or a function of another joint's that hardly varies, in the place of an offset.
//! For a law that is one shape of many there is put a correction by the joint's own motion, too, if that leaves less than half of the
//! squares that the name alone leaves: so much says that the shape is another.
//! Corrections are sought of a model that is linearised, so they are sought again where the first ones have moved its parameters.
//!
//! A name for what lasts for one recording is fitted to each, the held-out ones too: whatever comes and goes with the motion looks like
//! a push where the motion stands still for some time. Chance does not follow the motion, so such a name is withdrawn if smooth functions
//! of the motion, which are not fitted to the held-out rows, forecast the larger part of what it takes there.

use crate::chain::effect::{Effect, Lasts};
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::channels_of;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::formula::seeking::{Fitted, FittedFormula, Seeking};
use crate::diagnose::residuals::additive_model::{self, AdditiveModel};
use crate::diagnose::residuals::effect_size::MATTERS;
use crate::diagnose::residuals::noise_level;
use crate::diagnose::residuals::quantity::Quantity;
use crate::diagnose::selection::forecast::{IN_DOUBT, forecast};
use crate::diagnose::selection::rival_models::RivalComparison;
use crate::stats::deviation::rms;

/// Times that corrections in the place of a name are sought, each but the first where those before it have moved the unknowns.
const SOUGHT: usize = 4;

/// The first finding of a model in whose place a smooth correction or a formula leaves hardly more, if there is one; asked of channels
/// for which a correction is needed beside the model at `significance`, or of which more than noise is left.
pub fn first(
    context: &Context<'_>,
    full: &ModelFit,
    comparisons: &[RivalComparison],
    significance: f64,
) -> Option<usize> {
    if context.control.is_interrupted() {
        return None;
    }
    let channels_of = |k: usize| channels_of(&full.model, &full.hypotheses[k].named_joints());
    let mut named: Vec<usize> = (0..comparisons.len()).flat_map(channels_of).collect();
    named.sort_unstable();
    named.dedup();
    let mut corrections = additive_model::of_some(context, full, &named);
    let tried = corrections.len();
    corrections.retain(|correction| correction.is_needed(significance, tried));
    let named = Named {
        context,
        full,
        significance,
    };
    (0..comparisons.len()).find(|&k| {
        let (channels, without) = (channels_of(k), &comparisons[k].without);
        let is_of_one_recording = full.hypotheses[k].effect.needs.lasts == Lasts::OneRecording;
        if is_of_one_recording && named.follows_the_motion(&channels, without) {
            return true;
        }
        let beside = corrections.iter();
        let beside: Vec<&AdditiveModel> =
            beside.filter(|c| channels.contains(&c.channel)).collect();
        match (&beside[..], &channels[..]) {
            ([], &[channel]) => named.yields_to_a_formula(channel, without),
            ([], _) => false,
            _ => named.is_superfluous(full.hypotheses[k].effect, &beside, without),
        }
    })
}

/// A model with names.
struct Named<'a> {
    context: &'a Context<'a>,
    full: &'a ModelFit,
    /// Probability with which chance may speak against one.
    significance: f64,
}

/// A formula in the place of a finding.
struct FormulaInPlace {
    found: FittedFormula,
    /// Number of the terms that it was made of.
    tried: usize,
}

/// Held-out residuals of a model, `[channel][row]`.
type Left = Vec<Vec<f64>>;

impl Named<'_> {
    /// Whether smooth functions of the motion forecast the larger part of the squares that a finding takes of held-out rows.
    fn follows_the_motion(&self, channels: &[usize], without: &ModelFit) -> bool {
        let smooth = additive_model::of_some(self.context, without, channels);
        // Functions of time are other wordings of what lasts for some time.
        let of_motion = smooth.iter().filter(|correction| correction.is_of_motion());
        let needed: Vec<&AdditiveModel> = of_motion
            .filter(|correction| correction.is_needed(self.significance, smooth.len()))
            .collect();
        let instead = additive_model::left(without, &needed);
        let squares = |left: &Left| -> f64 {
            let of_channel = |&c: &usize| left[c].iter().map(|e| e * e).sum::<f64>();
            channels.iter().map(of_channel).sum()
        };
        let [nothing, with, instead] =
            [&without.validation, &self.full.validation, &instead].map(squares);
        !needed.is_empty() && nothing - instead > 0.5 * (nothing - with)
    }

    /// Whether the model without a finding and with smooth corrections or a formula in its place leaves hardly more than the finding
    /// with such corrections beside it.
    fn is_superfluous(
        &self,
        effect: &Effect,
        beside: &[&AdditiveModel],
        without: &ModelFit,
    ) -> bool {
        let full = self.full;
        let both = additive_model::left(full, beside);
        let smooth = InPlace::of(self.context, without.clone(), beside);
        let asked = Asked {
            named: self,
            effect,
            beside,
            both: &both,
        };
        if asked.yields_to(&smooth, SOUGHT) {
            return true;
        }
        let [correction] = beside else {
            return false;
        };
        let mut smooth = smooth.corrections.iter();
        let instead = smooth.find(|c| c.channel == correction.channel);
        let mut variables = instead.map_or_else(Vec::new, |c| c.made_of.clone());
        // What the name has not taken follows what would take all of it.
        let after_first = variables.len().min(1);
        variables.splice(after_first..after_first, correction.made_of.iter().cloned());
        let formula = self.formula(correction.channel, without, &variables);
        formula.is_some_and(|instead| self.yields_to(&instead, &both))
    }

    /// Whether something is left beside a finding that no smooth correction takes, and a formula in the place of the finding leaves
    /// hardly more than with the finding.
    fn yields_to_a_formula(&self, channel: usize, without: &ModelFit) -> bool {
        let noise = self.context.noise.as_ref();
        let known = noise.map_or(0.0, |noise| noise[channel]);
        if noise_level::is_noise(&self.full.validation[channel], known) {
            return false;
        }
        let Some(instead) = self.formula(channel, without, &[]) else {
            return false;
        };
        let beside = self.seeking(self.full, &[]);
        let both = beside.fit(channel, instead.found.formula());
        both.is_some_and(|both| self.yields_to(&instead, &both.fit.validation))
    }

    /// Whether a formula takes the place of a name, and forecasts more of what that leaves than one of so many does by chance.
    fn yields_to(&self, instead: &FormulaInPlace, both: &Left) -> bool {
        let pair = FitPair {
            poorer: self.full,
            richer: &instead.found.fit,
        };
        let forecasts = || {
            let p_value = forecast(self.context, pair).p_value;
            p_value * (instead.tried as f64) < self.significance
        };
        takes_its_place(&pair.richer.validation, both, &pair.poorer.validation) && forecasts()
    }

    /// The formula in the place of a finding, if every term of it is of another joint's motion.
    fn formula(
        &self,
        channel: usize,
        without: &ModelFit,
        variables: &[Vec<Quantity>],
    ) -> Option<FormulaInPlace> {
        let seeking = self.seeking(without, variables);
        let Fitted { mut all, tried } = seeking.fitted(channel)?;
        let chosen = seeking.chosen(channel, &all)?;
        let found = all.swap_remove(chosen).of_others()?;
        Some(FormulaInPlace { found, tried })
    }

    fn seeking<'s>(&'s self, model: &'s ModelFit, variables: &'s [Vec<Quantity>]) -> Seeking<'s> {
        Seeking {
            context: self.context,
            model,
            variables,
        }
    }
}

/// What is asked of smooth corrections in the place of a name.
struct Asked<'a> {
    named: &'a Named<'a>,
    /// Of the name.
    effect: &'a Effect,
    /// The corrections that are needed beside it, and what they leave with it.
    beside: &'a [&'a AdditiveModel],
    both: &'a Left,
}

impl Asked<'_> {
    /// Whether corrections take the place of the name, or those do that are sought where they have moved the unknowns, so many times
    /// in all.
    fn yields_to(&self, smooth: &InPlace, times: usize) -> bool {
        let alone = &self.named.full.validation;
        let is_of_others = smooth.corrections.iter().any(|c| !c.is_own);
        let is_a_shape = self.effect.knowledge.has_one_shape_of_many;
        if smooth.corrections.len() != self.beside.len() || !is_of_others && !is_a_shape {
            return false;
        }
        let left = smooth.left();
        let takes_most_of = |c: &&AdditiveModel| takes_most(&left, alone, c.channel);
        let says_enough = is_of_others || self.beside.iter().any(takes_most_of);
        if says_enough && takes_its_place(&left, self.both, alone) {
            return true;
        }
        times > 1 && {
            let stepped = smooth.stepped(self.named.context, self.beside);
            self.yields_to(&stepped, times - 1)
        }
    }
}

/// Smooth corrections in the place of a name.
struct InPlace {
    /// The model without the name.
    without: ModelFit,
    corrections: Vec<AdditiveModel>,
}

impl InPlace {
    /// Those of a model without the name, beside which these are needed with it.
    fn of(context: &Context<'_>, without: ModelFit, beside: &[&AdditiveModel]) -> Self {
        let corrections = additive_model::in_place(context, &without, beside);
        Self {
            without,
            corrections,
        }
    }

    /// Those where the first ones have moved the unknowns of the model: its derivatives, and the loads of its joints, are others there.
    fn stepped(&self, context: &Context<'_>, beside: &[&AdditiveModel]) -> Self {
        let mut without = self.without.clone();
        for correction in &self.corrections {
            without = without.stepped(context, correction.step());
        }
        Self::of(context, without, beside)
    }

    /// What they leave of the held-out rows.
    fn left(&self) -> Left {
        let corrections: Vec<&AdditiveModel> = self.corrections.iter().collect();
        additive_model::left(&self.without, &corrections)
    }
}

/// Whether what stands in the place of a name leaves hardly more than the name with more beside it, in every channel, and takes some of
/// what the name alone leaves.
fn takes_its_place(instead: &Left, both: &Left, alone: &Left) -> bool {
    let mut pairs = instead.iter().zip(alone);
    let takes = pairs.any(|(instead, alone)| rms(instead) <= (1.0 - MATTERS) * rms(alone));
    takes && is_hardly_more(instead, both)
}

/// Whether what stands in the place of a name takes more than half of the squares that the name leaves of a channel.
fn takes_most(instead: &Left, alone: &Left, channel: usize) -> bool {
    let square = |left: &Left| rms(&left[channel]).powi(2);
    2.0 * square(instead) < square(alone)
}

/// Whether what is left in the place of a name is hardly more than with the name, in every channel.
fn is_hardly_more(instead: &Left, both: &Left) -> bool {
    let mean_square = |residual: &[f64]| rms(residual).powi(2);
    let mut pairs = instead.iter().zip(both);
    pairs.all(|(instead, both)| mean_square(instead) <= (1.0 + IN_DOUBT) * mean_square(both))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leaves_as_much_as_a_name_is_another_wording_of_it() {
        let left = |first: f64| vec![vec![first; 4], vec![1.0; 4]];
        let takes_its_place = |instead| takes_its_place(&left(instead), &left(1.0), &left(1.1));
        assert!(takes_its_place(1.0));
        // An offset that is called an exponential without a slope.
        assert!(!takes_its_place(1.1));
        assert!(takes_its_place(1.1 * 0.989));
        assert!(!takes_its_place(1.1 * 0.991));
        // Of the squares half as much again as with the name, and not more.
        let beside = |instead: f64| super::takes_its_place(&left(instead), &left(1.0), &left(2.0));
        assert!(beside(1.5_f64.sqrt() - 1e-9));
        assert!(!beside(1.5_f64.sqrt() + 1e-9));
    }
}
