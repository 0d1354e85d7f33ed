//! Exact fits: a candidate beside what a model has, all parameters searched from every start that may lead to the best
//! optimum, and a model without one of its hypotheses.

use crate::chain::effect::{Law, Linearity};
use crate::chain::parameter::Role;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::candidate::{Anew, Candidate};
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::fitting::{fit_model, fit_model_holding, fit_model_searching_gaps};
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::fit::start::{Start, WarmStart};
use crate::diagnose::residuals::effect_size::HALF_OF_WHAT_MATTERS;
use crate::diagnose::selection::hypothesis_test::CONFIDENCE;
use crate::diagnose::selection::law_range;
use crate::diagnose::selection::search_bounds;
use crate::diagnose::selection::time_window;
use crate::stats::deviation::rms;
use crate::stats::likelihood_ratio::{BY_CHANCE, is_beyond_chance};
use rayon::prelude::*;
use std::cmp::Ordering;

/// A search that reaches less than this share of what one step of all parameters promised is made from other starts too.
const PROMISED: f64 = 0.5;

/// Weighted sum of squares of one joint whose loss lowers its RMS error by half of what matters: what
/// promises less on the fitted rows does not matter on others.
pub fn least_gain(fit: &ModelFit) -> f64 {
    let rows = fit.train.iter().map(Vec::len).max().unwrap_or(0) as f64;
    HALF_OF_WHAT_MATTERS * rows
}

/// A model without its k-th hypothesis, fitted again.
pub fn fit_without(
    context: &Context<'_>,
    full: &ModelFit,
    k: usize,
) -> Result<ModelFit, DiagnoseError> {
    let mut hypotheses = full.hypotheses.clone();
    hypotheses.remove(k);
    let make = || fit_model(context, &hypotheses, &full.warm_start());
    context
        .cache
        .fit_from(&hypotheses, &full.hypotheses, least_gain(full), make)
}

/// Sum of squares that a richer model takes from the fitted rows, in units of what the poorer one leaves in a row.
pub fn taken(pair: FitPair<'_>) -> f64 {
    let of = |(old, new): (&Vec<f64>, &Vec<f64>)| match rms(old) {
        left if left > 0.0 => old.len() as f64 * (1.0 - (rms(new) / left).powi(2)),
        _ => 0.0,
    };
    pair.poorer
        .train
        .iter()
        .zip(&pair.richer.train)
        .map(of)
        .sum()
}

/// Whether a candidate may take about as much as another hypothesis that was found to take so much.
pub fn competes(candidate: &Candidate, taken: f64) -> bool {
    candidate.gain >= PROMISED * taken
}

/// A candidate to be fitted beside what a model has.
pub struct ExactFit<'a> {
    /// The problem with its recordings.
    pub context: &'a Context<'a>,
    /// The model without the candidate.
    pub before: &'a ModelFit,
    /// What is added, and from where.
    pub candidate: &'a Candidate,
}

impl ExactFit<'_> {
    /// The model with the candidate at the optimum that its most promising start leads to.
    pub fn first(&self) -> Result<ModelFit, DiagnoseError> {
        let hypotheses = self.hypotheses();
        let start = self.before.warm_start().with(&self.candidate.start);
        let make = || fit_model(self.context, &hypotheses, &start);
        self.context.cache.first_fit(&hypotheses, make)
    }

    /// The model with the candidate at the best optimum that its starts lead to.
    pub fn best(&self) -> Result<ModelFit, DiagnoseError> {
        let hypotheses = self.hypotheses();
        let search = || self.search(&hypotheses);
        self.context.cache.fit_model(&hypotheses, search)
    }

    /// The model with the candidate, whose gap is searched for with everything else fitted beside each value; the best that is
    /// known of it.
    pub fn searching_gap(&self) -> Result<ModelFit, DiagnoseError> {
        let hypotheses = self.hypotheses();
        let start = self.before.warm_start().with(&self.candidate.start);
        let search = || fit_model_searching_gaps(self.context, &hypotheses, &start);
        let least = least_gain(self.before);
        self.context
            .cache
            .fit_from(&hypotheses, &hypotheses, least, search)
    }

    /// Whether nothing hints at a better optimum than the first.
    pub fn is_settled(&self, first: &ModelFit) -> bool {
        !self.is_wanting(first) && !self.is_lost(first) && !self.fits_worse(first)
    }

    fn hypotheses(&self) -> Vec<Hypothesis> {
        let mut hypotheses = self.before.hypotheses.clone();
        hypotheses.push(self.candidate.hypothesis.clone());
        hypotheses
    }

    fn search(&self, hypotheses: &[Hypothesis]) -> Result<ModelFit, DiagnoseError> {
        let (before, candidate) = (self.before, self.candidate);
        let from = |start: &WarmStart| fit_model(self.context, hypotheses, start);
        let fitted = before.warm_start();
        let start = fitted.with(&candidate.start);
        let mut best = self.first()?;
        let is_wanting = self.is_wanting(&best);
        let others = candidate.others.iter().filter(|_| is_wanting);
        let others: Vec<WarmStart> = others.map(|own| fitted.with(own)).collect();
        let all = std::iter::once(&start).chain(&others);
        let bent = all.filter_map(|start| self.without_shapes(start));
        let starts: Vec<WarmStart> = others.iter().cloned().chain(bent).collect();
        let tried = starts.par_iter();
        let tried = tried.map(|start| fit_model_holding(self.context, hypotheses, start, &[]));
        let tried = tried.collect::<Result<Vec<ModelFit>, DiagnoseError>>()?;
        let foremost = tried.into_iter().reduce(|a, b| self.better(a, b));
        if let Some(foremost) = foremost.filter(|one| self.leads_further(one, &best)) {
            best = self.better(best, from(&foremost.warm_start())?);
        }
        if self.is_lost(&best) {
            for Anew { start: own, scales } in &candidate.anew {
                let again = WarmStart {
                    values: best.start(),
                    ..start.clone()
                };
                let again = again.with(own);
                let settled = fit_model_holding(self.context, hypotheses, &again, scales)?;
                let again = WarmStart {
                    values: settled.start(),
                    ..again
                };
                let found = from(&again)?;
                if self.finds_what_was_lost(&found, &best, own.len()) {
                    best = found;
                }
            }
        }
        // Everything else first, at the candidate's own values.
        if self.fits_worse(&best) {
            let settled = fit_model_holding(self.context, hypotheses, &start, &candidate.start)?;
            let again = WarmStart {
                values: settled.start(),
                ..start
            };
            best = self.better(best, from(&again)?);
        }
        Ok(best)
    }

    /// Whether a fit takes far less than was promised, or has the hypothesis where its physics does not.
    fn is_wanting(&self, fit: &ModelFit) -> bool {
        taken(FitPair {
            poorer: self.before,
            richer: fit,
        }) < PROMISED * self.candidate.gain
            || !self.is_possible(fit)
    }

    /// Whether a law with memory has lost what belongs to it.
    fn is_lost(&self, fit: &ModelFit) -> bool {
        let is_lost = |one: &Anew| is_at_a_limit(fit, &one.start) || self.forecasts_worse(fit);
        self.candidate.anew.iter().any(is_lost)
    }

    /// A richer model that fits worse was not searched well.
    fn fits_worse(&self, fit: &ModelFit) -> bool {
        fit.fitted_score() > self.before.fitted_score()
    }

    /// Whether a fit says less of the held-out rows than the model before: a shape may have bent where the fitted rows do not
    /// tell it.
    fn forecasts_worse(&self, fit: &ModelFit) -> bool {
        fit.held_out_score() > self.before.held_out_score()
    }

    /// Whether a fit has the hypothesis where its physics does.
    pub fn is_possible(&self, fit: &ModelFit) -> bool {
        let Candidate {
            hypothesis, start, ..
        } = self.candidate;
        is_possible(self.context, fit, hypothesis, start)
    }

    /// The one that fits better, or that alone is possible.
    fn better(&self, a: ModelFit, b: ModelFit) -> ModelFit {
        match self.is_better(&b, &a) {
            true => b,
            false => a,
        }
    }

    /// Whether a fit is better than another by more than where searches of one optimum end, or alone possible.
    pub fn leads_further(&self, fit: &ModelFit, other: &ModelFit) -> bool {
        self.is_better_by(fit, other, |gain| gain > BY_CHANCE)
    }

    /// Whether a search that begins again leads to a better fit than a law that has lost so many parameters would by chance, or to
    /// the only possible one: shapes without a meaning fit as well where they are, and forecast worse.
    fn finds_what_was_lost(&self, found: &ModelFit, without: &ModelFit, lost: usize) -> bool {
        self.is_better_by(found, without, |gain| {
            is_beyond_chance(gain, lost, CONFIDENCE)
        })
    }

    /// Whether a fit is better than another by what is enough, or alone possible.
    fn is_better_by(
        &self,
        fit: &ModelFit,
        other: &ModelFit,
        is_enough: impl Fn(f64) -> bool,
    ) -> bool {
        let gain = other.fitted_score() - fit.fitted_score();
        (is_enough(gain) || !self.is_possible(other)) && self.is_better(fit, other)
    }

    /// Whether a fit is better than another, or alone possible.
    fn is_better(&self, fit: &ModelFit, other: &ModelFit) -> bool {
        let impossible = |fit: &ModelFit| !self.is_possible(fit);
        let by_score = || fit.fitted_score().total_cmp(&other.fitted_score());
        let order = impossible(fit).cmp(&impossible(other)).then_with(by_score);
        order == Ordering::Less
    }

    /// The start with the nonlinear parameters of a law at the motor left where the model has them to begin with: those
    /// of the poorer model may have bent to take the place of what it lacks. `None` where there are none.
    fn without_shapes(&self, start: &WarmStart) -> Option<WarmStart> {
        let hypothesis = &self.candidate.hypothesis;
        let [joint] = hypothesis.joints[..] else {
            return None;
        };
        if !matches!(hypothesis.effect.law, Law::Motor(_)) {
            return None;
        }
        let model = &self.before.model;
        let bent = |name: &String| {
            model.position(name).is_some_and(|index| {
                let parameter = &model.parameters()[index];
                let own = matches!(parameter.role, Role::Effect { joint: j, .. } if j == joint);
                own && parameter.is_free() && parameter.linearity == Linearity::Nonlinear
            })
        };
        let mut kept = start.clone();
        kept.values.retain(|(name, _)| !bent(name));
        (kept.values.len() < start.values.len()).then_some(kept)
    }
}

/// Whether the parameters of a hypothesis, those of `own`, came out where its physics has them: friction that drives is no friction,
/// whatever it explains, a law of speed changes within the speeds of its joint, no shape lies at a limit of its search, and what
/// begins and ends does.
pub fn is_possible(
    context: &Context<'_>,
    fit: &ModelFit,
    hypothesis: &Hypothesis,
    own: &Start,
) -> bool {
    let model = &fit.model;
    let within_limits = own.iter().all(|(name, _)| {
        model.position(name).is_some_and(|index| {
            let parameter = &model.parameters()[index];
            (parameter.lower..=parameter.upper).contains(&fit.values[index])
        })
    });
    within_limits
        && law_range::are_reached(context, fit, hypothesis)
        && search_bounds::are_inside(fit, hypothesis)
        && time_window::is_shorter(context, fit, hypothesis)
}

/// Whether one of some parameters ended at a limit of what it may be.
fn is_at_a_limit(fit: &ModelFit, own: &Start) -> bool {
    own.iter().any(|(name, _)| {
        let found = fit.model.position(name);
        found.is_some_and(|index| search_bounds::is_at_a_limit(fit, index))
    })
}
