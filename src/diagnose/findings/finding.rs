//! Findings of the vocabulary: what each explains, how probable it is, and what else could be there.

use crate::chain::effect::Law;
use crate::diagnose::conclusion::explanation::Explanation;
use crate::diagnose::findings::probability::{Alternatives, Probabilities};
use crate::diagnose::findings::sentences;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::contexts::Contexts;
use crate::diagnose::fit::hypothesis::{Hypothesis, channels_of, joint_names};
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::noise_level::{NoiseLevel, chance};
use crate::diagnose::residuals::reversal_mask;
use crate::diagnose::selection::hypothesis_test::HypothesisTest;
use crate::diagnose::selection::rival_models::TestedRivals;
use crate::diagnose::selection::stepwise::SelectionStep;
use crate::outcome::diagnose::Evidence;
use crate::outcome::finding::{Finding, Rival};
use crate::outcome::parameter::Parameter;
use crate::stats::deviation::rms;

/// Share of what a finding explains that other physics has to explain to be its rival.
const RIVALLING: f64 = 0.5;

/// A step of the explanation on rows that no choice has seen: the model before, the model with one finding more, and the
/// test of that finding.
pub struct ConfirmedStep<'a> {
    /// Without the finding.
    pub before: ModelFit,
    /// With it.
    pub after: ModelFit,
    /// Whether the richer forecasts what the poorer leaves.
    pub test: &'a HypothesisTest,
    /// What could stand in its place.
    pub comparison: &'a TestedRivals,
    /// Of the finding and of each alternative of the comparison.
    pub probabilities: Probabilities,
}

impl<'a> ConfirmedStep<'a> {
    /// The steps of an explanation, with the comparisons of its findings on the same rows.
    pub fn all(
        explanation: &'a Explanation,
        contexts: &Contexts<'_>,
        comparisons: &'a [TestedRivals],
        noise_level: &NoiseLevel,
    ) -> Vec<Self> {
        let step = |k: usize| {
            let (test, comparison) = (&explanation.tests[k], &comparisons[k]);
            let rows = contexts.testing(&test.hypothesis);
            Self {
                before: explanation.prefixes[k].on(rows),
                after: explanation.prefixes[k + 1].on(rows),
                test,
                comparison,
                probabilities: probabilities(rows, test, comparison, noise_level),
            }
        };
        (0..explanation.full.hypotheses.len()).map(step).collect()
    }
}

/// Probabilities of a finding and of what may be there in its place; `rows` are those of its test, and so is the
/// comparison.
fn probabilities(
    rows: &Context<'_>,
    test: &HypothesisTest,
    comparison: &TestedRivals,
    noise_level: &NoiseLevel,
) -> Probabilities {
    let found = &test.fit.validation;
    let rivals = comparison.rivals.iter();
    let channels = channels_of(&test.fit.model, &test.hypothesis.named_joints());
    // At reversals every model leaves more than noise.
    let kept = |c: usize| reversal_mask::residual(rows, &test.fit, c, &found[c]);
    let left = channels
        .into_iter()
        .filter(|_| noise_level.measured)
        .filter_map(|c| chance(&kept(c), noise_level.rms[c]))
        .fold(1.0, f64::min);
    Alternatives {
        rivals: rivals
            .map(|a| a.separation.log_likelihood_ratio())
            .collect(),
        nothing: test.evidence,
        left,
    }
    .probabilities()
}

/// Findings of the vocabulary in the order found.
pub fn findings(
    steps: &[ConfirmedStep<'_>],
    noise_level: &NoiseLevel,
    parameters: &[Parameter],
) -> Vec<Finding> {
    let of = |step: &ConfirmedStep<'_>| finding(step, noise_level, parameters);
    steps.iter().map(of).collect()
}

fn finding(
    step: &ConfirmedStep<'_>,
    noise_level: &NoiseLevel,
    parameters: &[Parameter],
) -> Finding {
    let hypothesis = &step.test.hypothesis;
    let model = &step.after.model;
    let joints = hypothesis.named_joints();
    let names = joint_names(model, &joints);
    let own: Vec<Parameter> = parameters
        .iter()
        .filter(|p| step.before.model.position(&p.name).is_none() && belongs(p, hypothesis, &names))
        .cloned()
        .collect();
    let channels = channels_of(model, &joints);
    let pooled = |e: &[Vec<f64>]| {
        let squares: f64 = channels.iter().map(|&c| rms(&e[c]).powi(2)).sum();
        (squares / channels.len().max(1) as f64).sqrt()
    };
    let pair = FitPair {
        poorer: &step.before,
        richer: &step.after,
    };
    let before = pooled(&step.before.validation);
    let after = pooled(&step.after.validation);
    let unit = channels.first().map_or("", |&c| model.channels()[c].unit);
    Finding {
        effect: hypothesis.effect.id.to_string(),
        rmse_validation_before: before,
        rmse_validation_after: after,
        explained_share: noise_level.share(pair.held_out(), &channels),
        p_value: step.test.p_value,
        sentence: format!(
            "{}; {}.",
            sentences::sentence(hypothesis, model, &own),
            sentences::improvement(before, after, unit)
        ),
        parameters: own,
        joints: names,
        rivals: rivals(step, noise_level, &channels),
        probability: step.probabilities.finding,
        probability_unnamed: step.probabilities.unnamed,
        probability_nothing: step.probabilities.nothing,
        formula: None,
    }
}

fn belongs(parameter: &Parameter, hypothesis: &Hypothesis, joints: &[String]) -> bool {
    let effect = hypothesis.effect.id;
    let of_joint = |joint: &String| parameter.name.starts_with(&format!("{joint}.{effect}."));
    let own = joints.iter().any(of_joint);
    let shared = parameter.name.starts_with(&format!("{effect}."));
    let is_load = matches!(hypothesis.effect.law, Law::Body);
    own || shared || (is_load && parameter.name.starts_with("payload."))
}

fn rivals(step: &ConfirmedStep<'_>, noise_level: &NoiseLevel, channels: &[usize]) -> Vec<Rival> {
    let comparison = step.comparison;
    let share = |fit: &ModelFit| {
        let pair = FitPair {
            poorer: &comparison.without,
            richer: fit,
        };
        noise_level.share(pair.held_out(), channels)
    };
    let mut rivals: Vec<Rival> = comparison
        .rivals
        .iter()
        .zip(&step.probabilities.rivals)
        .map(|(alternative, &probability)| {
            let fit = &alternative.test.fit;
            let hypothesis = &alternative.test.hypothesis;
            let separation = alternative.separation;
            Rival {
                effect: hypothesis.effect.id.to_string(),
                joints: joint_names(&fit.model, &hypothesis.named_joints()),
                explained_share: share(fit),
                separable: separation.separable,
                probability,
                times_longer: separation.times_longer.filter(|_| !separation.separable),
            }
        })
        .collect();
    let most = rivals.iter().map(|r| r.explained_share).fold(0.0, f64::max);
    rivals.retain(|r| !r.separable || r.explained_share >= RIVALLING * most && most > 0.0);
    rivals.sort_by(|a, b| {
        let by_share = b.explained_share.total_cmp(&a.explained_share);
        a.separable.cmp(&b.separable).then(by_share)
    });
    rivals
}

/// Every hypothesis that was fitted while the model grew, for the table of evidence.
pub fn tried_hypotheses(steps: &[SelectionStep]) -> Vec<Evidence> {
    let mut evidence = Vec::new();
    for step in steps {
        for (k, test) in step.tests.iter().enumerate() {
            let hypotheses = &test.fit.hypotheses;
            evidence.push(Evidence {
                step: hypotheses.len().saturating_sub(1),
                effect: test.hypothesis.effect.id.to_string(),
                joints: joint_names(&test.fit.model, &test.hypothesis.named_joints()),
                slope: test.evidence.slope,
                p_value: test.p_value,
                relief: test.error_reduction,
                score: test.fit.held_out_score() - step.score,
                accepted: step.accepted && k == 0,
            });
        }
    }
    evidence
}
