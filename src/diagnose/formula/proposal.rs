//! The formula that is proposed for the unexplained residual of a channel, if one is significant.
//!
//! Formulas are chosen by the rows that choose models and tested by rows that no choice has seen: one has to forecast what the
//! model leaves there, at the stated significance for as many tests as there are channels without a name, and to leave less,
//! significantly and by what matters, than what else takes the misfit: a smooth correction, or a name that resembles it.

use crate::chain::effect::user_law;
use crate::diagnose::candidates::score_test::Linearised;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::candidate::Candidate;
use crate::diagnose::fit::contexts::Contexts;
use crate::diagnose::fit::fitting::fit_model;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::fit::start::Start;
use crate::diagnose::formula::dissipation;
use crate::diagnose::formula::grammar::Grammar;
use crate::diagnose::formula::law::Formula;
use crate::diagnose::formula::rows::{FittedRows, Place};
use crate::diagnose::formula::search;
use crate::diagnose::formula::solved::Misfit;
use crate::diagnose::residuals::effect_size::MATTERS;
use crate::diagnose::residuals::noise_level::NoiseLevel;
use crate::diagnose::residuals::quantity::Quantity;
use crate::diagnose::selection::exact_fit::ExactFit;
use crate::diagnose::selection::forecast::forecast;
use crate::diagnose::selection::hypothesis_test::{CONFIDENCE, HypothesisTest};
use crate::diagnose::selection::stepwise::CHOICE;
use crate::estimate::covariance::of_unknowns;
use crate::estimate::fit::outcome_with;
use crate::outcome::parameter::Parameter;
use crate::recording::split::Split;
use crate::stats::deviation::rms;
use crate::stats::encompassing::{Encompassing, Known, ResidualPair};
use rayon::prelude::*;

/// Rows along which formulas are sought: what takes 2 % of the squares of so many is told from chance among thousands of terms.
const ENOUGH: usize = 1200;

/// Of so many variables every shape and every product of two is tried.
const FEW: usize = 4;

/// What formulas are sought for.
pub struct Proposing<'a> {
    pub contexts: &'a Contexts<'a>,
    /// The model without a formula, with what it leaves on the rows that choose.
    pub model: &'a ModelFit,
    pub noise_level: &'a NoiseLevel,
    pub significance: f64,
    /// Channels without a name.
    pub channels: usize,
    /// Of each function of a smooth correction, the foremost first, what it says that the misfit is a function of.
    pub variables: &'a [Vec<Quantity>],
}

/// A formula that has earned it.
pub struct Proposal {
    /// With the values of its fit.
    pub formula: Formula,
    pub parameters: Vec<Parameter>,
    /// On rows that no choice has seen.
    pub test: HypothesisTest,
    /// Of the formula against what else takes the misfit, on the same rows.
    pub against: Option<Encompassing>,
    /// Held-out RMS error of its channel.
    pub rmse: f64,
    /// Share of the excess over the noise that it takes.
    pub explains: f64,
    /// Terms that were tried.
    pub tried: usize,
    /// Those that explain something.
    pub others: Vec<Other>,
}

/// A formula that was fitted and is not proposed.
pub struct Other {
    pub formula: Formula,
    pub explains: f64,
}

/// A formula with the fit of the model that has it.
struct FittedFormula {
    formula: Formula,
    hypothesis: Hypothesis,
    fit: ModelFit,
}

/// The formulas of a channel, fitted.
struct Fitted {
    all: Vec<FittedFormula>,
    tried: usize,
}

impl Proposing<'_> {
    /// The formula of a channel; `rival` are residuals of what else takes the misfit, over rows that no choice has seen.
    pub fn propose(
        &self,
        channel: usize,
        rival: Option<&[Vec<f64>]>,
    ) -> Result<Option<Proposal>, DiagnoseError> {
        let Some(Fitted { all, tried }) = self.fitted(channel) else {
            return Ok(None);
        };
        let Some(chosen) = self.chosen(channel, &all) else {
            return Ok(None);
        };
        let rows = &self.contexts.test;
        let before = self.model.on(rows);
        let after = |k: usize| all[k].fit.on(rows);
        let hypothesis = all[chosen].hypothesis.clone();
        let test = HypothesisTest::of(rows, &before, after(chosen), hypothesis);
        let test = test.corrected_for(self.channels);
        if !test.is_needed(self.significance) {
            return Ok(None);
        }
        let formula = &test.fit.validation;
        let against = rival.map(|left| {
            let pair = ResidualPair {
                poorer: left,
                richer: formula,
            };
            pair.encompassing(Known::default(), rows.residual_rows())
        });
        let leaves_less =
            |left: &[Vec<f64>]| rms(&formula[channel]) < (1.0 - MATTERS) * rms(&left[channel]);
        let is_significant = |test: Encompassing| test.p_value < self.significance;
        if !(rival.is_none_or(leaves_less) && against.is_none_or(is_significant)) {
            return Ok(None);
        }
        let explains = |fit: &ModelFit| {
            let pair = FitPair {
                poorer: &before,
                richer: fit,
            };
            self.noise_level.share(pair.held_out(), &[channel])
        };
        let others = (0..all.len()).filter(|k| *k != chosen).map(|k| Other {
            formula: with_values(&all[k]),
            explains: explains(&after(k)),
        });
        let others = others.filter(|other| other.explains >= MATTERS);
        Ok(Some(Proposal {
            others: others.collect(),
            formula: with_values(&all[chosen]),
            parameters: self.parameters(&all[chosen]),
            rmse: rms(&test.fit.validation[channel]),
            explains: explains(&test.fit),
            against,
            test,
            tried,
        }))
    }

    /// The foremost formulas of a channel, each fitted with all parameters of the model; those that are possible.
    fn fitted(&self, channel: usize) -> Option<Fitted> {
        let context = &self.contexts.selection;
        let train = context.recordings(Split::Train);
        let count: usize = train.iter().map(|r| r.counting().count()).sum();
        let linearised = Linearised::of_every((count / ENOUGH).max(1), context, self.model);
        let place = Place {
            channel,
            recordings: linearised.recordings(),
            deviation: self.model.deviations()[channel],
        };
        let rows = FittedRows::of(context, self.model, &place)?;
        let is_known = |quantity: &Quantity| !rows.series(*quantity).is_empty();
        let mut sets: Vec<Option<Vec<Quantity>>> = few_of(self.variables, &is_known);
        if sets.is_empty() {
            sets.push(None);
        }
        let mut tried = 0;
        let mut all = Vec::new();
        for few in sets {
            let grammar = Grammar::of(&rows, few.as_deref());
            let misfit = Misfit {
                linearised: &linearised,
                channel,
                rows: &rows,
                grammar: &grammar,
            };
            let found = search::formulas(&misfit, &|| context.control.is_interrupted());
            let model = &self.model.model;
            let formulas = found.par_iter().filter_map(|solved| {
                let formula = Formula::of(solved, &grammar, model, rows.joint);
                self.fit(channel, formula)
            });
            all.extend(formulas.collect::<Vec<FittedFormula>>());
            tried += grammar.terms.len();
        }
        Some(Fitted { all, tried })
    }

    fn fit(&self, channel: usize, formula: Formula) -> Option<FittedFormula> {
        let context = &self.contexts.selection;
        let hypothesis = Hypothesis {
            effect: user_law::effect(&formula.text()).ok()?,
            joints: vec![formula.joint],
            other: None,
        };
        let values = formula
            .parameters()
            .map(|p| (full_name(&formula, &p.name), p.value));
        let start: Start = values.collect();
        let mut hypotheses = self.model.hypotheses.clone();
        hypotheses.push(hypothesis.clone());
        let from = self.model.warm_start().with(&start);
        // A formula that cannot be fitted is none.
        let fit = fit_model(context, &hypotheses, &from).ok()?;
        let candidate = Candidate {
            hypothesis: hypothesis.clone(),
            gain: 0.0,
            start,
            others: Vec::new(),
            anew: Vec::new(),
        };
        let exact = ExactFit {
            context,
            before: self.model,
            candidate: &candidate,
        };
        let brakes = || !formula.has_friction() || dissipation::brakes(context, &fit, channel);
        (exact.is_possible(&fit) && brakes()).then_some(FittedFormula {
            formula,
            hypothesis,
            fit,
        })
    }

    /// Of the formulas that the rows which choose want, the one of the least charged error, or one with fewer parameters that
    /// is not significantly worse, or not by what matters.
    fn chosen(&self, channel: usize, all: &[FittedFormula]) -> Option<usize> {
        let context = &self.contexts.selection;
        let is_wanted = |k: &usize| {
            let FittedFormula {
                hypothesis, fit, ..
            } = &all[*k];
            let test = HypothesisTest::of(context, self.model, fit.clone(), hypothesis.clone());
            test.corrected_for(all.len()).is_needed(CHOICE)
        };
        let wanted: Vec<usize> = (0..all.len()).filter(is_wanted).collect();
        let parameters = |k: usize| all[k].formula.parameters().count();
        let charged = |k: usize| {
            let fit = &all[k].fit;
            let rows = fit.validation[channel].len().max(1) as f64;
            fit.held_out_score() + parameters(k) as f64 * rows.ln()
        };
        let best = *wanted
            .iter()
            .min_by(|&&a, &&b| charged(a).total_cmp(&charged(b)))?;
        let is_as_good = |k: &usize| {
            let pair = FitPair {
                poorer: &all[*k].fit,
                richer: &all[best].fit,
            };
            let error = |fit: &ModelFit| rms(&fit.validation[channel]);
            let excess = error(pair.poorer) / error(pair.richer) - 1.0;
            *k == best || excess <= MATTERS || forecast(context, pair).p_value > 1.0 - CONFIDENCE
        };
        let as_good = wanted.iter().copied().filter(is_as_good);
        as_good.min_by(|&a, &b| {
            let fewer = parameters(a).cmp(&parameters(b));
            fewer.then(charged(a).total_cmp(&charged(b)))
        })
    }

    /// The parameters of a formula with their intervals.
    fn parameters(&self, fitted: &FittedFormula) -> Vec<Parameter> {
        let context = &self.contexts.whole;
        let recordings = context.recordings(Split::Train);
        let problem = fitted.fit.problem(&recordings);
        let covariance = of_unknowns(&problem, &fitted.fit.solution.x);
        let all = outcome_with(&problem, &fitted.fit.solution, covariance, context.data)
            .estimate
            .parameters;
        let prefix = full_name(&fitted.formula, "");
        all.into_iter()
            .filter(|parameter| parameter.name.starts_with(&prefix))
            .collect()
    }
}

/// Variables of the first function of a smooth correction, of the first two, and so on, for as long as they are few.
fn few_of(
    functions: &[Vec<Quantity>],
    is_known: &dyn Fn(&Quantity) -> bool,
) -> Vec<Option<Vec<Quantity>>> {
    let mut sets = Vec::new();
    let mut known: Vec<Quantity> = Vec::new();
    for of_function in functions {
        let before = known.len();
        for quantity in of_function.iter().filter(|quantity| is_known(quantity)) {
            if !known.contains(quantity) {
                known.push(*quantity);
            }
        }
        if known.len() > FEW {
            break;
        }
        if known.len() > before {
            sets.push(Some(known.clone()));
        }
    }
    sets
}

fn full_name(formula: &Formula, parameter: &str) -> String {
    format!("{}.{}.{parameter}", formula.on, formula.id)
}

/// The formula with the values of its fit.
fn with_values(fitted: &FittedFormula) -> Formula {
    let FittedFormula { formula, fit, .. } = fitted;
    formula.with_values(&|name| {
        let index = fit.model.position(&full_name(formula, name))?;
        Some(fit.values[index])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use Quantity::{Load, OtherVelocity, Position, Velocity};

    /// Variables add up, function after function, for as long as they are few; what a formula cannot have is left out.
    #[test]
    fn formulas_have_the_variables_of_the_foremost_functions() {
        let functions = [
            vec![Position, OtherVelocity(2)],
            vec![OtherVelocity(2), OtherVelocity(7)],
            vec![Velocity, Load],
            vec![OtherVelocity(1)],
        ];
        let is_known = |quantity: &Quantity| *quantity != OtherVelocity(7);
        let first = vec![Position, OtherVelocity(2)];
        let second = [&first[..], &[Velocity, Load]].concat();
        let found = few_of(&functions, &is_known);
        assert_eq!(found, [Some(first), Some(second)]);
        assert!(few_of(&[], &is_known).is_empty());
        assert!(few_of(&[vec![OtherVelocity(7)]], &is_known).is_empty());
    }
}
