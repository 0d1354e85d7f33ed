//! From a grown model to what is reported: findings, what they explain, what is left, the verdict.

use crate::chain::model::Model;
use crate::diagnose::bench::Bench;
use crate::diagnose::evidence::block_length;
use crate::diagnose::explain;
use crate::diagnose::floor::{Floor, LEAST_EXCESS, UNEXPLAINED, of_steps};
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::probability::{self, Probabilities};
use crate::diagnose::refit::Refit;
use crate::diagnose::relief::{MATTERS, OF_NOISE, OF_TORQUE};
use crate::diagnose::rivals::Contest;
use crate::diagnose::rows::rms;
use crate::diagnose::search::{Step as SearchStep, Trial};
use crate::diagnose::smooth::Smooth;
use crate::diagnose::summary;
use crate::diagnose::uncertainty::Uncertainty;
use crate::diagnose::underway;
use crate::outcome::diagnose::{Evidence, Finding, Rival, Spoiled, Unattested, Verdict};
use crate::outcome::parameter::Parameter;
use crate::recording::split::Split;
use crate::stats::distribution::Distribution;

/// Share of the excess that findings explain where they explain the misfit.
const MOSTLY: f64 = 0.9;

/// Share of the excess that findings explain where they explain part of it.
const PARTLY: f64 = 0.5;

/// A residual below this share of the RMS signal is of no weight: rows are some hundredths of a second apart, and at
/// every reversal dry friction, a tenth of the usual torque or more, turns over between two of them.
const OF_SIGNAL: f64 = 0.03;

/// Residuals are looked at in all rows and in those under way, where reversals are no excuse.
const VIEWS: usize = 2;

/// Share of what a finding explains that other physics has to explain to be its rival.
const RIVALLING: f64 = 0.5;

/// A step of the explanation on rows that no choice has seen: the model before, the model with one finding more, and the
/// test of that finding.
pub struct Step<'a> {
    pub before: Refit,
    pub after: Refit,
    pub test: &'a Trial,
    pub contest: &'a Contest,
    /// Of the finding and of each alternative of the contest.
    pub probabilities: Probabilities,
}

/// Findings of the vocabulary in the order found.
pub fn findings(steps: &[Step<'_>], floor: &Floor, parameters: &[Parameter]) -> Vec<Finding> {
    let of = |step: &Step<'_>| finding(step, floor, parameters);
    steps.iter().map(of).collect()
}

fn finding(step: &Step<'_>, floor: &Floor, parameters: &[Parameter]) -> Finding {
    let hypothesis = &step.test.hypothesis;
    let model = &step.after.model;
    let joints = hypothesis.named_joints();
    let names = joint_names(model, &joints);
    let own: Vec<Parameter> = parameters
        .iter()
        .filter(|p| step.before.model.find(&p.name).is_err() && belongs(p, hypothesis, &names))
        .cloned()
        .collect();
    let channels = channels_of(model, &joints);
    let pooled = |e: &[Vec<f64>]| {
        let squares: f64 = channels.iter().map(|&c| rms(&e[c]).powi(2)).sum();
        (squares / channels.len().max(1) as f64).sqrt()
    };
    let (before, after) = (
        pooled(&step.before.validation),
        pooled(&step.after.validation),
    );
    let unit = channels.first().map_or("", |&c| model.channels()[c].unit);
    Finding {
        effect: hypothesis.effect.id.to_string(),
        rmse_validation_before: before,
        rmse_validation_after: after,
        explained_share: floor.share((&step.before.validation, &step.after.validation), &channels),
        p_value: step.test.p_value,
        sentence: format!(
            "{}; {}.",
            explain::sentence(hypothesis, &names, &own),
            explain::improvement(before, after, unit)
        ),
        parameters: own,
        joints: names,
        rivals: rivals(step, floor, &channels),
        probability: step.probabilities.finding,
        probability_unnamed: step.probabilities.unnamed,
        probability_nothing: step.probabilities.nothing,
    }
}

fn belongs(parameter: &Parameter, hypothesis: &Hypothesis, joints: &[String]) -> bool {
    let effect = hypothesis.effect.id;
    let of_joint = |joint: &String| parameter.name.starts_with(&format!("{joint}.{effect}."));
    let own = joints.iter().any(of_joint);
    let shared = parameter.name.starts_with(&format!("{effect}."));
    own || shared || (effect == "unmodelled_payload" && parameter.name.starts_with("payload."))
}

fn rivals(step: &Step<'_>, floor: &Floor, channels: &[usize]) -> Vec<Rival> {
    let contest = step.contest;
    let share =
        |refit: &Refit| floor.share((&contest.without.validation, &refit.validation), channels);
    let mut rivals: Vec<Rival> = contest
        .alternatives
        .iter()
        .zip(&step.probabilities.rivals)
        .map(|(alternative, &probability)| {
            let refit = &alternative.trial.refit;
            let hypothesis = &alternative.trial.hypothesis;
            let separation = alternative.separation;
            Rival {
                effect: hypothesis.effect.id.to_string(),
                joints: joint_names(&refit.model, &hypothesis.named_joints()),
                explained_share: share(refit),
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

/// Why a finding has no name.
fn nameless(cut_short: bool) -> &'static str {
    match cut_short {
        false => "no effect of the vocabulary explains",
        true => "had no name yet when the search was interrupted",
    }
}

/// The finding of what no effect of the vocabulary explains.
pub fn unnamed(
    smooth: &Smooth,
    refit: &Refit,
    floor: &Floor,
    tested: usize,
    cut_short: bool,
) -> Finding {
    let c = smooth.channel;
    let channel = &refit.model.channels()[c];
    let left: Vec<f64> = refit.validation[c]
        .iter()
        .zip(&smooth.validation)
        .map(|(e, f)| e - f)
        .collect();
    let (before, after) = (rms(&refit.validation[c]), rms(&left));
    let odds = probability::of_unnamed(&smooth.evidence);
    let mut residuals = refit.validation.clone();
    residuals[c] = left;
    Finding {
        effect: "unnamed".to_string(),
        joints: vec![channel.name.clone()],
        parameters: Vec::new(),
        rmse_validation_before: before,
        rmse_validation_after: after,
        explained_share: floor.share((&refit.validation, &residuals), &[c]),
        p_value: (smooth.evidence.p_value * tested as f64).min(1.0),
        sentence: format!(
            "Something is missing on {} that {}; a smooth correction over {} takes its place, and {}.",
            channel.name,
            nameless(cut_short),
            smooth.over.join(", "),
            explain::improvement(before, after, channel.unit)
        ),
        rivals: Vec::new(),
        probability: odds.finding,
        probability_unnamed: odds.finding,
        probability_nothing: odds.nothing,
    }
}

/// Findings of channels without one whose held-out residual is much larger than noise, and larger than chance would
/// have it, and not mostly explained by what is found elsewhere: not even where the misfit lies says what it is. What
/// uncertain parameters add to a prediction is as attested as noise. Where a name was withdrawn there is a misfit of
/// weight. Where nothing attests the noise it is at most what is left of the rows that were fitted.
pub fn unexplained(
    bench: &Bench<'_>,
    ([declared, refit], floor, significance): ([&Refit; 2], &Floor, f64),
    predicted: &Uncertainty,
    (findings, withdrawn, cut_short): (&[Finding], &[usize], bool),
) -> Vec<Finding> {
    let signal = bench.signal_rms(Split::Validation);
    let channels = refit.model.channels().iter().enumerate();
    let open = channels.filter_map(|(c, channel)| {
        let joint = channel.joint.filter(|_| channel.active)?;
        Some((c, &channel.name, joint))
    });
    let tried = (VIEWS * open.clone().count()) as f64;
    let found = |name: &String| findings.iter().any(|f| f.joints.contains(name));
    let is_left = |c: usize| floor.share((&declared.validation, &refit.validation), &[c]) < MOSTLY;
    open.filter(|(c, name, _)| !found(name) && is_left(*c))
        .filter_map(|(c, name, joint)| {
            let residual = &refit.validation[c];
            let least = match withdrawn.contains(&joint) {
                true => 0.0,
                false => OF_SIGNAL,
            };
            let (noise, than) = match floor.measured {
                true => (floor.rms[c], "the noise"),
                false => (rms(&refit.train[c]), "that on those that were"),
            };
            let attested = predicted.beside(c, noise);
            let under_way = underway::residual(bench, refit, c, residual);
            let views: [(&[f64], f64); VIEWS] = [(residual, least), (&under_way, OF_TORQUE)];
            let of_weight = views
                .into_iter()
                .filter(|(rows, least)| rms(rows) > least * signal[c]);
            let chances = of_weight.filter_map(|(rows, _)| chance(rows, attested));
            let p_value = (chances.reduce(f64::min)? * tried).min(1.0);
            (p_value < significance).then(|| Finding {
                effect: "unnamed".to_string(),
                joints: vec![name.clone()],
                parameters: Vec::new(),
                rmse_validation_before: rms(residual),
                rmse_validation_after: rms(residual),
                explained_share: 0.0,
                p_value,
                sentence: format!(
                    "Something is missing on {name} that {}, and no smooth correction takes its place: the error on \
                     recordings that were not fitted is {:.1} times {than}.",
                    nameless(cut_short),
                    rms(residual) / noise
                ),
                rivals: Vec::new(),
                probability: 1.0 - p_value,
                probability_unnamed: 1.0 - p_value,
                probability_nothing: p_value,
            })
        })
        .collect()
}

/// Probability that noise alone leaves as much in some rows, where that is beyond [`UNEXPLAINED`].
pub fn chance(residual: &[f64], noise: f64) -> Option<f64> {
    let lack = (rms(residual) / noise).powi(2);
    let effective = residual.len() as f64 / block_length(&[residual.to_vec()]) as f64;
    let spread = Distribution::FisherF {
        numerator: effective,
        denominator: effective,
    };
    (lack > UNEXPLAINED).then(|| spread.upper_tail(lack))
}

/// Channels of which the residual is of weight, more than 3 % of the signal, and more than [`UNEXPLAINED`] times the variance of
/// the noise that is known apart from the misfit: by the scatter of periods, by what no motion reaches in the signal, or by
/// what successive rows of the residual differ, in which a misfit that follows the motion has no part. Slow noise is not
/// told from misfit, and what uncertain parameters add to a prediction is added to it. The final model, with smooth
/// corrections.
pub fn unattested(
    bench: &Bench<'_>,
    full: &Refit,
    smooths: &[&Smooth],
    floor: &Floor,
    predicted: &Uncertainty,
) -> Vec<Unattested> {
    let (model, left) = (&full.model, summary::left(full, smooths));
    let signal = bench.signal_rms(Split::Validation);
    let channels = model.channels().iter().enumerate();
    let active = channels.filter(|(_, channel)| channel.active);
    let open = active.filter_map(|(c, channel)| {
        let noise = match floor.measured {
            true => floor.rms[c],
            false => {
                let of_signal = bench.noise.as_ref().map_or(0.0, |noise| noise[c]);
                of_steps(&left[c], 1).sqrt().max(of_signal)
            }
        };
        let residual = rms(&left[c]);
        let attested = predicted.beside(c, noise);
        let excess = residual > UNEXPLAINED.sqrt() * attested;
        let of_signal = residual / signal[c];
        (excess && of_signal > OF_SIGNAL).then(|| Unattested {
            joint: channel.name.clone(),
            unit: channel.unit.to_string(),
            rmse_validation: residual,
            of_signal,
            sentence: explain::unattested(&channel.name, residual, channel.unit, of_signal),
        })
    });
    open.collect()
}

/// Whether a smooth model says something that is significant and matters.
pub fn is_needed(smooth: &Smooth, (significance, tried): (f64, usize)) -> bool {
    let tried = (tried * smooth.tried) as f64;
    smooth.evidence.p_value * tried < significance
        && smooth.relief >= MATTERS
        && smooth.taken >= OF_NOISE
}

/// Lack of fit of the declared and of the final model, pooled over the joints that findings name.
#[derive(Debug, Clone, Copy)]
pub struct LackOfFit {
    pub before: f64,
    pub after: f64,
}

/// The verdict from the lack of fit of the joints that findings name, before and after, from what is left without a name,
/// and from whether what is left is known to be noise.
pub fn verdict(findings: &[Finding], lack: LackOfFit, unattested: &[Unattested]) -> Verdict {
    let LackOfFit { before, after } = lack;
    let named = findings.iter().filter(|f| f.effect != "unnamed").count();
    if named == 0 {
        return match findings.is_empty() && unattested.is_empty() {
            true => Verdict::NothingMissing,
            false => Verdict::Unexplained,
        };
    }
    let share = (before - after) / (before - 1.0).max(LEAST_EXCESS);
    let all_named = named == findings.len() && unattested.is_empty();
    if all_named && (share >= MOSTLY || after - 1.0 <= LEAST_EXCESS) {
        Verdict::Explained
    } else if share >= PARTLY {
        Verdict::PartlyExplained
    } else {
        Verdict::Unexplained
    }
}

/// Parameters that both models determine and that moved by more than their uncertainty.
pub fn spoiled(before: &[Parameter], after: &[Parameter]) -> Vec<Spoiled> {
    /// Standard deviations of the later estimate beyond which a change is one.
    const MOVED: f64 = 3.0;
    let mut spoiled: Vec<(f64, Spoiled)> = after
        .iter()
        .filter_map(|new| {
            let old = before.iter().find(|p| p.name == new.name)?;
            let (from, to, deviation) = (old.value?, new.value?, new.std_dev?);
            let moved = (to - from).abs() / deviation;
            let entry = Spoiled {
                name: new.name.clone(),
                unit: new.unit.clone(),
                before: from,
                after: to,
                std_dev: deviation,
            };
            (moved > MOVED).then_some((moved, entry))
        })
        .collect();
    spoiled.sort_by(|a, b| b.0.total_cmp(&a.0));
    spoiled.into_iter().map(|(_, entry)| entry).collect()
}

pub fn joint_names(model: &Model, joints: &[usize]) -> Vec<String> {
    joints
        .iter()
        .map(|&j| model.joints()[j].name.clone())
        .collect()
}

/// Channels of joints; all channels where the signal is the wrench of the base.
pub fn channels_of(model: &Model, joints: &[usize]) -> Vec<usize> {
    let channels = model.channels().iter().enumerate();
    let of = |c: &crate::chain::model::Channel| c.joint.is_none_or(|j| joints.contains(&j));
    channels
        .filter(|(_, c)| c.active && of(c))
        .map(|(k, _)| k)
        .collect()
}

/// What was tried, for the table of evidence.
pub fn evidence(steps: &[SearchStep]) -> Vec<Evidence> {
    let mut evidence = Vec::new();
    for step in steps {
        for (k, trial) in step.trials.iter().enumerate() {
            let hypotheses = &trial.refit.hypotheses;
            evidence.push(Evidence {
                step: hypotheses.len().saturating_sub(1),
                effect: trial.hypothesis.effect.id.to_string(),
                joints: joint_names(&trial.refit.model, &trial.hypothesis.named_joints()),
                slope: trial.evidence.slope,
                p_value: trial.p_value,
                relief: trial.relief,
                score: trial.refit.held_out_score() - step.score,
                accepted: step.accepted && k == 0,
            });
        }
    }
    evidence
}
