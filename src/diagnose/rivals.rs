//! Other hypotheses that explain the same misfit, and whether the held-out recordings tell them apart.

use crate::diagnose::bench::Bench;
use crate::diagnose::conclude::channels_of;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::evidence::encompassing;
use crate::diagnose::floor::Floor;
use crate::diagnose::hypothesis;
use crate::diagnose::refit::{Refit, refit};
use crate::diagnose::rows::rms;
use crate::diagnose::search::{CONFIDENCE, MATTERS, Rules, Trial, attempt, fit_without};

/// A rival is told apart only if it leaves at least half as much again as the finding does, above the noise.
const IN_DOUBT: f64 = 0.5;

/// A hypothesis in the place of a finding.
#[derive(Debug, Clone)]
pub struct Alternative {
    pub trial: Trial,
    /// The finding forecasts what the alternative leaves, or the alternative's error is larger by what matters, and
    /// the difference is not small beside what neither explains.
    pub separable: bool,
    /// The alternative forecasts what the finding leaves.
    pub better: bool,
}

/// A finding with the model that lacks it and what could stand in its place.
#[derive(Debug, Clone)]
pub struct Contest {
    pub without: Refit,
    pub alternatives: Vec<Alternative>,
}

/// Tries the leading hypotheses in the place of the k-th.
pub fn contest(
    bench: &Bench<'_>,
    full: &Refit,
    (k, rules, floor): (usize, Rules<'_>, &Floor),
) -> Result<Contest, DiagnoseError> {
    let without = fit_without(bench, full, k)?;
    let own = &full.hypotheses[k];
    let open: Vec<_> = hypothesis::open(
        (&without.model, &without.prior),
        (rules.sought, bench.in_time),
    )
    .into_iter()
    .filter(|h| h != own && !h.overlaps(own))
    .collect();
    let trials = attempt(bench, &without, (rules, &open))?;
    let alternatives = trials
        .into_iter()
        .map(|trial| {
            let to_rival = encompassing(&trial.refit.validation, &full.validation);
            let to_finding = encompassing(&full.validation, &trial.refit.validation);
            let joints = own.named_joints();
            let differs = to_rival.p_value < 1.0 - CONFIDENCE
                || excess(&trial.refit, full, &joints) > MATTERS;
            Alternative {
                separable: differs && leaves_more(floor, (&trial.refit, full), &joints),
                better: to_finding.p_value * (open.len() as f64) < rules.significance
                    && trial.refit.held_out_score() < full.held_out_score(),
                trial,
            }
        })
        .collect();
    Ok(Contest {
        without,
        alternatives,
    })
}

/// Share by which a rival's held-out RMS error exceeds a model's, the largest over the joints.
fn excess(rival: &Refit, full: &Refit, joints: &[usize]) -> f64 {
    let of = |&j: &usize| match (rival.validation.get(j), full.validation.get(j)) {
        (Some(rival), Some(full)) if !full.is_empty() => rms(rival) / rms(full) - 1.0,
        _ => 0.0,
    };
    joints.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
}

/// Whether a rival leaves more above the noise than a model does, by [`IN_DOUBT`] of that: what neither explains tilts
/// the comparison of the two as much as their physics. Taken as it is where the noise is not measured.
fn leaves_more(floor: &Floor, (rival, full): (&Refit, &Refit), joints: &[usize]) -> bool {
    let of = |c: usize| {
        let lack = |refit: &Refit| floor.lack_of_fit(&refit.validation, &[c]);
        lack(rival) - lack(full) > IN_DOUBT * (lack(full) - 1.0).max(0.0)
    };
    !floor.measured || channels_of(&full.model, joints).into_iter().any(of)
}

/// The model with the best alternative in the place of the k-th hypothesis, if one is better.
pub fn exchange(
    bench: &Bench<'_>,
    (contest, k): (&Contest, usize),
) -> Result<Option<Refit>, DiagnoseError> {
    let better = contest.alternatives.iter().filter(|a| a.better);
    let score = |a: &&Alternative| a.trial.refit.held_out_score();
    let Some(best) = better.min_by(|a, b| score(a).total_cmp(&score(b))) else {
        return Ok(None);
    };
    let mut hypotheses = best.trial.refit.hypotheses.clone();
    if let Some(last) = hypotheses.pop() {
        hypotheses.insert(k.min(hypotheses.len()), last);
    }
    let found = &best.trial.refit;
    refit(bench, &hypotheses, (&found.start(), &found.deviations())).map(Some)
}
