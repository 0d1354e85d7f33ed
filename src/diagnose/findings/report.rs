//! The report of a search: findings, verdict, figures of the declared and of the final model.

use crate::chain::model::Model;
use crate::diagnose::conclusion::explanation::Explanation;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::findings::compared::Compared;
use crate::diagnose::findings::corrections::Corrections;
use crate::diagnose::findings::finding::{self, ConfirmedStep};
use crate::diagnose::findings::formulas::{FormulaModel, Formulas};
use crate::diagnose::findings::next_experiment::Discrimination;
use crate::diagnose::findings::summary::{self, About};
use crate::diagnose::findings::unexplained::SearchState;
use crate::diagnose::findings::verdict;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::contexts::Contexts;
use crate::diagnose::fit::fitting::fit_declared;
use crate::diagnose::fit::hypothesis::{Hypothesis, joint_names};
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::additive_model::AdditiveModel;
use crate::diagnose::residuals::location;
use crate::diagnose::residuals::noise_level::{self, NoiseLevel};
use crate::diagnose::residuals::prediction_error::PredictionError;
use crate::diagnose::selection::rival_models::{Ambiguity, TestedRivals, ambiguities};
use crate::diagnose::selection::stepwise::Rules;
use crate::estimate::covariance::of_unknowns;
use crate::estimate::fit::{Fitted, in_full, outcome, outcome_with};
use crate::estimate::goodness_of_fit::{Predictions, predictions};
use crate::estimate::remarks::{notes, preprocessing};
use crate::outcome::diagnose::{Baseline, Diagnosis, Final};
use crate::outcome::finding::Finding;
use crate::outcome::fit::{AddedEffect, Fit, FittedModel};
use crate::outcome::parameter::Parameter;
use crate::recording::split::Split;

const UNMEASURED: &str = "Nothing repeats, so the noise is not known apart from the misfit: shares are of what the \
                          best model found takes away, and what it leaves counts as noise.";

/// What is said of a model that a search has come to.
pub struct Reported {
    /// The part of `diagnose` of a result.
    pub diagnosis: Diagnosis,
    /// The final model as a fit gives it.
    pub fitted: Fitted,
    /// Predictions of the declared model.
    pub declared: Predictions,
    /// Predictions of the final model, with its corrections.
    pub last: Predictions,
    /// Findings with rivals that the recordings cannot set aside.
    pub ambiguities: Vec<Ambiguity>,
    /// What the final model has beside the declared one.
    pub hypotheses: Vec<Hypothesis>,
    /// What takes the place of what has no name.
    pub nameless: Nameless,
    /// Models that the recordings do not tell apart.
    pub rivals: Option<Discrimination>,
}

/// A final model, and what takes the place of what has no name in it.
#[derive(Debug, Clone)]
pub struct Nameless {
    /// The final model.
    pub full: ModelFit,
    /// Smooth corrections of what it leaves.
    pub corrections: Vec<AdditiveModel>,
    /// Models with the formulas that are proposed.
    pub formulas: Vec<FormulaModel>,
}

impl Nameless {
    /// Numbers of the hypotheses of the final model in whose place formulas leave less, in order.
    pub fn outdone(&self) -> Vec<usize> {
        let of = |formula: &FormulaModel| formula.instead_of.clone();
        let mut outdone: Vec<usize> = self.formulas.iter().flat_map(of).collect();
        outdone.sort_unstable();
        outdone
    }
}

/// What a report is made of.
pub struct Reporting<'a> {
    /// The held-out rows that choose, those that test, and both.
    pub contexts: &'a Contexts<'a>,
    /// What the search has selected.
    pub explanation: &'a Explanation,
    /// What was sought, and how sure a finding has to be.
    pub rules: Rules<'a>,
}

impl Reporting<'_> {
    /// Fits declared and final model to their ends and says how they differ.
    ///
    /// # Errors
    /// A model that cannot be fitted over all rows.
    pub fn report(&self) -> Result<Reported, DiagnoseError> {
        let (context, explanation) = (&self.contexts.whole, self.explanation);
        let full = &explanation.full.on(context);
        // The search may have found a better fit of the declared model than its first one.
        let declared = &fit_declared(&self.contexts.selection)?.on(context);
        let recordings = context.recordings(Split::Train);
        let of_declared = declared.problem(&recordings);
        let mut before = outcome(&of_declared, &declared.solution, context.data);
        let of_full = full.problem(&recordings);
        let covariance = of_unknowns(&of_full, &full.solution.x);
        let predicted = PredictionError::of(context, full, covariance.as_ref());
        let mut after = outcome_with(&of_full, &full.solution, covariance, context.data);
        let confirmed = Corrections::of(self.contexts, &explanation.full, self.rules);
        let smooth: Vec<AdditiveModel> = confirmed.over_all_rows(self.contexts, full);
        let corrections: Vec<&AdditiveModel> = smooth.iter().collect();
        let noise_level = noise_level::of_rows(context, full, &corrections);
        let parameters = after.estimate.parameters.clone();
        let compared = Compared {
            context,
            declared,
            full,
            noise_level: &noise_level,
            predicted: &predicted,
        };
        let comparisons = self.comparisons(&compared);
        let mut findings = self.findings(&compared, &comparisons, &confirmed, &parameters);
        let unattested = compared.unattested(&corrections, explanation, self.rules);
        let mut proposed = Vec::new();
        if !self.is_cut_short() {
            let formulas = Formulas {
                contexts: self.contexts,
                full: &explanation.full,
                corrections: &confirmed,
                noise_level: &noise_level,
                significance: self.rules.significance,
            };
            proposed = formulas.propose(&mut findings, &unattested)?;
        }
        let last = summary::correct(context, full, &mut after, &corrections);
        judged_in_time(context, &noise_level, [&mut before, &mut after]);
        let verdict = (!self.is_cut_short())
            .then(|| verdict::verdict(&findings, compared.lack_of_fit(&findings), &unattested));
        let about = About {
            examined: explanation.examined,
            unattested: &unattested,
            joints: &after.estimate.joints,
            untried: self.untried(),
        };
        let unmeasured = (!noise_level.measured).then(|| UNMEASURED.to_string());
        let diagnosis = Diagnosis {
            verdict,
            summary: summary::paragraph(verdict, &findings, &about),
            located: location::locate(context, declared, self.rules.significance),
            findings,
            unattested,
            spoiled: verdict::biased(&before.estimate.parameters, &parameters),
            baseline: Baseline {
                joints: before.estimate.joints,
                model: Some(in_full(&before.model, &before.values)),
            },
            outcome: Final {
                joints: after.estimate.joints.clone(),
                parameters,
            },
            next_experiment: None,
            rollout: None,
            preprocessing: preprocessing(&after.model, context.data),
            notes: notes(&after.model, context.data)
                .into_iter()
                .chain(unmeasured)
                .collect(),
            fit: Some(Fit {
                model: Some(FittedModel {
                    added: full
                        .hypotheses
                        .iter()
                        .map(|h| added(&full.model, h))
                        .collect(),
                    ..in_full(&full.model, &full.values)
                }),
                ..after.fit.clone()
            }),
            evidence: finding::tried_hypotheses(&explanation.tried),
            simulator: None,
        };
        Ok(Reported {
            diagnosis,
            fitted: after,
            declared: predictions(&declared.model, &declared.values, context.data),
            last,
            ambiguities: ambiguities(full, &comparisons),
            hypotheses: full.hypotheses.clone(),
            rivals: Discrimination::of(context, full, &comparisons),
            nameless: Nameless {
                full: full.clone(),
                corrections: smooth,
                formulas: proposed,
            },
        })
    }

    fn is_cut_short(&self) -> bool {
        self.contexts.whole.control.is_interrupted()
    }

    /// Rivals of the findings as the rows show them that test these.
    fn comparisons(&self, compared: &Compared<'_>) -> Vec<TestedRivals> {
        let (full, noise_level) = (compared.full, compared.noise_level);
        let comparisons = self.explanation.comparisons.iter();
        let seen = comparisons.zip(&full.hypotheses);
        seen.map(|(comparison, own)| comparison.on(self.contexts, noise_level, full, own))
            .collect()
    }

    /// What has a name, what a smooth correction takes the place of, and what is left.
    fn findings(
        &self,
        compared: &Compared<'_>,
        comparisons: &[TestedRivals],
        corrections: &Corrections,
        parameters: &[Parameter],
    ) -> Vec<Finding> {
        let noise_level = compared.noise_level;
        let state = SearchState {
            significance: self.rules.significance,
            withdrawn: &self.explanation.withdrawn,
            is_cut_short: self.is_cut_short(),
        };
        let steps = ConfirmedStep::all(self.explanation, self.contexts, comparisons, noise_level);
        let mut findings = finding::findings(&steps, noise_level, parameters);
        findings.extend(corrections.findings(noise_level, state));
        findings.extend(compared.unexplained(&findings, state));
        findings
    }

    /// Effects of which a search that was interrupted has not fitted every hypothesis beside the model that it had come
    /// to.
    fn untried(&self) -> Vec<String> {
        let (context, explanation) = (&self.contexts.selection, self.explanation);
        let last = explanation.tried.last().filter(|step| step.is_complete);
        let fitted =
            |h: &Hypothesis| last.is_some_and(|s| s.tests.iter().any(|t| t.hypothesis == *h));
        let open = self.rules.open(context, &explanation.full);
        let left = open.iter().filter(|h| !fitted(h)).map(|h| h.effect.id);
        let mut left: Vec<String> = left.map(str::to_string).collect();
        left.dedup();
        left
    }
}

/// A hypothesis as a result keeps it.
fn added(model: &Model, hypothesis: &Hypothesis) -> AddedEffect {
    let other = hypothesis
        .other
        .map(|other| model.joints()[other].name.clone());
    AddedEffect {
        effect: hypothesis.effect.id.to_string(),
        joints: joint_names(model, &hypothesis.joints),
        other,
    }
}

/// Between periods there is also what the findings say changes from one to the next.
fn judged_in_time(context: &Context<'_>, noise_level: &NoiseLevel, fitted: [&mut Fitted; 2]) {
    if context.in_time && noise_level.measured {
        for fitted in fitted {
            noise_level.judge(&fitted.model, &mut fitted.estimate.joints);
        }
    }
}
