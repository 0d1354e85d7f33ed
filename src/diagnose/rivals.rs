//! Other hypotheses that explain the same misfit, and whether the held-out recordings tell them apart.

use crate::diagnose::bench::Bench;
use crate::diagnose::benches::Benches;
use crate::diagnose::conclude::channels_of;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::evidence::encompassing;
use crate::diagnose::floor::Floor;
use crate::diagnose::forecast::forecast;
use crate::diagnose::hypothesis::{self, Hypothesis};
use crate::diagnose::refit::{Refit, Start, refit};
use crate::diagnose::relief::{MATTERS, excess};
use crate::diagnose::search::{CONFIDENCE, Rules, Trial, attempt, fit_without, fits_better};
use crate::stats::distribution::Distribution;

/// A rival is told apart only if it leaves at least half as much again as the finding does, above the noise.
const IN_DOUBT: f64 = 0.5;

/// A hypothesis in the place of a finding.
#[derive(Debug, Clone)]
pub struct Alternative {
    pub trial: Trial,
    pub separation: Separation,
    /// The alternative forecasts what the finding leaves, and where it has more parameters that matters and it fits
    /// better too.
    pub better: bool,
}

/// How far recordings tell a rival from a finding.
#[derive(Debug, Clone, Copy)]
pub struct Separation {
    /// The finding forecasts what the rival leaves, or the rival's error is larger by what matters, and the difference
    /// is not small beside what neither explains.
    pub separable: bool,
    /// Recordings of fewer than so many times the length tell the two apart in one case of twenty at most, by
    /// chance: the ratio of the test grows with the root of the length. `None` where the two are the same torque.
    pub times_longer: Option<f64>,
}

/// A finding with the model that lacks it and what could stand in its place.
#[derive(Debug, Clone)]
pub struct Contest {
    pub without: Refit,
    pub alternatives: Vec<Alternative>,
}

impl Contest {
    /// The same as the rows show it that test the finding; whether a rival can be set aside, as all rows do. `full` is the
    /// model with the finding over all rows.
    pub fn on(
        &self,
        benches: &Benches<'_>,
        floor: &Floor,
        (full, finding): (&Refit, &Hypothesis),
    ) -> Self {
        let (rows, joints) = (benches.testing(finding), finding.named_joints());
        let seen = |alternative: &Alternative| {
            let (trial, whole) = (&alternative.trial, &benches.whole);
            let refit = trial.refit.on(rows);
            Alternative {
                separation: separation(whole, floor, (&trial.refit.on(whole), full), &joints),
                better: alternative.better,
                trial: Trial {
                    refit,
                    ..trial.clone()
                },
            }
        };
        Self {
            without: self.without.on(rows),
            alternatives: self.alternatives.iter().map(seen).collect(),
        }
    }
}

/// A finding in whose place there could stand what the recordings cannot set aside.
#[derive(Debug, Clone)]
pub struct Doubt {
    /// Number of the finding.
    pub finding: usize,
    pub found: Stated,
    pub rivals: Vec<Stated>,
}

/// A fitted model without what it was fitted to.
#[derive(Debug, Clone)]
pub struct Stated {
    pub hypotheses: Vec<Hypothesis>,
    pub start: Start,
}

impl Stated {
    fn of(refit: &Refit) -> Self {
        Self {
            hypotheses: refit.hypotheses.clone(),
            start: refit.start(),
        }
    }
}

/// The findings of a model that have rivals which cannot be set aside.
pub fn doubts(full: &Refit, contests: &[Contest]) -> Vec<Doubt> {
    let of = |(finding, contest): (usize, &Contest)| {
        let open = contest
            .alternatives
            .iter()
            .filter(|a| !a.separation.separable);
        let rivals: Vec<Stated> = open.map(|a| Stated::of(&a.trial.refit)).collect();
        (!rivals.is_empty()).then(|| Doubt {
            finding,
            found: Stated::of(full),
            rivals,
        })
    };
    contests.iter().enumerate().filter_map(of).collect()
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
    let trials = attempt(bench, &without, rules, &open, &[])?;
    let alternatives = trials
        .into_iter()
        .map(|trial| {
            let to_finding = forecast(bench, (full, &trial.refit));
            let its_joints = trial.hypothesis.named_joints();
            let is_no_richer = trial.refit.freedom() <= full.freedom();
            let separation = separation(bench, floor, (&trial.refit, full), &own.named_joints());
            Alternative {
                separation,
                better: to_finding.p_value * (open.len() as f64) < rules.significance
                    && trial.refit.held_out_score() < full.held_out_score()
                    && (is_no_richer
                        || excess((full, &trial.refit), &its_joints) > MATTERS
                            && fits_better((full, &trial.refit))),
                trial,
            }
        })
        .collect();
    Ok(Contest {
        without,
        alternatives,
    })
}

/// How far held-out rows tell a rival from a model, the finding of which acts on some joints.
pub fn separation(
    bench: &Bench<'_>,
    floor: &Floor,
    (rival, full): (&Refit, &Refit),
    joints: &[usize],
) -> Separation {
    let forecast = encompassing((&rival.validation, &full.validation), None, bench.samples());
    let differs = forecast.p_value < 1.0 - CONFIDENCE || excess((rival, full), joints) > MATTERS;
    let missed = Distribution::Normal.quantile(CONFIDENCE) - Distribution::Normal.quantile(0.95);
    let times = (missed / forecast.distance).powi(2);
    let leave = (&rival.validation[..], &full.validation[..]);
    // Taken as it is where the noise is not measured.
    let is_clear = !floor.measured || leaves_more(floor, leave, &channels_of(&full.model, joints));
    Separation {
        separable: differs && is_clear,
        times_longer: times.is_finite().then_some(times),
    }
}

/// Whether a rival leaves more above the noise than a model does in one of some channels, by half of that at least: what
/// neither explains tilts the comparison of the two as much as their physics.
pub fn leaves_more(
    floor: &Floor,
    (rival, model): (&[Vec<f64>], &[Vec<f64>]),
    channels: &[usize],
) -> bool {
    let of = |c: &usize| {
        let lack = |residuals: &[Vec<f64>]| floor.lack_of_fit(residuals, &[*c]);
        lack(rival) - lack(model) > IN_DOUBT * (lack(model) - 1.0).max(0.0)
    };
    channels.iter().any(of)
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
