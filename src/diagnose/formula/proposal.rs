//! The formula that is proposed for the unexplained residual of a channel, if one is significant.
//!
//! Formulas are fitted to the fitted rows and those that choose models, and tested by rows that no choice has seen: one has to
//! forecast what the model leaves there, at the stated significance for as many tests as there are channels without a name and
//! formulas before it. Beside a smooth correction, which has dozens of parameters and forecasts no other motions than the recorded
//! ones, it may leave more by what does not matter of the error without either; beside a name that resembles it, it has to leave
//! less, significantly and by what matters.

use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::formula::law::Formula;
use crate::diagnose::formula::seeking::{Fitted, FittedFormula, Seeking};
use crate::diagnose::residuals::effect_size::MATTERS;
use crate::diagnose::residuals::noise_level::NoiseLevel;
use crate::diagnose::selection::hypothesis_test::HypothesisTest;
use crate::estimate::covariance::of_unknowns;
use crate::estimate::fit::outcome_with;
use crate::outcome::parameter::Parameter;
use crate::recording::split::Split;
use crate::stats::deviation::rms;
use crate::stats::encompassing::{Encompassing, Known, ResidualPair};

/// What formulas are sought for.
pub struct Proposing<'a> {
    /// In a context whose held-out rows no choice has seen.
    pub seeking: Seeking<'a>,
    pub noise_level: &'a NoiseLevel,
    pub significance: f64,
    /// Channels without a name.
    pub channels: usize,
}

/// What else takes the misfit.
pub struct Rival {
    /// In words.
    pub name: String,
    /// What it is.
    pub kind: RivalKind,
    /// Residuals that it leaves of rows that no choice has seen, `[channel][row]`.
    pub left: Vec<Vec<f64>>,
}

impl Rival {
    /// Whether a formula that leaves so much of a channel, of an error of the model alone, takes its place.
    fn gives_way_to(&self, left: RmsErrors, evidence: &Encompassing, significance: f64) -> bool {
        match self.kind {
            RivalKind::Smooth => left.formula - left.rival <= MATTERS * left.model,
            RivalKind::Named => {
                left.formula < (1.0 - MATTERS) * left.rival && evidence.p_value < significance
            }
        }
    }
}

/// RMS errors of a channel: of the model alone, with a rival, and with a formula.
struct RmsErrors {
    model: f64,
    rival: f64,
    formula: f64,
}

/// Kinds of rivals of a formula.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RivalKind {
    /// A smooth correction.
    Smooth,
    /// Names of the vocabulary, with smooth corrections beside them.
    Named,
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
    /// It drives its joint over part of the motion, which friction does not.
    pub drives: bool,
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

/// A formula that has earned it, with its evidence.
struct Judged {
    test: HypothesisTest,
    /// Against what else takes the misfit.
    against: Option<Encompassing>,
}

impl Proposing<'_> {
    /// The foremost formula of a channel that has earned it beside what else takes the misfit.
    pub fn propose(&self, channel: usize, rival: Option<&Rival>) -> Option<Proposal> {
        let Fitted { all, tried } = self.seeking.fitted(channel)?;
        let order = self.seeking.in_order(channel, &all);
        let mut judged = order.into_iter().enumerate().map(|(before, k)| {
            let judged = self.judged(channel, &all[k], before + 1, rival);
            judged.map(|judged| (k, judged))
        });
        let (chosen, Judged { test, against }) = judged.find_map(|judged| judged)?;
        let before = self.seeking.model;
        let explains = |fit: &ModelFit| self.explained(before, fit, channel);
        let others = (0..all.len()).filter(|k| *k != chosen).map(|k| Other {
            formula: all[k].formula(),
            explains: explains(&all[k].fit),
        });
        let others = others.filter(|other| other.explains >= MATTERS);
        Some(Proposal {
            others: others.collect(),
            formula: all[chosen].formula(),
            parameters: self.parameters(&all[chosen]),
            rmse: rms(&test.fit.validation[channel]),
            explains: explains(&test.fit),
            against,
            test,
            drives: all[chosen].drives,
            tried,
        })
    }

    /// The test of a formula, one of so many of each channel, if it has earned it.
    fn judged(
        &self,
        channel: usize,
        formula: &FittedFormula,
        tests: usize,
        rival: Option<&Rival>,
    ) -> Option<Judged> {
        let (rows, before) = (self.seeking.context, self.seeking.model);
        let FittedFormula {
            hypothesis, fit, ..
        } = formula;
        let test = HypothesisTest::of(rows, before, fit.clone(), hypothesis.clone());
        let test = test.corrected_for(tests * self.channels);
        if !test.is_needed(self.significance) {
            return None;
        }
        let left = &test.fit.validation;
        let against = rival.map(|rival| {
            let pair = ResidualPair {
                poorer: &rival.left,
                richer: left,
            };
            pair.encompassing(Known::default(), rows.residual_rows())
        });
        let gives_way = rival.zip(against.as_ref()).is_none_or(|(rival, against)| {
            let left = RmsErrors {
                model: rms(&before.validation[channel]),
                rival: rms(&rival.left[channel]),
                formula: rms(&left[channel]),
            };
            rival.gives_way_to(left, against, self.significance / tests as f64)
        });
        gives_way.then_some(Judged { test, against })
    }

    /// Share of the excess over the noise that a model with a formula does not have; of all of the error where the noise is not known
    /// apart from it.
    fn explained(&self, before: &ModelFit, after: &ModelFit, channel: usize) -> f64 {
        let pair = FitPair {
            poorer: before,
            richer: after,
        };
        let ratio = rms(&after.validation[channel]) / rms(&before.validation[channel]);
        match self.noise_level.measured {
            true => self.noise_level.share(pair.held_out(), &[channel]),
            false => (1.0 - ratio * ratio).max(0.0),
        }
    }

    /// The parameters of a formula with their intervals.
    fn parameters(&self, fitted: &FittedFormula) -> Vec<Parameter> {
        let context = self.seeking.context;
        let recordings = context.recordings(Split::Train);
        let problem = fitted.fit.problem(&recordings);
        let covariance = of_unknowns(&problem, &fitted.fit.solution.x);
        let all = outcome_with(&problem, &fitted.fit.solution, covariance, context.data)
            .estimate
            .parameters;
        let prefix = fitted.formula().full_name("");
        all.into_iter()
            .filter(|parameter| parameter.name.starts_with(&prefix))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the formula takes the place of a rival that leaves 0.2 where the model alone leaves 1.
    fn takes_its_place(kind: RivalKind, formula: f64, p_value: f64) -> bool {
        let rival = Rival {
            name: String::new(),
            kind,
            left: Vec::new(),
        };
        let left = RmsErrors {
            model: 1.0,
            rival: 0.2,
            formula,
        };
        let evidence = Encompassing {
            p_value,
            ..Encompassing::of_nothing()
        };
        rival.gives_way_to(left, &evidence, 0.001)
    }

    /// Two hundredths of the rival's error are less than what matters of the model's.
    #[test]
    fn a_formula_may_leave_a_little_more_than_a_smooth_correction_and_less_than_a_name() {
        let of_smooth = |formula| takes_its_place(RivalKind::Smooth, formula, 1.0);
        assert!(of_smooth(0.2 + 0.99 * MATTERS) && !of_smooth(0.2 + 1.01 * MATTERS));
        let of_named = |formula, p_value| takes_its_place(RivalKind::Named, formula, p_value);
        let (just, hardly) = (0.2 * (1.0 - 1.01 * MATTERS), 0.2 * (1.0 - 0.99 * MATTERS));
        assert!(of_named(just, 0.0009) && !of_named(just, 0.0011) && !of_named(hardly, 0.0009));
    }
}
