//! The foremost formulas of the residual of a channel, fitted with all parameters of the model: in the order of how well they forecast
//! fitted rows, and the one that the rows which choose prefer.

use crate::chain::effect::user_law;
use crate::diagnose::candidates::score_test::ScoreTests;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::fitting::fit_model;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::linear_model::LinearModel;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::fit::start::Start;
use crate::diagnose::formula::dissipation;
use crate::diagnose::formula::grammar::Grammar;
use crate::diagnose::formula::law::Formula;
use crate::diagnose::formula::rows::{FittedRows, Place};
use crate::diagnose::formula::search;
use crate::diagnose::formula::solved::{Misfit, Solved};
use crate::diagnose::residuals::effect_size::MATTERS;
use crate::diagnose::residuals::folds::FoldedModel;
use crate::diagnose::residuals::quantity::Quantity;
use crate::diagnose::selection::exact_fit::is_possible;
use crate::diagnose::selection::forecast::forecast;
use crate::diagnose::selection::hypothesis_test::{CONFIDENCE, HypothesisTest};
use crate::diagnose::selection::stepwise::CHOICE;
use crate::estimate::noise::counting_rows;
use crate::recording::split::Split;
use crate::stats::deviation::rms;
use rayon::prelude::*;

/// Rows along which formulas are sought: what takes 2 % of the squares of so many is told from chance among thousands of terms.
const ENOUGH: usize = 1200;

/// Rows along which fitted formulas are compared.
const JUDGING: usize = 4000;

/// Of so many variables every shape and every product of two is tried.
const FEW: usize = 4;

/// A model of which formulas are sought.
#[derive(Clone, Copy)]
pub struct Seeking<'a> {
    /// The rows that fit and choose.
    pub context: &'a Context<'a>,
    /// The model without a formula, with what it leaves on these rows.
    pub model: &'a ModelFit,
    /// Of each function of a smooth correction, the foremost first, what it says that the misfit is a function of.
    pub variables: &'a [Vec<Quantity>],
}

/// A formula with the fit of the model that has it.
pub struct FittedFormula {
    formula: Formula,
    /// The formula as the last of the hypotheses of the model.
    pub hypothesis: Hypothesis,
    /// The model.
    pub fit: ModelFit,
    /// Its friction drives the joint along part of the fitted recordings.
    pub drives: bool,
}

impl FittedFormula {
    /// The formula with the values of its fit.
    pub fn formula(&self) -> Formula {
        self.formula.with_values(&|name| {
            let index = self.fit.model.position(&self.formula.full_name(name))?;
            Some(self.fit.values[index])
        })
    }

    /// It, if each of its terms is of the motion of another joint too.
    pub fn of_others(self) -> Option<Self> {
        self.formula.is_of_others().then_some(self)
    }
}

/// The formulas of a channel, fitted.
pub struct Fitted {
    /// Those that are possible.
    pub all: Vec<FittedFormula>,
    /// Number of the terms that they were made of.
    pub tried: usize,
}

/// What one search has found.
struct Searched {
    /// Variables of the best formula that has few.
    few: Option<Vec<Quantity>>,
    fitted: Vec<FittedFormula>,
    tried: usize,
}

impl Seeking<'_> {
    /// The foremost formulas of a channel, each fitted with all parameters of the model; those that are possible.
    pub fn fitted(&self, channel: usize) -> Option<Fitted> {
        let context = self.context;
        let train = context.recordings(Split::Train);
        let score_tests =
            ScoreTests::of_every((counting_rows(&train) / ENOUGH).max(1), context, self.model);
        let place = Place {
            channel,
            recordings: score_tests.recordings(),
            deviation: self.model.deviations()[channel],
        };
        let rows = FittedRows::of(context, self.model, &place)?;
        let is_known = |quantity: &Quantity| !rows.series(*quantity).is_empty();
        let few = few_of(self.variables, &is_known);
        let search = |few: Option<&[Quantity]>| self.searched(&score_tests, channel, &rows, few);
        let mut searched: Vec<Searched> = few.iter().map(|few| search(Some(few))).collect();
        let of_all = search(None);
        // Of the variables of the best formula that has few, more shapes are tried than of all.
        let narrowed = of_all.few.as_deref();
        let is_new = |of: &&[Quantity]| !few.iter().any(|few| of.iter().all(|q| few.contains(q)));
        let narrowed = narrowed.filter(is_new).map(|few| search(Some(few)));
        searched.push(of_all);
        searched.extend(narrowed);
        Some(Fitted {
            tried: searched.iter().map(|one| one.tried).sum(),
            all: searched.into_iter().flat_map(|one| one.fitted).collect(),
        })
    }

    /// The foremost formulas of some variables, or of all, fitted.
    fn searched(
        &self,
        score_tests: &ScoreTests<'_>,
        channel: usize,
        rows: &FittedRows,
        few: Option<&[Quantity]>,
    ) -> Searched {
        let grammar = Grammar::of(rows, few);
        let misfit = Misfit::of(score_tests.linear(), channel, rows, &grammar);
        let found = search::formulas(&misfit, &|| self.context.control.is_interrupted());
        let fitted = found.par_iter().filter_map(|solved| {
            let formula = Formula::of(solved, &grammar, &self.model.model, rows.joint);
            self.fit(channel, formula)
        });
        let mut variables = found.iter().map(Solved::variables);
        Searched {
            few: variables.find(|of| of.len() <= FEW),
            fitted: fitted.collect(),
            tried: grammar.terms.len(),
        }
    }

    /// A formula of a channel beside what the model has already; `None` where it cannot be fitted or is not possible.
    pub fn fit(&self, channel: usize, formula: Formula) -> Option<FittedFormula> {
        let context = self.context;
        if formula.parameters().any(|p| !p.value.is_finite()) {
            return None;
        }
        let hypothesis = Hypothesis {
            effect: user_law::effect(&formula.text()).ok()?,
            joints: vec![formula.joint],
            other: None,
        };
        let values = formula
            .parameters()
            .map(|p| (formula.full_name(&p.name), p.value));
        let start: Start = values.collect();
        let mut hypotheses = self.model.hypotheses.clone();
        hypotheses.push(hypothesis.clone());
        let from = self.model.warm_start().with(&start);
        // A formula that cannot be fitted is none.
        let fit = fit_model(context, &hypotheses, &from).ok()?;
        is_possible(context, &fit, &hypothesis, &start).then(|| FittedFormula {
            drives: formula.has_friction() && !dissipation::brakes(context, &fit, channel),
            formula,
            hypothesis,
            fit,
        })
    }

    /// Formulas that forecast parts of the fitted rows from the others better than none does, the best first: of those that take hardly
    /// less of the squares than the best of the rest the ones of fewest variables, and of these one that errs hardly more than the
    /// best of them, that drives no joint, and that has few parameters.
    pub fn in_order(&self, channel: usize, all: &[FittedFormula]) -> Vec<usize> {
        let errors = all
            .par_iter()
            .map(|of| self.forecast_error(&of.fit, channel));
        let errors: Vec<f64> = errors.collect();
        let nothing = self.forecast_error(self.model, channel);
        let mut open: Vec<usize> = (0..all.len()).filter(|&k| errors[k] < nothing).collect();
        let mut order = Vec::with_capacity(open.len());
        let takes = |k: usize| nothing.powi(2) - errors[k].powi(2);
        let variables = |k: usize| all[k].formula.variables().len();
        let foremost = |open: &[usize]| {
            let most = open.iter().map(|&k| takes(k)).fold(0.0, f64::max);
            let takes_hardly_less = |k: &usize| takes(*k) >= (1.0 - MATTERS) * most;
            let mut as_good: Vec<usize> = open.iter().copied().filter(takes_hardly_less).collect();
            let fewest = as_good.iter().map(|&k| variables(k)).min()?;
            as_good.retain(|&k| variables(k) == fewest);
            let least = as_good.iter().map(|&k| errors[k]).fold(nothing, f64::min);
            as_good.retain(|&k| errors[k] <= (1.0 + MATTERS) * least);
            simplest(all, as_good.into_iter(), &|k| errors[k])
        };
        while let Some(next) = foremost(&open) {
            open.retain(|k| *k != next);
            order.push(next);
        }
        order
    }

    /// RMS error of a channel by cross-validation of the fitted rows; infinite where parts of these do not determine the parameters.
    fn forecast_error(&self, fit: &ModelFit, channel: usize) -> f64 {
        let train = self.context.recordings(Split::Train);
        let (linear, _) = LinearModel::along_few(fit, &train, JUDGING);
        let folded = FoldedModel::of(&linear);
        let error = folded.and_then(|folded| folded.forecast_error(channel));
        error.map_or(f64::INFINITY, f64::sqrt) * linear.scale[channel]
    }

    /// Of the formulas that the rows which choose want, the one of the least charged error, or one that is not significantly
    /// worse, or not by what matters: one that drives no joint, and of these one with fewer parameters.
    pub fn chosen(&self, channel: usize, all: &[FittedFormula]) -> Option<usize> {
        let context = self.context;
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
        simplest(all, as_good, &charged)
    }
}

/// Of some formulas one that drives no joint, of these one with fewer parameters, and of these the one of the least error.
fn simplest(
    all: &[FittedFormula],
    some: impl Iterator<Item = usize>,
    error: &dyn Fn(usize) -> f64,
) -> Option<usize> {
    some.min_by(|&a, &b| {
        let of = |k: usize| (all[k].drives, all[k].formula.parameters().count());
        of(a).cmp(&of(b)).then(error(a).total_cmp(&error(b)))
    })
}

/// Variables of the first function of a smooth correction, of the first two, and so on, for as long as they are few.
fn few_of(functions: &[Vec<Quantity>], is_known: &dyn Fn(&Quantity) -> bool) -> Vec<Vec<Quantity>> {
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
            sets.push(known.clone());
        }
    }
    sets
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
        assert_eq!(found, [first, second]);
        assert!(few_of(&[], &is_known).is_empty());
        assert!(few_of(&[vec![OtherVelocity(7)]], &is_known).is_empty());
    }
}
