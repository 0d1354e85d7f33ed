//! Grows the model one hypothesis at a time, then drops each on trial.

use crate::chain::effect::{Lasts, Law, Linearity};
use crate::chain::parameter::Role;
use crate::diagnose::bench::Bench;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::evidence::{Evidence, of_own_parameters};
use crate::diagnose::forecast::{forecast, under_way};
use crate::diagnose::hypothesis::{self, Hypothesis};
use crate::diagnose::lead::Lead;
use crate::diagnose::passing;
use crate::diagnose::refit::{Refit, Start, refit, refit_holding};
use crate::diagnose::relief::{HALF_OF_WHAT_MATTERS, MATTERS, excess, relief};
use crate::diagnose::reuse::Reusable;
use crate::diagnose::rows::rms;
use crate::diagnose::screen::screen;
use crate::diagnose::speeds;
use crate::stats::distribution::Distribution;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::HashMap;

/// What a search looks for and how sure it has to be.
#[derive(Debug, Clone, Copy)]
pub struct Rules<'a> {
    /// Effects to look for; all if `None`.
    pub sought: Option<&'a [String]>,
    /// Probability of a false finding after correction.
    pub significance: f64,
}

impl Rules<'_> {
    /// The same for hypotheses that rows which no choice has seen are yet to test.
    pub fn of_choice(self) -> Self {
        Self {
            significance: self.significance.max(CHOICE),
            ..self
        }
    }
}

/// A hypothesis fitted beside what the model has already.
#[derive(Debug, Clone)]
pub struct Trial {
    pub hypothesis: Hypothesis,
    pub refit: Refit,
    /// Against the model without it.
    pub evidence: Evidence,
    /// p corrected for all hypotheses that were examined.
    pub p_value: f64,
    /// Largest share by which the held-out error of a joint falls.
    pub relief: f64,
}

impl Trial {
    /// Whether it is significant, matters, and forecasts what it was fitted to.
    fn is_needed(&self, significance: f64) -> bool {
        let forecasts = self.evidence.slope <= STEEPEST;
        self.p_value < significance && self.relief >= MATTERS && forecasts
    }
}

/// A model grown and what was tried on the way.
#[derive(Debug, Clone)]
pub struct Grown {
    pub refit: Refit,
    /// Trials of every step; the accepted one first, in all but the last.
    pub steps: Vec<Step>,
    /// Number of hypotheses of the first step.
    pub examined: usize,
}

/// What was tried beside a model.
#[derive(Debug, Clone)]
pub struct Step {
    pub trials: Vec<Trial>,
    /// Held-out score of the model as it was.
    pub score: f64,
    pub accepted: bool,
    /// Nothing interrupted it.
    pub is_complete: bool,
}

/// Hypotheses fitted exactly in one step.
const FITTED: usize = 8;

/// Hypotheses of one effect among them, where others promise something too.
const OF_ONE_EFFECT: usize = 2;

/// Effects that a model can be given; more at once were never told apart.
const MOST_FINDINGS: usize = 8;

/// The physics that a model was fitted to has a slope of 1 on other recordings; what is twice as large there is
/// something else, with which it has some shape in common.
const STEEPEST: f64 = 2.0;

/// A search that reaches less than this share of what one step of all parameters promised is made from other starts too.
const PROMISED: f64 = 0.5;

/// A parameter that is nearer to a limit than this share of it is at the limit.
const AT_LIMIT: f64 = 1e-3;

/// Times that a search begins a step again because the richer model led to a better fit of the poorer.
const SEARCHES_AGAIN: usize = 3;

/// Significance at which a search accepts a hypothesis, corrected for the number of those that are open, where other rows
/// test it afterwards: half of the rows and one test then find what all rows and hundreds of tests would.
const CHOICE: f64 = 0.05;

/// Confidence with which a model is preferred to another that has fewer parameters, and with which a rival is set
/// aside: several rivals are compared with each finding, so that each may err but once in a hundred.
pub const CONFIDENCE: f64 = 0.99;

/// Grows `baseline` until no hypothesis is significant and matters; `watch` hears of every step.
pub fn grow(
    bench: &Bench<'_>,
    baseline: Refit,
    (rules, watch): (Rules<'_>, &(dyn Fn(usize) + Sync)),
) -> Result<Grown, DiagnoseError> {
    let mut grown = Grown {
        refit: baseline,
        steps: Vec::new(),
        examined: 0,
    };
    let mut searched_again = 0;
    while grown.steps.len() < MOST_FINDINGS && !bench.control.is_interrupted() {
        watch(grown.steps.len());
        // A law that later ones have left with a bend alone is theirs.
        let bent = |h: &Hypothesis| !speeds::are_reached(bench, &grown.refit, h);
        if let Some(k) = grown.refit.hypotheses.iter().position(bent) {
            grown.refit = fit_without(bench, &grown.refit, k)?;
        }
        let open = hypothesis::open(
            (&grown.refit.model, &grown.refit.prior),
            (rules.sought, bench.in_time),
        );
        if grown.steps.is_empty() {
            grown.examined = open.len();
        }
        let earlier = grown.steps.last().map_or(&[][..], |step| &step.trials);
        let mut trials = attempt(bench, &grown.refit, rules, &open, earlier)?;
        let best = choose(bench, &trials, rules.significance);
        if let Some(best) = best {
            let richer = &trials[best].refit;
            let poorer = fit_without(bench, richer, richer.hypotheses.len() - 1)?;
            let gained = grown.refit.fitted_score() - poorer.fitted_score();
            if gained > least_gain(&grown.refit) && searched_again < SEARCHES_AGAIN {
                grown.refit = poorer;
                searched_again += 1;
                continue;
            }
        }
        let score = grown.refit.held_out_score();
        if let Some(best) = best {
            trials.swap(0, best);
            grown.refit = trials[0].refit.clone();
        }
        grown.steps.push(Step {
            trials,
            score,
            accepted: best.is_some(),
            is_complete: !bench.control.is_interrupted(),
        });
        if best.is_none() {
            break;
        }
    }
    Ok(grown)
}

/// Fits the leading hypotheses exactly beside what a model has; those that did not matter beside a poorer one do not
/// where the residuals of their joints have stayed, and are not fitted again.
pub fn attempt(
    bench: &Bench<'_>,
    refit: &Refit,
    rules: Rules<'_>,
    open: &[Hypothesis],
    earlier: &[Trial],
) -> Result<Vec<Trial>, DiagnoseError> {
    let least = least_gain(refit);
    let all = || hypothesis::open((&refit.model, &refit.prior), (rules.sought, bench.in_time));
    let find = || screen(bench, refit, all());
    let mut leads = bench.memory.screening(&refit.hypotheses, find)?.leads;
    leads.retain(|lead| lead.gain >= least && open.contains(&lead.hypothesis));
    let leads = foremost(leads);
    let reusable = Reusable::of(bench, refit);
    let is_refuted = |trial: &Trial| {
        let (others, stated) = (trial.refit.hypotheses.split_last(), &refit.hypotheses);
        let is_poorer = others.is_some_and(|(_, others)| others.iter().all(|h| stated.contains(h)));
        is_poorer && trial.relief < MATTERS && reusable.stands(&trial.hypothesis)
    };
    let refuted: Vec<&Trial> = earlier.iter().filter(|trial| is_refuted(trial)).collect();
    let tried = leads.par_iter().filter_map(|lead| {
        let known = refuted.iter().find(|t| t.hypothesis == lead.hypothesis);
        if let Some(&known) = known {
            return Some(known.clone());
        }
        // A hypothesis that cannot be fitted is no hypothesis.
        let trial = try_one(bench, (refit, open.len()), lead).ok()?;
        is_possible(bench, &trial.refit, lead).then_some(trial)
    });
    Ok(tried.collect())
}

/// The leads that are fitted: the most promising, of every effect two before a third of any.
fn foremost(leads: Vec<Lead>) -> Vec<Lead> {
    let mut taken: HashMap<&str, usize> = HashMap::new();
    let (mut first, later): (Vec<Lead>, Vec<Lead>) = leads.into_iter().partition(|lead| {
        let of_effect = taken.entry(lead.hypothesis.effect.id).or_default();
        *of_effect += 1;
        *of_effect <= OF_ONE_EFFECT
    });
    first.extend(later);
    first.truncate(FITTED);
    first
}

/// Whether the parameters of a hypothesis came out where its physics has them: friction that drives is no
/// friction, whatever it explains, a law of speed changes within the speeds of its joint, and what begins and ends does.
fn is_possible(bench: &Bench<'_>, refit: &Refit, lead: &Lead) -> bool {
    let model = &refit.model;
    let mut own = lead.start.iter();
    let within_limits = own.all(|(name, _)| {
        model.find(name).is_ok_and(|index| {
            let parameter = &model.parameters()[index];
            (parameter.lower..=parameter.upper).contains(&refit.values[index])
        })
    });
    within_limits
        && speeds::are_reached(bench, refit, &lead.hypothesis)
        && passing::is_shorter(bench, refit, &lead.hypothesis)
}

/// Weighted sum of squares of one joint whose loss lowers its RMS error by half of what matters: what
/// promises less on the fitted rows does not matter on others.
fn least_gain(refit: &Refit) -> f64 {
    let rows = refit.train.iter().map(Vec::len).max().unwrap_or(0) as f64;
    HALF_OF_WHAT_MATTERS * rows
}

fn try_one(
    bench: &Bench<'_>,
    (before, tried): (&Refit, usize),
    lead: &Lead,
) -> Result<Trial, DiagnoseError> {
    let mut hypotheses = before.hypotheses.clone();
    hypotheses.push(lead.hypothesis.clone());
    let fit = || {
        let deviations = before.deviations();
        let from = |start: &Start| refit(bench, &hypotheses, (start, &deviations));
        let start = with(before, &lead.start);
        let mut best = from(&start)?;
        let falls_short = taken((before, &best)) < PROMISED * lead.gain;
        let wanting = falls_short || !is_possible(bench, &best, lead);
        let others = lead.others.iter().filter(|_| wanting);
        let others: Vec<Start> = others.map(|own| with(before, own)).collect();
        let all = std::iter::once(&start).chain(&others);
        let bent = all.filter_map(|start| without_shapes(before, lead, start));
        for other in others.iter().cloned().chain(bent) {
            best = better((bench, lead), best, from(&other)?);
        }
        for own in &lead.anew {
            if is_at_a_limit(&best, own) {
                let mut start = best.start();
                start.extend(own.iter().cloned());
                best = better((bench, lead), best, from(&start)?);
            }
        }
        // A richer model that fits worse was not searched well: everything else first, at the lead's own values.
        if best.fitted_score() > before.fitted_score() {
            let settled = refit_holding(bench, &hypotheses, (&start, &deviations), &lead.start)?;
            best = better((bench, lead), best, from(&settled.start())?);
        }
        Ok(best)
    };
    let refit = bench.memory.refit(&hypotheses, fit)?;
    let named = (lead.hypothesis.clone(), tried);
    Ok(compare(bench, (before, refit), named))
}

/// Sum of squares that a richer model takes from the fitted rows, in units of what the poorer leaves in a row.
fn taken((before, after): (&Refit, &Refit)) -> f64 {
    let of = |(old, new): (&Vec<f64>, &Vec<f64>)| match rms(old) {
        left if left > 0.0 => old.len() as f64 * (1.0 - (rms(new) / left).powi(2)),
        _ => 0.0,
    };
    before.train.iter().zip(&after.train).map(of).sum()
}

/// Whether one of some parameters ended at a limit of what it may be.
fn is_at_a_limit(refit: &Refit, own: &Start) -> bool {
    own.iter().any(|(name, _)| {
        refit.model.find(name).is_ok_and(|index| {
            let parameter = &refit.model.parameters()[index];
            let near = |limit: f64| {
                limit.is_finite() && (refit.values[index] - limit).abs() <= AT_LIMIT * limit.abs()
            };
            near(parameter.lower) || near(parameter.upper)
        })
    })
}

/// Values of a fit with those of a hypothesis.
fn with(before: &Refit, own: &Start) -> Start {
    let mut start = before.start();
    start.extend(own.iter().cloned());
    start
}

/// The one that fits better, or that alone is possible.
fn better((bench, lead): (&Bench<'_>, &Lead), a: Refit, b: Refit) -> Refit {
    let rank = |refit: &Refit| (!is_possible(bench, refit, lead), refit.fitted_score());
    let (of_a, of_b) = (rank(&a), rank(&b));
    match of_b.0.cmp(&of_a.0).then(of_b.1.total_cmp(&of_a.1)) {
        Ordering::Less => b,
        _ => a,
    }
}

/// The start with the nonlinear parameters of a law at the motor left where the model has them to begin with: those of
/// the poorer model may have bent to take the place of what it lacks. `None` where there are none.
fn without_shapes(before: &Refit, lead: &Lead, start: &Start) -> Option<Start> {
    let [joint] = lead.hypothesis.joints[..] else {
        return None;
    };
    if !matches!(lead.hypothesis.effect.law, Law::Motor(_)) {
        return None;
    }
    let bent = |name: &String| {
        before.model.find(name).is_ok_and(|index| {
            let parameter = &before.model.parameters()[index];
            let own = matches!(parameter.role, Role::Effect { joint: j, .. } if j == joint);
            own && parameter.is_free() && parameter.linearity == Linearity::Nonlinear
        })
    };
    let kept: Start = start
        .iter()
        .filter(|(name, _)| !bent(name))
        .cloned()
        .collect();
    (kept.len() < start.len()).then_some(kept)
}

/// The evidence for a refit that has one hypothesis more than the model before.
pub fn compare(
    bench: &Bench<'_>,
    (before, refit): (&Refit, Refit),
    (hypothesis, tried): (Hypothesis, usize),
) -> Trial {
    let pair = (before, &refit);
    // At reversals the errors of differentiation look like a delay.
    let mut evidence = match hypothesis.effect.law {
        Law::Delay => under_way(bench, pair, None),
        _ => forecast(bench, pair),
    };
    if hypothesis.effect.needs.lasts == Lasts::OneRecording {
        let residuals = (&before.validation[..], &refit.validation[..]);
        let own = of_own_parameters(residuals, hypothesis.effect.parameters.len());
        evidence.p_value = evidence.p_value.max(own);
    }
    Trial {
        p_value: (evidence.p_value * tried as f64).min(1.0),
        relief: relief(bench, &hypothesis, (before, &refit)),
        hypothesis,
        evidence,
        refit,
    }
}

/// Whether a richer model fits better than a poorer one by more than parameters without a meaning would, with
/// [`CONFIDENCE`] (Wilks 1938): held-out rows that go beyond the fitted ones may favour it by chance, where what the
/// poorer model learned too little about happens to look like one of its parameters.
pub fn fits_better((poorer, richer): (&Refit, &Refit)) -> bool {
    let freedom = richer.freedom().saturating_sub(poorer.freedom()).max(1) as f64;
    let gain = poorer.fitted_score() - richer.fitted_score();
    gain > Distribution::ChiSquared { freedom }.quantile(CONFIDENCE)
}

/// The trial to accept: of those that are significant and matter the one with the least held-out error, or
/// one with fewer parameters that is not significantly worse, or not by what matters, or fits as well.
fn choose(bench: &Bench<'_>, trials: &[Trial], significance: f64) -> Option<usize> {
    let accepted: Vec<usize> = (0..trials.len())
        .filter(|&k| trials[k].is_needed(significance))
        .collect();
    let score = |k: usize| trials[k].refit.held_out_score();
    let best = *accepted
        .iter()
        .min_by(|&&a, &&b| score(a).total_cmp(&score(b)))?;
    let as_good = accepted.iter().copied().filter(|&k| {
        k == best || {
            let pair = (&trials[k].refit, &trials[best].refit);
            let against = forecast(bench, pair);
            let richest = &trials[best].hypothesis;
            let is_poorer = pair.0.freedom() < pair.1.freedom();
            against.p_value > 1.0 - CONFIDENCE
                || is_poorer && excess(pair, &richest.named_joints()) <= MATTERS
                || is_poorer && !fits_better(pair)
                || trials[k].hypothesis.is_part_of(richest)
                    && relief(bench, richest, pair) < MATTERS
        }
    });
    as_good.min_by(|&a, &b| {
        let size = |k: usize| (trials[k].refit.freedom(), trials[k].hypothesis.joints.len());
        size(a).cmp(&size(b)).then(score(a).total_cmp(&score(b)))
    })
}

/// Drops hypotheses that the others make superfluous, the weakest first.
pub fn prune(
    bench: &Bench<'_>,
    mut refit: Refit,
    (rules, tried): (Rules<'_>, usize),
) -> Result<Refit, DiagnoseError> {
    loop {
        let dropped: Vec<Trial> = (0..refit.hypotheses.len())
            .into_par_iter()
            .map(|k| without(bench, &refit, (k, tried)))
            .collect::<Result<_, _>>()?;
        let needed = |t: &Trial| t.is_needed(rules.significance);
        let weakest = (0..dropped.len())
            .filter(|&k| !needed(&dropped[k]))
            .min_by(|&a, &b| {
                dropped[a]
                    .evidence
                    .ratio
                    .total_cmp(&dropped[b].evidence.ratio)
            });
        match weakest {
            Some(k) => {
                refit = fit_without(bench, &refit, k)?;
            }
            None => return Ok(refit),
        }
    }
}

/// The evidence for the k-th hypothesis of a model: the model against itself without it.
fn without(
    bench: &Bench<'_>,
    refit: &Refit,
    (k, tried): (usize, usize),
) -> Result<Trial, DiagnoseError> {
    let poorer = fit_without(bench, refit, k)?;
    let hypothesis = refit.hypotheses[k].clone();
    Ok(compare(
        bench,
        (&poorer, refit.clone()),
        (hypothesis, tried),
    ))
}

/// A model without its k-th hypothesis, fitted again.
pub fn fit_without(bench: &Bench<'_>, full: &Refit, k: usize) -> Result<Refit, DiagnoseError> {
    let mut hypotheses = full.hypotheses.clone();
    hypotheses.remove(k);
    let fit = || refit(bench, &hypotheses, (&full.start(), &full.deviations()));
    let models = (&hypotheses[..], &full.hypotheses[..]);
    bench.memory.refit_from(models, least_gain(full), fit)
}
