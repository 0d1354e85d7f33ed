//! Grows the model one hypothesis at a time, then drops each on trial.

use crate::chain::effect::{Law, Linearity};
use crate::chain::parameter::Role;
use crate::diagnose::bench::Bench;
use crate::diagnose::clear;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::evidence::{Evidence, encompassing};
use crate::diagnose::hypothesis::{self, Hypothesis};
use crate::diagnose::refit::{Refit, Start, refit, refit_holding};
use crate::diagnose::rows::rms;
use crate::diagnose::screen::{Lead, leads};
use crate::recording::split::Split;
use rayon::prelude::*;

/// What a search looks for and how sure it has to be.
#[derive(Debug, Clone, Copy)]
pub struct Rules<'a> {
    /// Effects to look for; all if `None`.
    pub sought: Option<&'a [String]>,
    /// Probability of a false finding after correction.
    pub significance: f64,
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
}

/// An effect matters where it lowers the held-out RMS error of a joint by this share.
pub const MATTERS: f64 = 0.01;

/// An effect that takes less than this share of the RMS signal of every joint is negligible.
pub const OF_TORQUE: f64 = 0.002;

/// An effect that takes less than this many times the RMS noise of a row is negligible: what the errors of
/// differentiation leave at reversals reaches a quarter of the variance of the noise, to which bandwidths are chosen.
pub const OF_NOISE: f64 = 0.5;

/// Hypotheses fitted exactly in one step.
const FITTED: usize = 8;

/// Effects that a model can be given; more at once were never told apart.
const MOST_FINDINGS: usize = 8;

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
    while grown.steps.len() < MOST_FINDINGS && !bench.control.is_interrupted() {
        watch(grown.steps.len());
        let open = hypothesis::open(
            (&grown.refit.model, &grown.refit.prior),
            (rules.sought, bench.in_time),
        );
        if grown.steps.is_empty() {
            grown.examined = open.len();
        }
        let mut trials = attempt(bench, &grown.refit, (rules, &open))?;
        let best = choose(&trials, rules.significance);
        let score = grown.refit.held_out_score();
        if let Some(best) = best {
            trials.swap(0, best);
            grown.refit = trials[0].refit.clone();
        }
        grown.steps.push(Step {
            trials,
            score,
            accepted: best.is_some(),
        });
        if best.is_none() {
            break;
        }
    }
    Ok(grown)
}

/// Fits the leading hypotheses exactly beside what a model has.
pub fn attempt(
    bench: &Bench<'_>,
    refit: &Refit,
    (rules, open): (Rules<'_>, &[Hypothesis]),
) -> Result<Vec<Trial>, DiagnoseError> {
    let least = least_gain(refit);
    let all = || hypothesis::open((&refit.model, &refit.prior), (rules.sought, bench.in_time));
    let find = || leads(bench, refit, &all());
    let mut leads = bench.memory.leads(&refit.hypotheses, find)?;
    leads.retain(|lead| lead.gain >= least && open.contains(&lead.hypothesis));
    leads.truncate(FITTED);
    let tried = leads.par_iter().filter_map(|lead| {
        // A hypothesis that cannot be fitted is no hypothesis.
        let trial = try_one(bench, (refit, open.len()), lead).ok()?;
        is_possible(&trial, lead).then_some(trial)
    });
    let trials: Vec<Trial> = tried.collect();
    Ok(trials)
}

/// Whether the parameters of a hypothesis came out where its physics has them: friction that drives is no
/// friction, whatever it explains.
fn is_possible(trial: &Trial, lead: &Lead) -> bool {
    let model = &trial.refit.model;
    lead.start.iter().all(|(name, _)| {
        model.find(name).is_ok_and(|index| {
            let parameter = &model.parameters()[index];
            (parameter.lower..=parameter.upper).contains(&trial.refit.values[index])
        })
    })
}

/// Weighted sum of squares of one joint whose loss lowers its RMS error by half of what matters: what
/// promises less on the fitted rows does not matter on others.
fn least_gain(refit: &Refit) -> f64 {
    let rows = refit.train.iter().map(Vec::len).max().unwrap_or(0) as f64;
    0.5 * (1.0 - (1.0 - MATTERS).powi(2)) * rows
}

fn try_one(
    bench: &Bench<'_>,
    (before, tried): (&Refit, usize),
    lead: &Lead,
) -> Result<Trial, DiagnoseError> {
    let mut hypotheses = before.hypotheses.clone();
    hypotheses.push(lead.hypothesis.clone());
    let mut start = before.start();
    start.extend(lead.start.iter().cloned());
    let anew = without_shapes(before, lead, &start);
    let fit = || {
        let deviations = before.deviations();
        let from = |start: &Start| refit(bench, &hypotheses, (start, &deviations));
        let mut best = from(&start)?;
        if let Some(anew) = &anew {
            best = better(best, from(anew)?);
        }
        // A richer model that fits worse was not searched well: everything else first, at the lead's own values.
        if best.fitted_score() > before.fitted_score() {
            let settled = refit_holding(bench, &hypotheses, (&start, &deviations), &lead.start)?;
            best = better(best, from(&settled.start())?);
        }
        Ok(best)
    };
    let refit = bench.memory.refit(&hypotheses, fit)?;
    let named = (lead.hypothesis.clone(), tried);
    Ok(compare(bench, (before, refit), named))
}

/// The one that fits better.
fn better(a: Refit, b: Refit) -> Refit {
    if b.fitted_score() < a.fitted_score() {
        b
    } else {
        a
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
    let evidence = encompassing(&before.validation, &refit.validation);
    Trial {
        p_value: (evidence.p_value * tried as f64).min(1.0),
        relief: relief(bench, &hypothesis, (before, &refit)),
        hypothesis,
        evidence,
        refit,
    }
}

/// Largest share by which the held-out RMS error of a joint falls where the effect is worth the name: what it
/// takes away has to be [`OF_TORQUE`] of the signal itself and [`OF_NOISE`] of the noise, and where it filters the
/// motion only what it takes from frequencies at which that stands clear of its noise counts.
fn relief(bench: &Bench<'_>, hypothesis: &Hypothesis, (before, after): (&Refit, &Refit)) -> f64 {
    let held_out = bench.recordings(Split::Validation);
    let filters = matches!(hypothesis.effect.law, Law::Spring);
    let band = filters.then(|| clear::band(bench, hypothesis));
    let left = |residual: &[f64]| match band {
        Some(band) => clear::rms(residual, band),
        None => rms(residual),
    };
    let of = |c: usize| {
        let (old, new) = (left(&before.validation[c]), left(&after.validation[c]));
        let taken = (old * old - new * new).max(0.0).sqrt();
        let signals = held_out.iter().flat_map(|r| r.signal(c)).copied();
        let signal = rms(&signals.collect::<Vec<f64>>());
        let noise = bench.noise.as_ref().map_or(0.0, |noise| noise[c]);
        (taken >= (OF_TORQUE * signal).max(OF_NOISE * noise)).then_some(1.0 - new / old)
    };
    let channels = (0..before.validation.len()).filter(|&c| !before.validation[c].is_empty());
    channels.filter_map(of).fold(0.0, f64::max)
}

/// The trial to accept: of those that are significant and matter the one with the least held-out error, or
/// one with fewer parameters that is not significantly worse.
fn choose(trials: &[Trial], significance: f64) -> Option<usize> {
    let accepted: Vec<usize> = (0..trials.len())
        .filter(|&k| trials[k].p_value < significance && trials[k].relief >= MATTERS)
        .collect();
    let score = |k: usize| trials[k].refit.held_out_score();
    let best = *accepted
        .iter()
        .min_by(|&&a, &&b| score(a).total_cmp(&score(b)))?;
    let as_good = accepted.iter().copied().filter(|&k| {
        k == best || {
            let against = encompassing(&trials[k].refit.validation, &trials[best].refit.validation);
            against.p_value > 1.0 - CONFIDENCE
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
) -> Result<(Refit, Vec<Trial>), DiagnoseError> {
    loop {
        let dropped: Vec<Trial> = (0..refit.hypotheses.len())
            .into_par_iter()
            .map(|k| without(bench, &refit, (k, tried)))
            .collect::<Result<_, _>>()?;
        let needed = |t: &Trial| t.p_value < rules.significance && t.relief >= MATTERS;
        let weakest = (0..dropped.len())
            .filter(|&k| !needed(&dropped[k]))
            .min_by(|&a, &b| {
                dropped[a]
                    .evidence
                    .ratio
                    .total_cmp(&dropped[b].evidence.ratio)
            });
        match weakest {
            Some(k) if dropped.len() > 1 => {
                refit = fit_without(bench, &refit, k)?;
            }
            _ => return Ok((refit, dropped)),
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
    bench.memory.refit_from(models, fit)
}
